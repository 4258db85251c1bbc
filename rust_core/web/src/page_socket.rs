//! The WebSocket of one page: images as binary messages, the state and the log as JSON texts.
//!
//! The page answers each image with `ready`. A page that takes a message too slowly, or says nothing although it was
//! pinged, is closed. Its messages are read also while one to it is being sent: one of them is Black.

use std::time::{Duration, Instant};

use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use serde_json::{json, Value};
use tokio::sync::Notify;
use tokio::time::{sleep_until, timeout};
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};
use tokio_tungstenite::tungstenite::{Bytes, Message};
use tokio_tungstenite::WebSocketStream;

use crate::operator::LogLine;
use crate::requests::Site;

/// Most bytes of a message from a page.
const MOST_BYTES: usize = 16 << 10;
/// Most cameras that a page watches.
const MOST_CAMERAS: usize = 16;
/// Shortest time between two states.
const STATE_GAP: Duration = Duration::from_millis(200);
/// Longest time between two states.
const STATE_PERIOD: Duration = Duration::from_secs(1);
/// Shortest time between two messages with lines of the log.
const LOG_GAP: Duration = Duration::from_millis(100);

type Socket = WebSocketStream<TokioIo<Upgraded>>;

/// A page and what it has received.
struct Sender<'s> {
    socket: SplitSink<Socket, Message>,
    site: &'s Site,
    page: u64,
    /// The version of the last state, and when it was sent.
    state: Option<(u64, Instant)>,
    /// The number of the last line of the log.
    log_id: u64,
    log_sent: Option<Instant>,
    pinged: Instant,
}

/// What comes from a page.
struct Receiver<'s> {
    socket: SplitStream<Socket>,
    site: &'s Site,
    page: u64,
    caller: &'s str,
}

/// The connection is over.
struct Closed;

/// Serves a page until it is closed. `caller` names it in logs.
pub(crate) async fn serve(upgraded: Upgraded, caller: &str, site: &Site) {
    let config = WebSocketConfig::default().max_message_size(Some(MOST_BYTES)).max_frame_size(Some(MOST_BYTES));
    let socket = WebSocketStream::from_raw_socket(TokioIo::new(upgraded), Role::Server, Some(config)).await;
    let (sink, stream) = socket.split();
    let page = site.pages.open();
    site.operator.watchers_changed();
    let (state, log_id, log_sent, pinged) = (None, 0, None, Instant::now());
    let mut sender = Sender { socket: sink, site, page: page.id, state, log_id, log_sent, pinged };
    let mut receiver = Receiver { socket: stream, site, page: page.id, caller };
    let received = Notify::new();
    // How a page leaves makes no difference.
    tokio::select! {
        _ = sender.run(&received) => {}
        _ = receiver.run(&received) => {}
    }
    drop(page);
    site.operator.watchers_changed();
}

impl Sender<'_> {
    async fn run(&mut self, received: &Notify) -> Result<(), Closed> {
        let mut news = self.site.pages.subscribe();
        loop {
            // Before anything is looked at, so that nothing is missed.
            news.borrow_and_update();
            self.send_news().await?;
            let next_due = self.next_due();
            tokio::select! {
                () = received.notified() => {}
                changed = news.changed() => changed.map_err(|_| Closed)?,
                () = sleep_until(next_due.into()) => {}
            }
        }
    }

    /// Sends what is due: a ping, the state, the log, masks and an image.
    async fn send_news(&mut self) -> Result<(), Closed> {
        let (now, pages) = (Instant::now(), &self.site.pages);
        if now.saturating_duration_since(self.pinged) >= self.site.limits.ping {
            self.pinged = now;
            self.send(Message::Ping(Bytes::new())).await?;
        }
        if self.state_due().is_none_or(|due| due <= now) {
            let (version, text) = pages.state(&*self.site.operator);
            self.state = Some((version, now));
            self.send(Message::text(&*text)).await?;
        }
        if self.log_sent.is_none_or(|sent| sent + LOG_GAP <= now) {
            let lines = self.site.operator.log_after(self.log_id);
            if let Some(last) = lines.last() {
                (self.log_id, self.log_sent) = (last.id, Some(now));
                self.send(Message::text(log_message(&lines))).await?;
            }
        }
        while let Some(message) = pages.images().next_message(self.page) {
            self.send(Message::Binary(message)).await?;
        }
        Ok(())
    }

    async fn send(&mut self, message: Message) -> Result<(), Closed> {
        match timeout(self.site.limits.send, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(Closed),
        }
    }

    /// When the state is to be sent next; `None` before the first one.
    fn state_due(&self) -> Option<Instant> {
        let (version, sent) = self.state?;
        let has_changed = version != self.site.pages.state_version();
        Some(sent + if has_changed { STATE_GAP } else { STATE_PERIOD })
    }

    /// When something is due by itself.
    fn next_due(&self) -> Instant {
        let now = Instant::now();
        // Lines that came meanwhile are sent then.
        let log = self.log_sent.map(|sent| sent + LOG_GAP).filter(|due| *due > now);
        let ping = self.pinged + self.site.limits.ping;
        [self.state_due(), log].into_iter().flatten().fold(ping, Instant::min)
    }
}

impl Receiver<'_> {
    async fn run(&mut self, received: &Notify) -> Result<(), Closed> {
        loop {
            let message = timeout(self.site.limits.silence, self.socket.next()).await;
            let Ok(Some(Ok(message))) = message else { return Err(Closed) };
            self.take(&message)?;
            received.notify_one();
        }
    }

    /// Takes a message of the page. One that is not understood ends the connection.
    fn take(&self, message: &Message) -> Result<(), Closed> {
        let text = match message {
            Message::Text(text) => text,
            Message::Ping(_) | Message::Pong(_) => return Ok(()),
            Message::Binary(_) | Message::Close(_) | Message::Frame(_) => return Err(Closed),
        };
        let message: Value = serde_json::from_str(text).map_err(|_| Closed)?;
        let Site { operator, pages, .. } = self.site;
        match message["type"].as_str() {
            Some("watch") => {
                let cameras = message["cameras"].as_array().ok_or(Closed)?;
                let names = cameras.iter().filter_map(Value::as_str).take(MOST_CAMERAS).map(str::to_owned);
                pages.images().watch(self.page, names.collect());
                operator.watchers_changed();
            }
            Some("ready") => pages.images().ready(self.page),
            // The second road of Black, and of nothing else. The page's POST tells what came of it.
            Some("black") => {
                let _ = operator.post("blackout", &json!({"on": true, "camera": message["camera"]}), self.caller);
                pages.state_changed();
            }
            _ => return Err(Closed),
        }
        Ok(())
    }
}

fn log_message(lines: &[LogLine]) -> String {
    let line = |line: &LogLine| json!({"id": line.id, "time": line.time_secs, "level": line.level, "text": line.text});
    json!({"type": "log", "lines": lines.iter().map(line).collect::<Vec<_>>()}).to_string()
}
