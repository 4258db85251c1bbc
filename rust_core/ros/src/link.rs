//! One subscriber's connection to a publication of ours: its own queue and its own writing thread.
//!
//! Sending puts a frame into the queue and returns. When the queue is full the oldest frame is dropped, so a subscriber
//! that reads slowly or not at all costs its queue's memory and nothing else. A second thread waits for the end of the
//! connection, so that the number of subscribers is right even when nothing is sent.

use crate::publication::Frame;
use std::collections::VecDeque;
use std::io::{self, IoSlice, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

#[derive(Debug)]
pub(crate) struct Link {
    pub(crate) caller_id: String,
    stream: TcpStream,
    queue: Mutex<Queue>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Queue {
    frames: VecDeque<Frame>,
    closed: bool,
}

impl Link {
    pub(crate) fn new(caller_id: &str, stream: TcpStream) -> Self {
        Self { caller_id: caller_id.to_owned(), stream, queue: Mutex::default(), changed: Condvar::new() }
    }

    /// Puts a frame into the queue; more than `queue_size` waiting frames drop the oldest. Never waits.
    pub(crate) fn send(&self, frame: &Frame, queue_size: usize) {
        let mut queue = self.lock();
        queue.frames.push_back(frame.clone());
        while queue.frames.len() > queue_size.max(1) {
            queue.frames.pop_front();
        }
        drop(queue);
        self.changed.notify_one();
    }

    /// Ends both threads.
    pub(crate) fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
        // Fails only when the connection is gone already.
        let _ = self.stream.shutdown(Shutdown::Both);
    }

    /// Writes frames until the connection ends.
    pub(crate) fn write_frames(&self) {
        while let Some(frame) = self.next_frame() {
            if write_frame(&self.stream, &frame).is_err() {
                break;
            }
        }
        self.close();
    }

    /// Returns when the connection has ended. Subscribers send nothing after their header.
    pub(crate) fn wait_for_end(&self) {
        let mut ignored = [0; 64];
        loop {
            match (&self.stream).read(&mut ignored) {
                Ok(0) => break,
                Ok(_) => {}
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => break,
            }
        }
        self.close();
    }

    fn next_frame(&self) -> Option<Frame> {
        let mut queue = self.lock();
        loop {
            if queue.closed {
                return None;
            }
            if let Some(frame) = queue.frames.pop_front() {
                return Some(frame);
            }
            queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Length, head and body in as few packets as they fit.
fn write_frame(mut stream: &TcpStream, frame: &Frame) -> io::Result<()> {
    let len = u32::try_from(frame.len()).map_err(|_| io::Error::from(io::ErrorKind::InvalidInput))?;
    let prefix = len.to_le_bytes();
    let mut slices = [IoSlice::new(&prefix), IoSlice::new(&frame.head), IoSlice::new(&frame.body)];
    let mut rest: &mut [IoSlice<'_>] = &mut slices;
    IoSlice::advance_slices(&mut rest, 0);
    while !rest.is_empty() {
        match stream.write_vectored(rest) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(written) => IoSlice::advance_slices(&mut rest, written),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
