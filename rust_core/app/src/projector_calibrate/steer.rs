//! Correspondences by hand: the user steers a crosshair that the projector shows onto things whose places are known.

use anyhow::{anyhow, Context as _};
use nalgebra::{Isometry3, Point2, Point3};
use rcs_calibration::{Lens, Sample};
use rcs_window::{self as window, ScreenPicture, UserEvent, WindowKey};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::show::close_on_signal;
use super::Failure;
use crate::monitor_arguments::MonitorArguments;

/// Pixels of a large step.
const LARGE_STEP_PX: i64 = 25;
/// How well a crosshair is steered onto a thing by eye, pixels.
const STEERED_PX: f64 = 1.0;

/// Shows the crosshair until it has been steered onto all things, and returns what was found. It starts where the old
/// pose, if there is one, expects each thing.
pub(super) fn steer(
    things: &[Point3<f64>],
    lens: &Lens,
    projector_from_camera: Option<&Isometry3<f64>>,
    monitor: &MonitorArguments,
) -> Result<Vec<Sample>, Failure> {
    let mut signals = Some(Signals::new([SIGINT, SIGTERM]).context("cannot handle signals").map_err(Failure::Refused)?);
    let mut steering = Steering::new(things, lens, projector_from_camera);
    let mut failure = None;
    let options = monitor.window_options("the crosshair");
    eprintln!("arrows: one pixel; w, a, s, d: {LARGE_STEP_PX}; enter: it is on the thing; n: skip it; backspace: back; escape: end");
    let shown = window::run_interactive(options, |event, sink| {
        let outcome = match event {
            UserEvent::Opened(monitor) | UserEvent::MonitorChanged(monitor) => {
                let (width, height) = monitor.size_px;
                check_size([width, height], lens.size_px).and_then(|()| {
                    let started = signals.take().map_or(Ok(()), |signals| close_on_signal(signals, sink.clone()));
                    started.map_err(|error| anyhow!("cannot start a thread: {error}"))
                })
            }
            UserEvent::Key(key) => {
                steering.press(key);
                Ok(())
            }
        };
        match outcome {
            Err(error) => {
                failure = Some(error);
                sink.close();
            }
            Ok(()) if steering.is_finished() => sink.close(),
            Ok(()) => {
                steering.ask();
                sink.show(steering.picture());
            }
        }
    });
    shown.map_err(Failure::refused)?;
    if let Some(error) = failure {
        return Err(Failure::Refused(error));
    }
    if !steering.is_finished() {
        return Err(Failure::Refused(anyhow!("ended before the crosshair was on all things")));
    }
    Ok(steering.samples())
}

fn check_size(monitor_px: [u32; 2], lens_px: [u32; 2]) -> anyhow::Result<()> {
    if monitor_px == lens_px {
        return Ok(());
    }
    let ([width, height], [lens_width, lens_height]) = (monitor_px, lens_px);
    Err(anyhow!(
        "the monitor has {width}x{height} pixels, the projector's file is for {lens_width}x{lens_height}: choose the \
         projector's monitor, in its native resolution"
    ))
}

/// Where the crosshair is for each thing.
#[derive(Debug)]
struct Steering {
    things: Vec<Point3<f64>>,
    /// The pixels of the things; those that were skipped have none.
    pixels: Vec<Option<[i64; 2]>>,
    size_px: [i64; 2],
    /// Which thing it is steered onto.
    current: usize,
    asked: Option<usize>,
}

impl Steering {
    fn new(things: &[Point3<f64>], lens: &Lens, projector_from_camera: Option<&Isometry3<f64>>) -> Self {
        let size_px = lens.size_px.map(i64::from);
        let middle = size_px.map(|size| size / 2);
        let expected = |thing: &Point3<f64>| {
            let pixel = lens.project(&(projector_from_camera? * thing))?;
            Some([(pixel.x.round() as i64).clamp(0, size_px[0] - 1), (pixel.y.round() as i64).clamp(0, size_px[1] - 1)])
        };
        let pixels = things.iter().map(|thing| Some(expected(thing).unwrap_or(middle))).collect();
        Self { things: things.to_vec(), pixels, size_px, current: 0, asked: None }
    }

    fn is_finished(&self) -> bool {
        self.current >= self.things.len()
    }

    /// Says on the terminal which thing is next, once.
    fn ask(&mut self) {
        if self.asked != Some(self.current) {
            self.asked = Some(self.current);
            if let Some(thing) = self.things.get(self.current) {
                let (number, count) = (self.current + 1, self.things.len());
                eprintln!("thing {number} of {count}: x {:.3} m, y {:.3} m, z {:.3} m", thing.x, thing.y, thing.z);
            }
        }
    }

    fn press(&mut self, key: WindowKey) {
        let Some(pixel) = self.pixels.get_mut(self.current) else { return };
        let [mut right, mut down] = [0, 0];
        match key {
            WindowKey::Left => right = -1,
            WindowKey::Right => right = 1,
            WindowKey::Up => down = -1,
            WindowKey::Down => down = 1,
            WindowKey::Character('a' | 'A') => right = -LARGE_STEP_PX,
            WindowKey::Character('d' | 'D') => right = LARGE_STEP_PX,
            WindowKey::Character('w' | 'W') => down = -LARGE_STEP_PX,
            WindowKey::Character('s' | 'S') => down = LARGE_STEP_PX,
            WindowKey::Enter | WindowKey::Space => self.current += 1,
            WindowKey::Character('n' | 'N') => {
                *pixel = None;
                self.current += 1;
            }
            WindowKey::Backspace => {
                self.current = self.current.saturating_sub(1);
                let middle = self.size_px.map(|size| size / 2);
                self.pixels[self.current].get_or_insert(middle);
            }
            _ => {}
        }
        if let Some(Some(pixel)) = self.pixels.get_mut(self.current) {
            pixel[0] = (pixel[0] + right).clamp(0, self.size_px[0] - 1);
            pixel[1] = (pixel[1] + down).clamp(0, self.size_px[1] - 1);
        }
    }

    /// Lines through the pixel, one pixel wide.
    fn picture(&self) -> ScreenPicture {
        let [u, v] = self.pixels.get(self.current).copied().flatten().unwrap_or([-1, -1]);
        let [width, height] = self.size_px.map(|size| size as u32);
        let is_lit = |at_u: u32, at_v: u32| i64::from(at_u) == u || i64::from(at_v) == v;
        ScreenPicture::from_fn(width, height, |at_u, at_v| [if is_lit(at_u, at_v) { u8::MAX } else { 0 }; 3])
    }

    fn samples(&self) -> Vec<Sample> {
        let of_thing = |(thing, pixel): (&Point3<f64>, &Option<[i64; 2]>)| {
            let [u, v] = (*pixel)?;
            Some(Sample { sigma_px: STEERED_PX, ..Sample::new(Point2::new(u as f64, v as f64), *thing) })
        };
        self.things.iter().zip(&self.pixels).filter_map(of_thing).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steering() -> Steering {
        let lens = Lens::pinhole([1280, 800], [1000.0, 1000.0], [640.0, 400.0]);
        let things = [Point3::new(0.1, 0.0, 1.0), Point3::new(5.0, 0.0, 1.0), Point3::new(0.0, 0.0, 2.0)];
        Steering::new(&things, &lens, Some(&Isometry3::identity()))
    }

    #[test]
    fn the_crosshair_starts_where_the_thing_is_expected_and_stays_in_the_picture() {
        let mut steering = steering();
        assert_eq!(steering.pixels, [Some([740, 400]), Some([1279, 400]), Some([640, 400])]);
        for key in [WindowKey::Left, WindowKey::Left, WindowKey::Down, WindowKey::Character('w')] {
            steering.press(key);
        }
        assert_eq!(steering.pixels[0], Some([738, 376]));
        steering.press(WindowKey::Enter);
        steering.press(WindowKey::Character('d'));
        assert_eq!((steering.current, steering.pixels[1]), (1, Some([1279, 400])));
        let picture = steering.picture();
        assert_eq!(picture, ScreenPicture::from_fn(1280, 800, |u, v| [if u == 1279 || v == 400 { 255 } else { 0 }; 3]));
    }

    #[test]
    fn things_can_be_skipped_and_taken_up_again() {
        let mut steering = steering();
        for key in [WindowKey::Enter, WindowKey::Character('n'), WindowKey::Backspace, WindowKey::Character('n')] {
            steering.press(key);
        }
        assert!(!steering.is_finished());
        steering.press(WindowKey::Space);
        assert!(steering.is_finished());
        let samples = steering.samples();
        assert_eq!(samples.len(), 2);
        assert_eq!((samples[0].pixel, samples[0].point), (Point2::new(740.0, 400.0), Point3::new(0.1, 0.0, 1.0)));
        steering.press(WindowKey::Left);
        assert_eq!(steering.samples(), samples, "keys after the end do nothing");
    }

    #[test]
    fn another_monitor_is_refused() {
        assert!(check_size([1280, 800], [1280, 800]).is_ok());
        assert!(check_size([1920, 1080], [1280, 800]).unwrap_err().to_string().contains("1920x1080"));
    }
}
