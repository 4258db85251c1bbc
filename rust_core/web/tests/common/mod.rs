//! A server, and a client of raw sockets for it.
#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "only tests use it")]
#![allow(dead_code, reason = "each test file uses a part")]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use rcs_web::{Access, ImageFile, ImageFormat, Limits, LogLine, Operator, Pages, Refusal, Server, Token};
use serde_json::Value;

/// A guard against hangs.
pub(crate) const LONG: Duration = Duration::from_secs(30);

/// Records what pages ask for.
#[derive(Default)]
pub(crate) struct Recorder {
    pub(crate) posts: Mutex<Vec<String>>,
    pub(crate) watchers_changed: AtomicUsize,
    pub(crate) log: Mutex<Vec<LogLine>>,
    /// `wait` waits until this is set.
    pub(crate) is_released: Mutex<bool>,
    pub(crate) released: Condvar,
}

impl Operator for Recorder {
    fn is_immediate(&self, request: &str) -> bool {
        request == "blackout"
    }

    fn post(&self, request: &str, body: &Value, caller: &str) -> Result<String, Refusal> {
        match request {
            "blackout" | "save" => {}
            "wait" => {
                let released = self.is_released.lock().unwrap();
                drop(self.released.wait_timeout_while(released, LONG, |is_released| !*is_released).unwrap());
            }
            "invalid" => return Err(Refusal::Invalid("on: no boolean".to_owned())),
            "fail" => return Err(Refusal::Failed("not possible".to_owned())),
            "panic" => panic!("a test's panic"),
            unknown => return Err(Refusal::Unknown(unknown.to_owned())),
        }
        self.posts.lock().unwrap().push(format!("{request} {body} by {caller}"));
        Ok(format!("{request} done"))
    }

    fn state(&self) -> String {
        format!(r#"{{"type":"state","posts":{}}}"#, self.posts.lock().unwrap().len())
    }

    fn log_after(&self, id: u64) -> Vec<LogLine> {
        self.log.lock().unwrap().iter().filter(|line| line.id > id).cloned().collect()
    }

    fn watchers_changed(&self) {
        self.watchers_changed.fetch_add(1, Ordering::AcqRel);
    }
}

/// A server with its operator.
pub(crate) struct Site {
    pub(crate) operator: Arc<Recorder>,
    pub(crate) pages: Pages,
    pub(crate) token: String,
    pub(crate) address: SocketAddr,
    pub(crate) server: Option<Server>,
    access: Access,
}

impl Site {
    pub(crate) fn start() -> Self {
        Self::with_limits(Limits::default())
    }

    pub(crate) fn with_limits(limits: Limits) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let token = Token::load_or_create(&folder.path().join("token")).unwrap();
        let access = Access::new(token.clone(), ["robot.local".to_owned()]);
        let (operator, pages) = (Arc::new(Recorder::default()), Pages::new());
        let any = SocketAddr::from(([127, 0, 0, 1], 0));
        let server = Server::start(any, access.clone(), operator.clone(), pages.clone(), limits).unwrap();
        let address = server.address();
        Self { operator, pages, token: token.text().to_owned(), address, server: Some(server), access }
    }

    /// Starts it again at the same address, as a node that was restarted.
    pub(crate) fn restart(&mut self) {
        self.server = None;
        self.pages = Pages::new();
        let (operator, pages) = (self.operator.clone(), self.pages.clone());
        let server = Server::start(self.address, self.access.clone(), operator, pages, Limits::default());
        self.server = Some(server.unwrap());
    }

    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect_timeout(&self.address, LONG).unwrap();
        stream.set_read_timeout(Some(LONG)).unwrap();
        stream
    }

    /// Status and text of the response to a request of these bytes; status 0 if there is none.
    pub(crate) fn raw(&self, request: &[u8]) -> (u16, String) {
        let mut stream = self.connect();
        // The server may answer before it has read all, or close.
        let _ = stream.write_all(request);
        response(&mut stream)
    }

    pub(crate) fn request(&self, line: &str, headers: &[&str], body: &str) -> (u16, String) {
        let headers: String = headers.iter().map(|header| format!("{header}\r\n")).collect();
        let length = body.len();
        self.raw(format!("{line} HTTP/1.1\r\n{headers}Content-Length: {length}\r\n\r\n{body}").as_bytes())
    }

    /// Posts to the API as the page does.
    pub(crate) fn post(&self, name: &str, body: &str) -> (u16, Value) {
        let authorization = format!("Authorization: Bearer {}", self.token);
        let (host, origin) = (format!("Host: {}", self.address), format!("Origin: http://{}", self.address));
        let headers = [&*host, &*origin, &*authorization, "Content-Type: application/json"];
        let (status, text) = self.request(&format!("POST /api/{name}"), &headers, body);
        let body = text.split_once("\r\n\r\n").unwrap_or_default().1;
        (status, serde_json::from_str(body).unwrap_or_default())
    }

    /// The response to a WebSocket's handshake, and its connection.
    pub(crate) fn handshake(&self, headers: &[&str]) -> (u16, String, TcpStream) {
        let mut stream = self.connect();
        let headers: String = headers.iter().map(|header| format!("{header}\r\n")).collect();
        let upgrade = "Connection: keep-alive, Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n";
        let key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
        write!(stream, "GET /api/stream HTTP/1.1\r\n{upgrade}{key}{headers}\r\n").unwrap();
        let mut head = Vec::new();
        let mut byte = [0];
        while !head.ends_with(b"\r\n\r\n") && stream.read(&mut byte).is_ok_and(|read| read == 1) {
            head.push(byte[0]);
        }
        let head = String::from_utf8_lossy(&head).into_owned();
        (status_of(&head), head, stream)
    }

    pub(crate) fn page(&self) -> Page {
        let (host, origin) = (format!("Host: {}", self.address), format!("Origin: http://{}", self.address));
        let protocols = format!("Sec-WebSocket-Protocol: rcs, token.{}", self.token);
        let (status, head, stream) = self.handshake(&[&host, &origin, &protocols]);
        assert_eq!(status, 101, "{head}");
        Page(stream)
    }

    /// A page that watches the camera `proj` and has credit.
    pub(crate) fn watching_page(&self) -> Page {
        let mut page = self.page();
        page.send(r#"{"type":"watch","cameras":["proj"]}"#);
        page.send(r#"{"type":"ready"}"#);
        until(|| self.pages.images().take_new_watcher("proj"));
        page
    }
}

pub(crate) fn response(stream: &mut TcpStream) -> (u16, String) {
    let mut text = Vec::new();
    // A reset ends it, too.
    let _ = stream.read_to_end(&mut text);
    let text = String::from_utf8_lossy(&text).into_owned();
    (status_of(&text), text)
}

fn status_of(text: &str) -> u16 {
    text.strip_prefix("HTTP/1.1 ").and_then(|text| text.get(..3)?.parse().ok()).unwrap_or_default()
}

/// The page's end of a WebSocket.
pub(crate) struct Page(TcpStream);

impl Page {
    pub(crate) fn send(&mut self, text: &str) {
        self.send_frame(0x81, text.as_bytes());
    }

    /// A frame with this first byte.
    pub(crate) fn send_frame(&mut self, first: u8, payload: &[u8]) {
        let mut frame = vec![first];
        match payload.len() {
            len @ ..126 => frame.push(0x80 | len as u8),
            len => {
                frame.push(0x80 | 126);
                frame.extend((len as u16).to_be_bytes());
            }
        }
        // A mask of zeros leaves the payload as it is.
        frame.extend([0; 4]);
        frame.extend(payload);
        // The server may have closed it.
        let _ = self.0.write_all(&frame);
    }

    /// The next frame: opcode and payload; `None` once it is closed. Pings are answered.
    pub(crate) fn next(&mut self) -> Option<(u8, Vec<u8>)> {
        loop {
            let [first, len] = self.read_array()?;
            let len = match len {
                126 => u16::from_be_bytes(self.read_array()?).into(),
                127 => u64::from_be_bytes(self.read_array()?),
                len => len.into(),
            };
            let mut payload = vec![0; usize::try_from(len).unwrap()];
            self.0.read_exact(&mut payload).ok()?;
            match first & 0x0f {
                9 => self.send_frame(0x8a, &payload),
                8 => return None,
                opcode => return Some((opcode, payload)),
            }
        }
    }

    fn read_array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes = [0; N];
        self.0.read_exact(&mut bytes).ok()?;
        Some(bytes)
    }

    /// The next text of this type.
    pub(crate) fn text(&mut self, kind: &str) -> Value {
        loop {
            let (opcode, payload) = self.next().expect("the connection is open");
            if opcode != 1 {
                continue;
            }
            let value: Value = serde_json::from_slice(&payload).unwrap();
            if value["type"] == kind {
                return value;
            }
        }
    }

    /// The next binary message's head, and the length of its file.
    pub(crate) fn image(&mut self) -> (Value, usize) {
        loop {
            let (opcode, payload) = self.next().expect("the connection is open");
            if opcode == 2 {
                let head_len = u32::from_le_bytes(payload[..4].try_into().unwrap()) as usize;
                let head = serde_json::from_slice(&payload[4..4 + head_len]).unwrap();
                return (head, payload.len() - 4 - head_len);
            }
        }
    }
}

/// An image whose file has this many bytes; its stamp is this number.
pub(crate) fn image(number: u32, bytes: usize) -> Option<ImageFile> {
    let bytes = vec![0; bytes];
    let format = ImageFormat::Png;
    Some(ImageFile { format, size_px: [2, 1], full_size_px: [4, 2], stamp_secs: number.into(), bytes })
}

/// Encodes on a thread of its own until the server ends.
pub(crate) fn encode_all(pages: &Pages) {
    let images = pages.images().clone();
    let encoding = move || while images.next_job().map(rcs_web::EncodingJob::run).is_some() {};
    std::thread::Builder::new().name("encode".to_owned()).spawn(encoding).unwrap();
}

pub(crate) fn until(mut condition: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !condition() {
        assert!(begun.elapsed() < LONG, "it takes too long");
        std::thread::sleep(Duration::from_millis(2));
    }
}
