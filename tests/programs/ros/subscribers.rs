//! Subscribers that read slowly, stop, or leave: nobody pays for another.

use crate::probe;
use crate::raw::{read_framed, subscribe};
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE, PROMPT};
use std::io::Read;
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

const TOPIC: &str = "/view/image";
const RATE: u32 = 20;
const IMAGE_BYTES: usize = 1280 * 800 * 3;
/// How long others are beside a good viewer.
const BESIDE: Duration = Duration::from_secs(5);

fn images(master: &RosMaster) -> Running {
    let publisher = probe(master, &["image", TOPIC, "1280", "800", &RATE.to_string()]);
    assert!(publisher.line_with("ready").is_some(), "{:?}", publisher.errors());
    publisher
}

/// An image's sequence number, which its message begins with.
fn seq(message: &[u8]) -> u32 {
    u32::from_le_bytes([message[0], message[1], message[2], message[3]])
}

/// How long ago an image was published: its stamp follows the sequence number.
fn latency(message: &[u8]) -> Duration {
    let [secs, nanos] = [4, 8].map(|at| u32::from_le_bytes(std::array::from_fn(|index| message[at + index])));
    let stamp = SystemTime::UNIX_EPOCH + Duration::new(secs.into(), nanos);
    SystemTime::now().duration_since(stamp).unwrap_or_default()
}

/// An image as it arrived.
struct Seen {
    at: Instant,
    seq: u32,
    latency: Duration,
}

/// Reads images as they come, and notes when.
struct Viewer {
    seen: Arc<Mutex<Vec<Seen>>>,
    is_ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Viewer {
    fn start(mut stream: TcpStream) -> Self {
        let (seen, is_ended): (Arc<Mutex<Vec<_>>>, Arc<AtomicBool>) = Default::default();
        let (notes, end) = (Arc::clone(&seen), Arc::clone(&is_ended));
        let thread = std::thread::spawn(move || {
            while !end.load(Ordering::Acquire) {
                let Ok(message) = read_framed(&mut stream) else { return };
                let seen = Seen { at: Instant::now(), seq: seq(&message), latency: latency(&message) };
                notes.lock().unwrap().push(seen);
            }
        });
        Self { seen, is_ended, thread: Some(thread) }
    }

    /// How many images it has seen since a moment. They and the longest time between two of them are printed.
    fn count_since(&self, begin: Instant) -> usize {
        let all = self.seen.lock().unwrap();
        let seen: Vec<&Seen> = all.iter().filter(|seen| seen.at >= begin).collect();
        let longest_gap = seen.windows(2).map(|pair| pair[1].at - pair[0].at).max().unwrap_or(begin.elapsed());
        let mut latencies: Vec<Duration> = seen.iter().map(|seen| seen.latency).collect();
        latencies.sort();
        let (count, latency) = (seen.len(), latencies.get(latencies.len() / 2));
        println!(
            "{:.0?}: {count} pictures, at most {longest_gap:.1?} apart, median latency {latency:.1?}",
            begin.elapsed()
        );
        assert!(longest_gap < PROMPT, "{longest_gap:?} without a picture");
        count
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.is_ended.store(true, Ordering::Release);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Reads at this rate, in bytes per second, until the connection ends or this is dropped.
struct SlowReader {
    is_ended: Arc<AtomicBool>,
    bytes: Arc<AtomicUsize>,
}

impl SlowReader {
    fn start(mut stream: TcpStream, bytes_per_s: usize) -> Self {
        let (is_ended, bytes): (Arc<AtomicBool>, Arc<AtomicUsize>) = Default::default();
        let (end, count) = (Arc::clone(&is_ended), Arc::clone(&bytes));
        std::thread::spawn(move || {
            let mut piece = vec![0; bytes_per_s / 50];
            while !end.load(Ordering::Acquire) && stream.read_exact(&mut piece).is_ok() {
                count.fetch_add(piece.len(), Ordering::AcqRel);
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        Self { is_ended, bytes }
    }

    fn images(&self) -> usize {
        self.bytes.load(Ordering::Acquire) / IMAGE_BYTES
    }
}

impl Drop for SlowReader {
    fn drop(&mut self) {
        self.is_ended.store(true, Ordering::Release);
    }
}

/// Fails when a good viewer does not see many more images than those beside it, of which these are the images.
fn assert_undisturbed<T>(master: &RosMaster, others: impl FnOnce() -> T, images: impl Fn(&T) -> usize) {
    let good = Viewer::start(subscribe(master, "/probe", TOPIC, "/good"));
    let begin = Instant::now();
    std::thread::sleep(BESIDE / 2);
    good.count_since(begin);
    let present = others();
    let (begin, before) = (Instant::now(), images(&present));
    std::thread::sleep(BESIDE);
    let (beside, of_others) = (good.count_since(begin), images(&present) - before);
    println!("the others saw up to {of_others}");
    assert!(beside > 2 * of_others, "{beside} and {of_others} pictures");
}

#[test]
fn slow_and_stopped_viewers_cost_the_others_nothing() {
    let master = RosMaster::start().unwrap();
    let publisher = images(&master);
    let others = || {
        let slow = [1_000_000, 10_000_000]
            .map(|rate| SlowReader::start(subscribe(&master, "/probe", TOPIC, &format!("/reads_{rate}")), rate));
        let stopped = [0, 1, 2, 3, 4].map(|index| subscribe(&master, "/probe", TOPIC, &format!("/stopped_{index}")));
        assert!(publisher.prints_again("to 8 in"));
        (slow, stopped)
    };
    assert_undisturbed(&master, others, |(slow, _)| slow.iter().map(SlowReader::images).max().unwrap());
}

/// Subscribes until it is dropped.
struct Subscribed<'a>(&'a PythonNode);

impl Drop for Subscribed<'_> {
    fn drop(&mut self) {
        // A test that fails may have ended the node.
        let _ = self.0.run("images.unregister()");
    }
}

#[test]
fn a_rospy_viewer_that_takes_long_for_each_image_costs_the_others_nothing() {
    let master = RosMaster::start().unwrap();
    let _publisher = images(&master);
    let slow = PythonNode::start(&master, &["__name:=slow"]).unwrap();
    slow.run("times = []\ndef see(image):\n    times.append(time.monotonic())\n    time.sleep(0.3)").unwrap();
    let others = || {
        slow.run(format!("images = rospy.Subscriber('{TOPIC}', Image, see, queue_size=1, buff_size=1 << 24)")).unwrap();
        assert!(slow.wait_for(PATIENCE, "len(times) > 1"));
        Subscribed(&slow)
    };
    let count = |slow: &Subscribed<'_>| slow.0.run("len(times)").unwrap().parse().unwrap();
    assert_undisturbed(&master, others, count);
}

/// Number of images that the kernel may hold whole for a viewer that does not read: they fill the buffer of the
/// viewer's side, which grows up to a limit of the system while the viewer reads much, and the node's (512 kB, which
/// Linux doubles).
fn held_by_kernel(image_bytes: usize) -> usize {
    let limits = std::fs::read_to_string("/proc/sys/net/ipv4/tcp_rmem").unwrap();
    let longest: usize = limits.split_whitespace().last().unwrap().parse().unwrap();
    (longest + 2 * 512 * 1024) / image_bytes
}

#[test]
fn a_stopped_viewer_is_never_cut_and_goes_on_with_the_newest_image() {
    let master = RosMaster::start().unwrap();
    let _publisher = images(&master);
    let good = Viewer::start(subscribe(&master, "/probe", TOPIC, "/good"));
    // One that has watched for a while, and one that has not read an image yet: its buffers are small.
    let mut watched = subscribe(&master, "/probe", TOPIC, "/watched");
    let bytes = (0..40).map(|_| read_framed(&mut watched).unwrap().len()).max().unwrap();
    let unwatched = subscribe(&master, "/probe", TOPIC, "/unwatched");
    let latest = || good.seen.lock().unwrap().last().unwrap().seq;
    let before = latest();
    // Many more than are held for it.
    let are_missed = || latest() > before + 80;
    assert!(wait_until(PATIENCE, are_missed), "{before} {}", latest());
    for (name, mut stopped, most) in [("unwatched", unwatched, 1), ("watched", watched, 1 + held_by_kernel(bytes))] {
        // One before that is in all queues.
        let newest = latest() - 1;
        let begin = Instant::now();
        let old = std::iter::repeat_with(|| seq(&read_framed(&mut stopped).unwrap())).take_while(|seq| *seq < newest);
        // What the kernel had, of which the last one was being sent; then the one in the queue.
        let old: Vec<u32> = old.collect();
        let (count, took) = (old.len(), begin.elapsed());
        println!("{name}: {count} old pictures of at most {most}, a new one after {took:.0?}");
        assert!(count <= most, "{name}: {old:?} before {newest}");
    }
}

#[test]
fn fifty_viewers_are_served() {
    let master = RosMaster::start().unwrap();
    let publisher = probe(&master, &["image", TOPIC, "320", "200", &RATE.to_string()]);
    assert!(publisher.line_with("ready").is_some());
    let viewers: Vec<Viewer> =
        (0..50).map(|index| Viewer::start(subscribe(&master, "/probe", TOPIC, &format!("/viewer{index}")))).collect();
    assert!(publisher.prints_again("to 50 in"));
    let begin = Instant::now();
    let have_seen = |count: usize| viewers.iter().all(|viewer| viewer.seen.lock().unwrap().len() > count);
    assert!(wait_until(PATIENCE, || have_seen(60)), "one sees no pictures");
    for viewer in &viewers {
        viewer.count_since(begin);
    }
}
