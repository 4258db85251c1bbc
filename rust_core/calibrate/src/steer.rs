//! Correspondences by hand: the user steers a crosshair that the projector shows onto things whose places are known, or
//! become known as the user clicks them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{anyhow, Context as _};
use nalgebra::{Isometry3, Point2, Point3};
use rcs_calibration::{Lens, Sample};
use rcs_scene::join_within;
use rcs_window::{self as window, PictureSink, ScreenPicture, UserEvent, WindowKey};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::clicks::Clicks;
use super::placing::Frames;
use super::show::close_on_signal;
use super::Failure;
use rcs_node_support::monitor_arguments::MonitorArguments;
use rcs_node_support::window_watch::WindowWatch;

/// Pixels of a large step.
const LARGE_STEP_PX: i64 = 25;
/// How well a crosshair is steered onto a thing by eye, pixels.
const STEERED_PX: f64 = 1.0;
/// How long the thread that listens to clicks may take to end: it ends a node.
const END_PATIENCE: Duration = Duration::from_secs(10);
/// So many things determine a pose that can be judged.
const LEAST_THINGS: usize = 6;

/// What the crosshair is steered onto.
pub(super) enum Things {
    /// Points of the camera's optical frame, metres. The crosshair starts where the old pose, if there is one, expects
    /// each of them.
    Given(Vec<Point3<f64>>, Option<Isometry3<f64>>),
    /// What the user clicks.
    Clicked(Clicks),
}

/// Shows the crosshair until it has been steered onto all things, and returns what was found, with the robot's frames
/// if things were clicked.
pub(super) fn steer(
    things: Things,
    lens: &Lens,
    monitor: &MonitorArguments,
) -> Result<(Vec<Sample>, Option<Frames>), Failure> {
    let mut signals = Some(Signals::new([SIGINT, SIGTERM]).context("cannot handle signals").map_err(Failure::Refused)?);
    let watch = WindowWatch::start_with_signals(1).context("cannot watch the window").map_err(Failure::Refused)?;
    let (steering, mut clicks) = match things {
        Things::Given(things, pose) => (Steering::of_given(&things, lens, pose.as_ref()), None),
        Things::Clicked(clicks) => (Steering::new(lens, true), Some(clicks)),
    };
    let end = clicks.as_ref().map(|clicks| clicks.end.clone());
    let steering = Arc::new(Mutex::new(steering));
    let mut listening = None;
    let mut failure = None;
    let options = monitor.window_options("the crosshair");
    let finish = if clicks.is_some() { "; f: finish" } else { "" };
    eprintln!(
        "arrows: one pixel; w, a, s, d: {LARGE_STEP_PX}; enter: it is on the thing; n: skip it; backspace: \
         back{finish}; escape: end"
    );
    let shown = window::run_interactive(&options, |event, sink| {
        let outcome = match event {
            UserEvent::Opened(monitor) | UserEvent::MonitorChanged(monitor) => {
                let (width, height) = monitor.size_px;
                check_size([width, height], lens.size_px).and_then(|()| {
                    let started = signals.take().map_or(Ok(()), |signals| close_on_signal(signals, sink.clone()));
                    started
                        .and_then(|()| {
                            let Some(clicks) = clicks.take() else { return Ok(()) };
                            listening = Some(listen(clicks, Arc::clone(&steering), sink.clone())?);
                            Ok(())
                        })
                        .context("cannot start a thread")
                })
            }
            UserEvent::Key(key) => {
                lock(&steering).press(key);
                Ok(())
            }
        };
        match outcome {
            Err(error) => {
                failure = Some(error);
                sink.close();
            }
            Ok(()) => lock(&steering).present(sink),
        }
    });
    drop(watch);
    end.iter().for_each(rcs_node_support::lifecycle::EndRequest::request);
    let heard = listening.map(|thread| join_within(thread, END_PATIENCE));
    shown.map_err(Failure::refused)?;
    if let Some(error) = failure {
        return Err(Failure::Refused(error));
    }
    let frames = heard.map(|heard| match heard {
        Some(Ok(frames)) => frames,
        Some(Err(_)) => Err(anyhow!("listening to clicks has ended early")),
        None => Err(anyhow!("listening to clicks does not end, so it is left behind")),
    });
    let frames = frames.transpose().map_err(Failure::Unreadable)?;
    let steering = lock(&steering);
    if !steering.is_finished() {
        return Err(Failure::Refused(anyhow!("ended before the crosshair was on all things")));
    }
    Ok((steering.samples(), frames))
}

fn lock(steering: &Mutex<Steering>) -> MutexGuard<'_, Steering> {
    steering.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Adds what is clicked on another thread.
fn listen(
    clicks: Clicks,
    steering: Arc<Mutex<Steering>>,
    sink: PictureSink,
) -> std::io::Result<JoinHandle<anyhow::Result<Frames>>> {
    let listening = move || {
        let heard = clicks.listen(|click| {
            let mut steering = lock(&steering);
            steering.add(click.point, click.in_projector);
            steering.present(&sink);
        });
        if heard.is_err() {
            sink.close();
        }
        heard
    };
    thread::Builder::new().name("clicks".to_owned()).spawn(listening)
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
    lens: Lens,
    things: Vec<Point3<f64>>,
    /// The pixels of the things; those that were skipped have none.
    pixels: Vec<Option<[i64; 2]>>,
    size_px: [i64; 2],
    /// Which thing it is steered onto.
    current: usize,
    /// Whether more things may come until the user says that these are all.
    awaits_more: bool,
    /// What was asked for last: the thing, and whether it was there.
    asked: Option<(usize, bool)>,
}

impl Steering {
    fn new(lens: &Lens, awaits_more: bool) -> Self {
        let size_px = lens.size_px.map(i64::from);
        Self { lens: *lens, things: Vec::new(), pixels: Vec::new(), size_px, current: 0, awaits_more, asked: None }
    }

    fn of_given(things: &[Point3<f64>], lens: &Lens, projector_from_camera: Option<&Isometry3<f64>>) -> Self {
        let mut steering = Self::new(lens, false);
        things.iter().for_each(|thing| steering.add(*thing, projector_from_camera.map(|pose| pose * thing)));
        steering
    }

    /// Adds a thing; the crosshair starts where its place in the projector's frame is, if that is known.
    fn add(&mut self, thing: Point3<f64>, in_projector: Option<Point3<f64>>) {
        let expected = in_projector.and_then(|point| self.lens.project(&point)).map(|pixel| {
            let whole = |at: f64, size: i64| (at.round() as i64).clamp(0, size - 1);
            [whole(pixel.x, self.size_px[0]), whole(pixel.y, self.size_px[1])]
        });
        self.things.push(thing);
        self.pixels.push(Some(expected.unwrap_or(self.size_px.map(|size| size / 2))));
    }

    fn is_finished(&self) -> bool {
        !self.awaits_more && self.current >= self.things.len()
    }

    /// Shows the crosshair and says what is to be done, or closes the window when all is done.
    fn present(&mut self, sink: &PictureSink) {
        if self.is_finished() {
            return sink.close();
        }
        self.ask();
        sink.show(self.picture());
    }

    /// Says on the terminal which thing is next, once.
    fn ask(&mut self) {
        let thing = self.things.get(self.current);
        if self.asked == Some((self.current, thing.is_some())) {
            return;
        }
        self.asked = Some((self.current, thing.is_some()));
        match thing {
            Some(thing) => {
                let (number, count) = (self.current + 1, self.things.len());
                let of = if self.awaits_more { String::new() } else { format!(" of {count}") };
                eprintln!("thing {number}{of}: x {:.3} m, y {:.3} m, z {:.3} m", thing.x, thing.y, thing.z);
            }
            None => eprintln!("click the next thing in rviz (Publish Point); {}", self.progress()),
        }
    }

    /// How many things there are and are needed.
    fn progress(&self) -> String {
        match self.samples().len() {
            count if count < LEAST_THINGS => format!("{count} of at least {LEAST_THINGS} things are done"),
            count => format!("{count} things are done, f: finish"),
        }
    }

    /// No more things are to come, if there are enough.
    fn finish(&mut self) {
        if !self.awaits_more {
            return;
        }
        if self.samples().len() < LEAST_THINGS {
            eprintln!("{}", self.progress());
            return;
        }
        self.awaits_more = false;
        self.things.truncate(self.current);
        self.pixels.truncate(self.current);
    }

    fn press(&mut self, key: WindowKey) {
        if self.is_finished() {
            return;
        }
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
            WindowKey::Enter | WindowKey::Space if self.current < self.things.len() => self.current += 1,
            WindowKey::Character('n' | 'N') => {
                if let Some(pixel) = self.pixels.get_mut(self.current) {
                    *pixel = None;
                    self.current += 1;
                }
            }
            WindowKey::Backspace => {
                self.current = self.current.saturating_sub(1);
                let middle = self.size_px.map(|size| size / 2);
                if let Some(pixel) = self.pixels.get_mut(self.current) {
                    pixel.get_or_insert(middle);
                }
            }
            WindowKey::Character('f' | 'F') => self.finish(),
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

    /// The things that the crosshair has been on.
    fn samples(&self) -> Vec<Sample> {
        let of_thing = |(thing, pixel): (&Point3<f64>, &Option<[i64; 2]>)| {
            let [u, v] = (*pixel)?;
            Some(Sample { sigma_px: STEERED_PX, ..Sample::new(Point2::new(u as f64, v as f64), *thing) })
        };
        self.things.iter().zip(&self.pixels).take(self.current).filter_map(of_thing).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steering() -> Steering {
        let lens = Lens::pinhole([1280, 800], [1000.0, 1000.0], [640.0, 400.0]);
        let things = [Point3::new(0.1, 0.0, 1.0), Point3::new(5.0, 0.0, 1.0), Point3::new(0.0, 0.0, 2.0)];
        Steering::of_given(&things, &lens, Some(&Isometry3::identity()))
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
    fn clicked_things_come_one_by_one_until_the_user_has_enough() {
        let mut steering = Steering::new(&Lens::pinhole([1280, 800], [1000.0, 1000.0], [640.0, 400.0]), true);
        let none = ScreenPicture::from_fn(1280, 800, |_, _| [0; 3]);
        for key in [WindowKey::Enter, WindowKey::Backspace, WindowKey::Left, WindowKey::Character('n')] {
            steering.press(key);
        }
        assert!(steering.picture() == none && steering.current == 0);
        for number in 0..LEAST_THINGS {
            let point = Point3::new(0.1 * number as f64, 0.0, 1.0);
            steering.add(point, (number > 0).then_some(point));
            assert_ne!(steering.picture(), none);
            steering.press(WindowKey::Character('f'));
            assert!(!steering.is_finished() && steering.samples().len() == number);
            steering.press(WindowKey::Right);
            steering.press(WindowKey::Enter);
        }
        assert!(!steering.is_finished() && steering.picture() == none);
        // One more that is not confirmed does not count.
        steering.add(Point3::new(0.0, 0.0, 1.0), None);
        steering.press(WindowKey::Character('f'));
        assert!(steering.is_finished());
        let pixels: Vec<f64> = steering.samples().iter().map(|sample| sample.pixel.x).collect();
        assert_eq!(pixels, [641.0, 741.0, 841.0, 941.0, 1041.0, 1141.0]);
    }

    #[test]
    fn another_monitor_is_refused() {
        assert!(check_size([1280, 800], [1280, 800]).is_ok());
        assert!(check_size([1920, 1080], [1280, 800]).unwrap_err().to_string().contains("1920x1080"));
    }
}
