//! Who may use the server, and requests that are none.
#![forbid(unsafe_code)]

mod common;

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::TcpStream;
use std::time::Duration;

use common::{response, until, Site, LONG};
use rcs_web::Limits;
use serde_json::json;

#[test]
fn the_pages_files_need_no_token_and_allow_nothing_from_elsewhere() {
    let site = Site::start();
    for (path, kind) in
        [("/", "text/html"), ("/page.js", "text/javascript"), ("/page.css", "text/css"), ("/?x", "text/html")]
    {
        let (status, text) = site.request(&format!("GET {path}"), &["Host: localhost"], "");
        assert_eq!(status, 200, "{path}: {text}");
        let head = text.to_lowercase();
        assert!(head.contains(&format!("content-type: {kind}")), "{path}: {text}");
        for header in ["default-src 'self'", "frame-ancestors 'none'", "nosniff", "no-referrer", "no-store"] {
            assert!(head.contains(header), "{header}: {text}");
        }
        assert!(!text.contains(&site.token));
    }
    let mut all = 0;
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/page")).unwrap() {
        let entry = entry.unwrap();
        all += entry.metadata().unwrap().len();
        let name = entry.file_name().into_string().unwrap().replace("index.html", "");
        assert_eq!(site.request(&format!("GET /{name}"), &["Host: localhost"], "").0, 200, "{name} is not served");
    }
    assert!(all <= 150_000, "{all} bytes");
}

#[test]
fn other_paths_and_methods_lead_nowhere() {
    let site = Site::start();
    let host = ["Host: localhost"];
    for path in [
        "/../../etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/page/../page.js",
        "//page.js",
        "/page.js/",
        "/PAGE.JS",
        "/api",
    ] {
        assert_eq!(site.request(&format!("GET {path}"), &host, "").0, 404, "{path}");
    }
    for line in ["POST /", "PUT /page.js", "GET /api/blackout", "POST /api/stream", "OPTIONS /api/blackout"] {
        assert_eq!(site.request(line, &host, "").0, 405, "{line}");
    }
    assert_eq!(site.request("HEAD /", &host, "").0, 200);
}

#[test]
fn the_api_needs_the_token() {
    let site = Site::start();
    let kind = "Content-Type: application/json";
    let wrong = format!("Authorization: Bearer {}", "0".repeat(32));
    let almost = format!("Authorization: Bearer {}", &site.token[..31]);
    for headers in
        [&["Host: localhost", kind][..], &["Host: localhost", kind, &wrong], &["Host: localhost", kind, &almost]]
    {
        assert_eq!(site.request("POST /api/blackout", headers, r#"{"on":true}"#).0, 401, "{headers:?}");
    }
    for protocols in ["rcs", "rcs, token.", "rcs, token.00000000000000000000000000000000"] {
        let protocols = format!("Sec-WebSocket-Protocol: {protocols}");
        assert_eq!(site.handshake(&["Host: localhost", &protocols]).0, 401, "{protocols}");
    }
    assert_eq!(site.handshake(&["Host: localhost"]).0, 401);
    assert!(site.operator.posts.lock().unwrap().is_empty() && !site.pages.is_any_open());
    let (status, answer) = site.post("blackout", r#"{"on":true}"#);
    assert_eq!((status, answer), (200, json!({"ok": true, "message": "blackout done"})));
    assert_eq!(*site.operator.posts.lock().unwrap(), [r#"blackout {"on":true} by the page at 127.0.0.1"#]);
}

#[test]
fn foreign_names_and_sites_are_refused() {
    let site = Site::start();
    let get = |host: &str| site.request("GET /", &[&format!("Host: {host}")], "").0;
    for known in ["localhost:1", "127.0.0.1", "[::1]:8080", "Robot.local:8080"] {
        assert_eq!(get(known), 200, "{known}");
    }
    for foreign in ["evil.example", "evil.example:80", "robot.local.evil.example"] {
        assert_eq!(get(foreign), 403, "{foreign}");
    }
    assert_eq!(site.request("GET /", &[], "").0, 400);
    assert_eq!(site.request("GET /", &["Host: localhost", "Host: evil.example"], "").0, 400);
    let bearer = format!("Authorization: Bearer {}", site.token);
    let protocols = format!("Sec-WebSocket-Protocol: rcs, token.{}", site.token);
    for (origin, is_own) in [("http://localhost", true), ("http://evil.example", false), ("null", false)] {
        let origin = format!("Origin: {origin}");
        let headers = ["Host: localhost", &origin, &bearer, "Content-Type: application/json"];
        let expected = if is_own { [200, 101] } else { [403, 403] };
        let posted = site.request("POST /api/blackout", &headers, "{}").0;
        assert_eq!([posted, site.handshake(&["Host: localhost", &origin, &protocols]).0], expected, "{origin}");
    }
}

#[test]
fn requests_that_cannot_be_used_say_why() {
    let site = Site::start();
    let post = |name, body| {
        let (status, answer) = site.post(name, body);
        (status, answer["message"].as_str().unwrap_or_default().to_owned())
    };
    assert_eq!(post("invalid", "{}"), (400, "on: no boolean".to_owned()));
    assert_eq!(post("fail", "{}"), (409, "not possible".to_owned()));
    assert_eq!(post("other", "{}"), (404, "there is no request 'other'".to_owned()));
    assert_eq!(post("blackout", "[]"), (400, "the body is no JSON object".to_owned()));
    assert_eq!(post("blackout", "{").0, 400);
    assert_eq!(post("panic", "{}"), (409, "the request failed; see the node's log".to_owned()));
    let bearer = format!("Authorization: Bearer {}", site.token);
    let form = ["Host: localhost", &bearer, "Content-Type: text/plain"];
    assert_eq!(site.request("POST /api/blackout", &form, "{}").0, 415);
    assert_eq!(post("save", "{}").0, 200);
}

#[test]
fn malformed_requests_are_refused_and_cost_nobody_else_anything() {
    let site = Site::start();
    for request in [
        &b"\0\x01\x02\xff\xfe"[..],
        b"GET\r\n\r\n",
        b"GET / HTTP/9.9\r\nHost: localhost\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost localhost\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n",
        b"POST /api/blackout HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\nTransfer-Encoding: x\r\n\r\n",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
    ] {
        let status = site.raw(request).0;
        assert!(matches!(status, 0 | 400..=499), "{}: {status}", String::from_utf8_lossy(request));
    }
    let many = format!("GET / HTTP/1.1\r\nHost: localhost\r\n{}\r\n", "A: b\r\n".repeat(1000));
    let long = format!("GET / HTTP/1.1\r\nHost: localhost\r\nA: {}\r\n\r\n", "b".repeat(100_000));
    for request in [many, long] {
        assert!(matches!(site.raw(request.as_bytes()).0, 0 | 431));
    }
    assert_eq!(site.request("GET /", &["Host: localhost"], "").0, 200);
}

#[test]
fn huge_bodies_are_refused_before_they_are_read() {
    let site = Site::start();
    let head = format!(
        "POST /api/save HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {}\r\nContent-Type: application/json\r\n",
        site.token
    );
    let announced = site.raw(format!("{head}Content-Length: 100000000000\r\n\r\n").as_bytes());
    assert_eq!(announced.0, 413, "{}", announced.1);
    let chunk = format!("8000\r\n{}\r\n", " ".repeat(0x8000));
    let streamed = site.raw(format!("{head}Transfer-Encoding: chunked\r\n\r\n{}", chunk.repeat(3)).as_bytes());
    assert_eq!(streamed.0, 413, "{}", streamed.1);
    assert!(site.operator.posts.lock().unwrap().is_empty());
}

#[test]
fn slow_headers_and_bodies_end_the_connection() {
    let short = Duration::from_millis(200);
    let site = Site::with_limits(Limits { headers: short, body: short, ..Limits::default() });
    let mut slow = site.connect();
    slow.write_all(b"GET / HTTP/1.1\r\nHost: local").unwrap();
    // Neither does a byte now and then prolong it.
    until(|| std::io::Write::write_all(&mut &slow, b"x").is_err());
    assert!(matches!(site.raw(b"").0, 0 | 408));
    let head = format!(
        "POST /api/save HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {}\r\nContent-Type: application/json\r\n",
        site.token
    );
    assert_eq!(site.raw(format!("{head}Content-Length: 10\r\n\r\n{{").as_bytes()).0, 408);
}

/// Without the time for headers, which would end connections that say nothing.
fn patient() -> Limits {
    Limits { headers: LONG, ..Limits::default() }
}

/// A connection that has begun a request and says no more.
fn half_open(site: &Site) -> TcpStream {
    let mut stream = site.connect();
    // The server may have closed it.
    let _ = stream.write_all(b"GET / HTTP/1.1\r\nX: ");
    stream
}

#[test]
fn black_arrives_while_anybody_holds_more_connections_than_there_are() {
    let site = Site::with_limits(patient());
    let held: Vec<_> = (0..1000).map(|_| half_open(&site)).collect();
    assert_eq!(site.post("blackout", "{}").0, 200);
    assert_eq!(site.request("GET /", &["Host: localhost"], "").0, 200);
    assert!(site.page().text("state").is_object());
    // The oldest ones have given way, the newest wait.
    let ends = |mut stream: &TcpStream| {
        stream.set_nonblocking(true).unwrap();
        !matches!(stream.read(&mut [0]), Err(error) if error.kind() == ErrorKind::WouldBlock)
    };
    until(|| held[..900].iter().all(ends));
    assert!(!held[990..].iter().any(ends));
}

#[test]
fn black_arrives_during_a_steady_flood_of_connections() {
    let site = Site::with_limits(patient());
    let headers = format!("Authorization: Bearer {}\r\nContent-Type: application/json\r\n", site.token);
    let request = format!("POST /api/blackout HTTP/1.1\r\nHost: localhost\r\n{headers}Content-Length: 2\r\n\r\n{{}}");
    let mut held = Vec::new();
    for _ in 0..20 {
        held.extend((0..100).map(|_| half_open(&site)));
        let mut stream = site.connect();
        // Fewer than an address may have, so this one has not given way.
        held.extend((0..60).map(|_| half_open(&site)));
        stream.write_all(request.as_bytes()).unwrap();
        assert_eq!(response(&mut stream).0, 200);
        held.drain(..held.len() - 160);
    }
}
