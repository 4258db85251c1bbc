//! The WebSocket: state, log, images with credit; slow pages delay nobody.
#![forbid(unsafe_code)]

mod common;

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use common::{encode_all, image, until, Site, LONG};
use rcs_web::{Limits, LogLine};
use serde_json::json;

fn line(id: u64) -> LogLine {
    LogLine { id, time_secs: 1.5, level: "warn", text: format!("line {id}") }
}

#[test]
fn a_page_gets_the_state_at_once_and_soon_after_changes() {
    let site = Site::start();
    let mut page = site.page();
    assert_eq!(page.text("state")["posts"], 0);
    assert_eq!(site.post("save", "{}").0, 200);
    while page.text("state")["posts"] == 0 {}
    let mut second = site.page();
    assert_eq!(second.text("state")["posts"], 1);
    assert!(site.pages.is_any_open());
    drop((page, second));
    until(|| !site.pages.is_any_open());
}

#[test]
fn a_page_gets_the_logs_last_lines_and_then_the_new_ones() {
    let site = Site::start();
    site.operator.log.lock().unwrap().extend([line(1), line(2)]);
    let mut page = site.page();
    let expected = |id: u64| json!({"id": id, "time": 1.5, "level": "warn", "text": format!("line {id}")});
    assert_eq!(page.text("log")["lines"], json!([expected(1), expected(2)]));
    site.operator.log.lock().unwrap().push(line(3));
    site.pages.log_changed();
    assert_eq!(page.text("log")["lines"], json!([expected(3)]));
}

#[test]
fn an_image_is_sent_for_each_credit() {
    let site = Site::start();
    encode_all(&site.pages);
    let mut page = site.watching_page();
    let changes = site.operator.watchers_changed.load(Ordering::Acquire);
    assert!(changes >= 2, "{changes}");
    let images = site.pages.images();
    images.offer("proj", || image(1, 10));
    let (head, len) = page.image();
    let expected = json!({
        "type": "image", "camera": "proj", "format": "png", "width": 2, "height": 1, "full_width": 4, "full_height": 2,
        "stamp": 1.0
    });
    assert_eq!((head, len), (expected, 10));
    images.offer("proj", || image(2, 10));
    images.offer_mask("proj", || image(3, 10));
    let (mask, _) = page.image();
    assert_eq!((&mask["type"], &mask["stamp"]), (&json!("mask"), &json!(3.0)), "it has no credit");
    images.offer("proj", || image(4, 10));
    page.send(r#"{"type":"ready"}"#);
    assert_eq!(page.image().0["stamp"], 4.0, "the newest one");
}

#[test]
fn a_page_that_stalls_delays_nobody_and_is_closed() {
    let site = Site::with_limits(Limits { send: Duration::from_secs(1), ..Limits::default() });
    encode_all(&site.pages);
    let (stalled, mut page) = (site.watching_page(), site.watching_page());
    let images = site.pages.images();
    let mut number = 0;
    while site.operator.watchers_changed.load(Ordering::Acquire) < 5 {
        number += 1;
        assert!(number < 1000, "the stalled page is not closed");
        // More than the buffers of a connection hold.
        images.offer("proj", move || image(number, 8 << 20));
        assert_eq!(page.image().1, 8 << 20);
        page.send(r#"{"type":"ready"}"#);
        assert_eq!(site.post("blackout", "{}").0, 200);
    }
    drop(stalled);
}

#[test]
fn black_on_the_socket_is_carried_out_while_an_image_waits_to_be_sent() {
    let site = Site::with_limits(Limits { send: LONG, ..Limits::default() });
    encode_all(&site.pages);
    let mut page = site.watching_page();
    // More than the buffers of a connection hold, and nobody reads it.
    site.pages.images().offer("proj", || image(1, 64 << 20));
    std::thread::sleep(Duration::from_millis(300));
    page.send(r#"{"type":"black","camera":null}"#);
    page.send(r#"{"type":"black","camera":"proj","on":false}"#);
    until(|| site.operator.posts.lock().unwrap().len() == 2);
    let expected = ["null", r#""proj""#]
        .map(|camera| format!(r#"blackout {{"camera":{camera},"on":true}} by the page at 127.0.0.1"#));
    assert_eq!(*site.operator.posts.lock().unwrap(), expected);
    assert_eq!(page.image().1, 64 << 20, "the image goes on");
    while page.text("state")["posts"] != 2 {}
}

#[test]
fn a_silent_page_is_closed_and_one_that_answers_pings_stays() {
    let (ping, silence) = (Duration::from_millis(100), Duration::from_millis(600));
    let site = Site::with_limits(Limits { ping, silence, ..Limits::default() });
    let silent = site.page();
    let mut page = site.page();
    until(|| {
        // Pings are answered while the page reads.
        page.text("state");
        site.operator.watchers_changed.load(Ordering::Acquire) >= 3
    });
    page.text("state");
    assert!(site.pages.is_any_open());
    drop(silent);
}

#[test]
fn a_blackout_waits_for_no_other_request() {
    let site = Site::start();
    std::thread::scope(|scope| {
        let waiting: Vec<_> = (0..12).map(|_| scope.spawn(|| site.post("wait", "{}").0)).collect();
        // More of them than may wait are refused.
        until(|| waiting.iter().filter(|request| request.is_finished()).count() == 4);
        assert_eq!(site.post("blackout", "{}").0, 200);
        *site.operator.is_released.lock().unwrap() = true;
        site.operator.released.notify_all();
        let mut statuses: Vec<u16> = waiting.into_iter().map(|request| request.join().unwrap()).collect();
        statuses.sort_unstable();
        assert_eq!(statuses, [&[200; 8][..], &[503; 4]].concat());
    });
}

#[test]
fn what_is_no_message_of_a_page_ends_the_connection() {
    let site = Site::start();
    let ends = |first: u8, payload: &[u8]| {
        let mut page = site.page();
        page.send_frame(first, payload);
        while page.next().is_some() {}
    };
    ends(0x81, b"no JSON");
    ends(0x81, br#"{"type":"other"}"#);
    ends(0x82, b"binary");
    ends(0x81, &[b' '; 40_000]);
    ends(0x83, b"a reserved opcode");
    ends(0x81, &[0xff; 4]);
    until(|| !site.pages.is_any_open());
}

#[test]
fn pages_come_back_after_a_restart() {
    let mut site = Site::start();
    let mut page = site.page();
    page.text("state");
    site.restart();
    while page.next().is_some() {}
    assert!(site.page().text("state").is_object());
}

#[test]
fn twenty_pages_share_one_encoded_image() {
    let site = Site::start();
    encode_all(&site.pages);
    let mut pages: Vec<_> = (0..20).map(|_| site.watching_page()).collect();
    let encoded = std::sync::Arc::new(std::sync::atomic::AtomicUsize::new(0));
    let counted = std::sync::Arc::clone(&encoded);
    site.pages.images().offer("proj", move || {
        counted.fetch_add(1, Ordering::AcqRel);
        image(1, 100)
    });
    assert!(pages.iter_mut().all(|page| page.image().1 == 100));
    assert_eq!(encoded.load(Ordering::Acquire), 1);
    let begun = Instant::now();
    drop(pages);
    until(|| !site.pages.is_any_open());
    assert!(begun.elapsed() < LONG);
}
