//! Bounded queue and writer thread of a log stream, which may block: a terminal stopped with Ctrl-S, a full pipe, a
//! disk that hangs.
//!
//! ```text
//!   any thread ──► queue, bounded ──► writer thread ──► stream
//!                     │ full: the oldest line is dropped and counted
//! ```
//!
//! Whoever logs never waits. When the stream takes lines again, one says how many were dropped.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::sync::{Arc, Condvar, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use rcs_process::{lock, wait_timeout, wait_while};

/// Most lines in the queue.
const MOST_LINES: usize = 1000;
/// Most bytes in the queue, except for a single longer line.
const MOST_BYTES: usize = 1 << 20;
/// Time between two attempts at a full non-blocking stream.
const RETRY_PERIOD: Duration = Duration::from_millis(20);

/// Makes the line that reports a number of dropped ones.
type DropNotice = Box<dyn Fn(u64) -> String + Send + Sync>;

/// A log stream's queue; its thread starts with the first line.
pub(crate) struct LineQueue {
    shared: Arc<LineQueueShared>,
    /// The name of the writer thread.
    name: &'static str,
}

struct LineQueueShared {
    waiting: Mutex<QueuedLines>,
    changed: Condvar,
    notice: DropNotice,
}

struct QueuedLines {
    lines: VecDeque<String>,
    bytes: usize,
    /// Lines dropped since the last that was written.
    dropped: u64,
    is_writing: bool,
    /// Taken by the writer thread.
    stream: Option<File>,
}

impl QueuedLines {
    fn push(&mut self, line: String) {
        while !self.lines.is_empty() && (self.lines.len() >= MOST_LINES || self.bytes + line.len() > MOST_BYTES) {
            self.pop();
            self.dropped += 1;
        }
        self.bytes += line.len();
        self.lines.push_back(line);
    }

    fn pop(&mut self) -> Option<String> {
        let line = self.lines.pop_front()?;
        self.bytes -= line.len();
        Some(line)
    }
}

impl LineQueue {
    /// A queue for `stream`, written by a thread called `name`.
    pub(crate) fn new(
        name: &'static str,
        stream: File,
        notice: impl Fn(u64) -> String + Send + Sync + 'static,
    ) -> Self {
        let (lines, stream) = (VecDeque::new(), Some(stream));
        let waiting = Mutex::new(QueuedLines { lines, bytes: 0, dropped: 0, is_writing: false, stream });
        Self { shared: Arc::new(LineQueueShared { waiting, changed: Condvar::new(), notice: Box::new(notice) }), name }
    }

    /// Queues a line. Never waits.
    pub(crate) fn push(&self, line: String) {
        let mut waiting = lock(&self.shared.waiting);
        waiting.push(line);
        if waiting.stream.is_some() {
            let shared = Arc::clone(&self.shared);
            // If there is no thread left, the next line tries again.
            let _ = thread::Builder::new().name(self.name.to_owned()).spawn(move || shared.write_all());
        }
        drop(waiting);
        self.shared.changed.notify_all();
    }

    /// Waits until all lines are written, at most until `until`; `true` if they are.
    pub(crate) fn flush(&self, until: Instant) -> bool {
        let mut waiting = lock(&self.shared.waiting);
        loop {
            if waiting.lines.is_empty() && !waiting.is_writing {
                return true;
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            waiting = wait_timeout(&self.shared.changed, waiting, left);
        }
    }
}

impl LineQueueShared {
    /// The writer thread.
    fn write_all(&self) {
        let Some(mut stream) = lock(&self.waiting).stream.take() else { return };
        loop {
            let is_idle = |waiting: &mut QueuedLines| waiting.lines.is_empty();
            let mut waiting = wait_while(&self.changed, lock(&self.waiting), is_idle);
            let dropped = std::mem::take(&mut waiting.dropped);
            let Some(line) = waiting.pop() else { continue };
            waiting.is_writing = true;
            drop(waiting);
            if dropped > 0 {
                write_line(&mut stream, (self.notice)(dropped));
            }
            write_line(&mut stream, line);
            lock(&self.waiting).is_writing = false;
            self.changed.notify_all();
        }
    }
}

/// Writes a line, however long that takes; errors of a closed stream are ignored.
fn write_line(stream: &mut File, mut line: String) {
    line.push('\n');
    let mut rest = line.as_bytes();
    while !rest.is_empty() {
        match stream.write(rest) {
            Ok(0) => return,
            Ok(count) => rest = rest.get(count..).unwrap_or_default(),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => thread::sleep(RETRY_PERIOD),
            Err(_) => return,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead, BufReader, Read};
    use std::os::fd::OwnedFd;
    use std::os::unix::net::UnixStream;

    use super::*;

    /// A queue, and the other end of its stream.
    fn queue() -> (LineQueue, UnixStream) {
        let (reader, writer) = UnixStream::pair().unwrap();
        let stream = File::from(OwnedFd::from(writer));
        (LineQueue::new("log-test", stream, |count| format!("{count} dropped")), reader)
    }

    fn soon() -> Instant {
        Instant::now() + Duration::from_secs(20)
    }

    #[test]
    fn a_reader_that_stops_delays_nobody_and_then_reads_how_many_lines_were_dropped() {
        let (queue, reader) = queue();
        let line = |i: usize| format!("{i} {}", "x".repeat(500));
        let count = 10 * MOST_LINES;
        (0..count).for_each(|i| queue.push(line(i)));
        assert!(!queue.flush(Instant::now() + Duration::from_millis(100)));
        // What was written before the reader stopped, a notice, and the newest lines.
        let mut lines = BufReader::new(reader).lines().map(Result::unwrap);
        let (mut read, mut notices) = (Vec::new(), Vec::new());
        while read.last() != Some(&line(count - 1)) {
            let next = lines.next().unwrap();
            match next.strip_suffix(" dropped") {
                Some(dropped) => notices.push(dropped.parse::<usize>().unwrap()),
                None => read.push(next),
            }
        }
        assert_eq!(read.len() + notices.iter().sum::<usize>(), count, "{notices:?}");
        assert!(!notices.is_empty() && read.len() >= MOST_LINES, "{notices:?}, {} read", read.len());
        assert!(queue.flush(soon()));
    }

    #[test]
    fn long_lines_are_bounded_by_their_bytes() {
        let (queue, mut reader) = queue();
        let push = || queue.push("x".repeat(MOST_BYTES / 2));
        push();
        // The thread writes the first line, for which the stream has no room: what is dropped then has to wait.
        let until = soon();
        while !lock(&queue.shared.waiting).is_writing {
            assert!(Instant::now() < until, "no line is written");
            thread::sleep(Duration::from_millis(1));
        }
        (1..20).for_each(|_| push());
        let waiting = lock(&queue.shared.waiting);
        assert!(waiting.lines.len() <= 2 && waiting.bytes <= MOST_BYTES && waiting.dropped >= 17, "{}", waiting.bytes);
        drop(waiting);
        let reading = thread::spawn(move || reader.read_to_end(&mut Vec::new()));
        assert!(queue.flush(soon()));
        drop(reading);
    }

    #[test]
    fn a_stream_that_does_not_block_loses_nothing() {
        let (reader, writer) = UnixStream::pair().unwrap();
        writer.set_nonblocking(true).unwrap();
        let queue = LineQueue::new("log-test", File::from(OwnedFd::from(writer)), |count| format!("{count} dropped"));
        let line = "x".repeat(MOST_BYTES / 2);
        queue.push(line.clone());
        thread::sleep(2 * RETRY_PERIOD);
        assert_eq!(BufReader::new(reader).lines().next().unwrap().unwrap(), line);
    }

    #[test]
    fn a_closed_stream_is_nobodys_to_read() {
        let (queue, reader) = queue();
        drop(reader);
        (0..10).for_each(|_| queue.push("x".to_owned()));
        assert!(queue.flush(soon()));
    }
}
