//! Wait for a chessboard to rest in a new pose, before the scan of that pose.

use std::time::{Duration, Instant};

use rcs_calibration::board::{find_chessboard, BoardCorner, Chessboard};
use rcs_calibration::patterns::Pattern;
use rcs_calibration::statistics::median;

use crate::failure::ScanFailure;
use crate::session::{ScanEvent, ScanSession};

/// Time for which the board must rest, and period of looking.
const REST: Duration = Duration::from_millis(1500);
const LOOK_PERIOD: Duration = Duration::from_millis(250);
/// Time between two notes on what is missing.
const NOTE_PERIOD: Duration = Duration::from_secs(10);
/// Motion between two looks of a board at rest, and from the last pose to a new one, as shares of the image's width.
const RESTS: f64 = 0.001;
const IS_NEW: f64 = 0.02;

impl ScanSession<'_> {
    /// Shows white until the board rests in another pose than the last one, and returns its corners.
    ///
    /// # Errors
    /// [`ScanFailure`]: the camera or the screen fails, or the session is to end.
    pub fn wait_for_board(
        &mut self,
        board: &Chessboard,
        last: Option<&[BoardCorner]>,
    ) -> Result<Vec<BoardCorner>, ScanFailure> {
        let mut noted = self.show(&Pattern::White)?;
        let size_px = self.camera.lens().size_px;
        let [rests_px, new_px] = [RESTS, IS_NEW].map(|share| share * f64::from(size_px[0]));
        let mut after = noted;
        let mut is_new = last.is_none();
        let mut resting: Option<(Instant, Vec<BoardCorner>)> = None;
        loop {
            let frame = self.frame(after)?;
            after = frame.received + LOOK_PERIOD;
            let found = find_chessboard(&frame.grey, size_px, board);
            let is_noted = frame.received.saturating_duration_since(noted) > NOTE_PERIOD;
            if is_noted {
                noted = frame.received;
            }
            let corners = match found {
                Ok(corners) => corners,
                Err(refusal) => {
                    resting = None;
                    if is_noted {
                        (self.observe)(ScanEvent::Note(&refusal.to_string()));
                    }
                    continue;
                }
            };
            is_new = is_new || last.is_some_and(|last| change_px(last, &corners) > new_px);
            if is_noted && !is_new {
                (self.observe)(ScanEvent::Note("the board is still where it was scanned: move it"));
            }
            match &resting {
                Some((since, before)) if shift_px(before, &corners) < rests_px => {
                    if is_new && frame.received.saturating_duration_since(*since) >= REST {
                        return Ok(corners);
                    }
                }
                _ => resting = Some((frame.received, corners)),
            }
        }
    }
}

/// Largest change of the left, right, upper and lower edge of the board in the image, pixels.
fn change_px(before: &[BoardCorner], now: &[BoardCorner]) -> f64 {
    let (before, now) = (edges_px(before), edges_px(now));
    before.iter().zip(now).map(|(before, now)| (now - before).abs()).fold(0.0, f64::max)
}

/// Left, right, upper and lower edge of the corners in the image, pixels: by their mean and deviation, which a few
/// missing corners hardly change.
fn edges_px(corners: &[BoardCorner]) -> [f64; 4] {
    let count = corners.len().max(1) as f64;
    let edges = |axis: usize| {
        let mean = corners.iter().map(|corner| corner.pixel[axis]).sum::<f64>() / count;
        let squares = corners.iter().map(|corner| (corner.pixel[axis] - mean).powi(2)).sum::<f64>();
        // Of an even distribution.
        let half = (3.0 * squares / count).sqrt();
        [mean - half, mean + half]
    };
    let ([left, right], [top, bottom]) = (edges(0), edges(1));
    [left, right, top, bottom]
}

/// Median distance of corners from the nearest ones before, pixels. Their places on the board may be numbered in
/// another way.
fn shift_px(before: &[BoardCorner], corners: &[BoardCorner]) -> f64 {
    let nearest = |corner: &BoardCorner| {
        before.iter().map(|other| (other.pixel - corner.pixel).norm()).fold(f64::INFINITY, f64::min)
    };
    median(&mut corners.iter().map(nearest).collect::<Vec<_>>())
}
