//! Correspondences by hand: the user moves a crosshair in the projector's image onto points that are known, or that
//! are clicked in rviz meanwhile.

use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use anyhow::{anyhow, Context as _};
use nalgebra::{Isometry3, Point2, Point3};
use rcs_calibration::{Lens, Sample};
use rcs_node_support::lifecycle::EndRequest;
use rcs_node_support::monitor_arguments::MonitorArguments;
use rcs_node_support::window_watch::WindowWatch;
use rcs_process::lock;
use rcs_window::{self as window, ImageSink, ScreenImage, UserEvent, WindowKey};

use super::clicks::Clicks;
use super::placing::RobotFrames;
use super::window_support::{check_monitor, close_on_end, join, spawn};
use super::Failure;

/// Pixels of a large step.
const LARGE_STEP_PX: i64 = 25;
/// Standard deviation of a crosshair that was placed by eye, pixels.
const SIGMA_PX: f64 = 1.0;
/// Fewer points determine no pose that can be judged.
const MIN_POINTS: usize = 6;

/// The points that the crosshair is moved onto.
pub(super) enum CrosshairTargets {
    /// Points of the camera's optical frame, metres, and the projector's old pose, if it is known: the crosshair starts
    /// where that projects each of them.
    Given(Vec<Point3<f64>>, Option<Isometry3<f64>>),
    /// Points that the user clicks.
    Clicked(Clicks),
}

/// Shows the crosshair until it was on all points. Returns the correspondences, and the robot's frames if points were
/// clicked.
pub(super) fn collect(
    targets: CrosshairTargets,
    lens: &Lens,
    monitor: &MonitorArguments,
) -> Result<(Vec<Sample>, Option<RobotFrames>), Failure> {
    let end = EndRequest::watch_signals().context("cannot handle signals").map_err(Failure::Refused)?;
    let watched = end.clone();
    let watch = WindowWatch::start(1, move || watched.is_requested())
        .context("cannot watch the window")
        .map_err(Failure::Refused)?;
    let (crosshair, clicks) = match targets {
        CrosshairTargets::Given(points, pose) => (Crosshair::of_given(&points, lens, pose.as_ref()), None),
        CrosshairTargets::Clicked(clicks) => (Crosshair::new(lens, true), Some(clicks)),
    };
    let finish = if clicks.is_some() { "; f: finish" } else { "" };
    eprintln!(
        "arrows: one pixel; w, a, s, d: {LARGE_STEP_PX}; enter: it is on the point; n: skip it; backspace: \
         back{finish}; escape: end"
    );
    let crosshair = Arc::new(Mutex::new(crosshair));
    let mut start = Some(clicks);
    let (mut listening, mut failure) = (None, None);
    let shown = window::run_interactive(&monitor.window_options("the crosshair"), |event, sink| {
        let outcome = match event {
            UserEvent::Opened(monitor) | UserEvent::MonitorChanged(monitor) => check_monitor(monitor, lens.size_px)
                .and_then(|()| {
                    let Some(clicks) = start.take() else { return Ok(()) };
                    close_on_end(end.clone(), sink.clone())?;
                    listening = clicks.map(|clicks| listen(clicks, &end, &crosshair, sink.clone())).transpose()?;
                    Ok(())
                }),
            UserEvent::Key { key, .. } => {
                lock(&crosshair).press(key);
                Ok(())
            }
        };
        match outcome {
            Err(error) => {
                failure = Some(error);
                sink.close();
            }
            Ok(()) => lock(&crosshair).present(sink),
        }
    });
    drop(watch);
    let frames = listening.map(|thread| {
        end.request();
        join(thread, "clicks").and_then(|frames| frames)
    });
    shown.map_err(Failure::refused)?;
    failure.map_or(Ok(()), |error| Err(Failure::Refused(error)))?;
    let frames = frames.transpose().map_err(Failure::Unreadable)?;
    let crosshair = lock(&crosshair);
    if !crosshair.is_finished() {
        return Err(Failure::Refused(anyhow!("ended before the crosshair was on all points")));
    }
    Ok((crosshair.samples(), frames))
}

/// Adds points that are clicked, on another thread.
fn listen(
    clicks: Clicks,
    end: &EndRequest,
    crosshair: &Arc<Mutex<Crosshair>>,
    sink: ImageSink,
) -> anyhow::Result<JoinHandle<anyhow::Result<RobotFrames>>> {
    let (end, crosshair) = (end.clone(), Arc::clone(crosshair));
    let listening = move || {
        let frames = clicks.listen(&end, |click| {
            let mut crosshair = lock(&crosshair);
            crosshair.add(click.point, click.in_projector);
            crosshair.present(&sink);
        });
        if frames.is_err() {
            sink.close();
        }
        frames
    };
    spawn("clicks", listening)
}

/// The crosshair's pixel for each point.
#[derive(Debug)]
struct Crosshair {
    lens: Lens,
    points: Vec<Point3<f64>>,
    /// The points' pixels; `None` for skipped ones.
    pixels: Vec<Option<[i64; 2]>>,
    size_px: [i64; 2],
    /// Index of the point that it is moved onto.
    current: usize,
    /// `true` while more points may be clicked.
    awaits_more: bool,
    /// The last prompt: its point, and whether that was known.
    prompted: Option<(usize, bool)>,
}

impl Crosshair {
    fn new(lens: &Lens, awaits_more: bool) -> Self {
        let size_px = lens.size_px.map(i64::from);
        Self { lens: *lens, points: Vec::new(), pixels: Vec::new(), size_px, current: 0, awaits_more, prompted: None }
    }

    fn of_given(points: &[Point3<f64>], lens: &Lens, projector_from_camera: Option<&Isometry3<f64>>) -> Self {
        let mut crosshair = Self::new(lens, false);
        points.iter().for_each(|point| crosshair.add(*point, projector_from_camera.map(|pose| pose * point)));
        crosshair
    }

    /// Adds a point; the crosshair starts at the projection of its place in the projector's frame, if that is known.
    fn add(&mut self, point: Point3<f64>, in_projector: Option<Point3<f64>>) {
        let expected = in_projector.and_then(|point| self.lens.project(&point)).map(|pixel| {
            let whole = |at: f64, size: i64| (at.round() as i64).clamp(0, size - 1);
            [whole(pixel.x, self.size_px[0]), whole(pixel.y, self.size_px[1])]
        });
        self.points.push(point);
        self.pixels.push(Some(expected.unwrap_or(self.size_px.map(|size| size / 2))));
    }

    fn is_finished(&self) -> bool {
        !self.awaits_more && self.current >= self.points.len()
    }

    /// Shows the crosshair and prompts for the next point, or closes the window after the last.
    fn present(&mut self, sink: &ImageSink) {
        if self.is_finished() {
            return sink.close();
        }
        self.prompt();
        sink.show(self.image());
    }

    /// Names the next point on the terminal, once.
    fn prompt(&mut self) {
        let point = self.points.get(self.current);
        if self.prompted == Some((self.current, point.is_some())) {
            return;
        }
        self.prompted = Some((self.current, point.is_some()));
        match point {
            Some(point) => {
                let (number, count) = (self.current + 1, self.points.len());
                let of = if self.awaits_more { String::new() } else { format!(" of {count}") };
                eprintln!("point {number}{of}: x {:.3} m, y {:.3} m, z {:.3} m", point.x, point.y, point.z);
            }
            None => eprintln!("click the next point in rviz (Publish Point); {}", self.progress()),
        }
    }

    /// Number of points that are done and needed, for the terminal.
    fn progress(&self) -> String {
        match self.samples().len() {
            count if count < MIN_POINTS => format!("{count} of at least {MIN_POINTS} points are done"),
            count => format!("{count} points are done, f: finish"),
        }
    }

    /// Ends the clicking, if there are enough points.
    fn finish(&mut self) {
        if !self.awaits_more {
            return;
        }
        if self.samples().len() < MIN_POINTS {
            eprintln!("{}", self.progress());
            return;
        }
        self.awaits_more = false;
        self.points.truncate(self.current);
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
            WindowKey::Enter | WindowKey::Space if self.current < self.points.len() => self.current += 1,
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
    fn image(&self) -> ScreenImage {
        let [u, v] = self.pixels.get(self.current).copied().flatten().unwrap_or([-1, -1]);
        let [width, height] = self.size_px.map(|size| size as u32);
        let is_lit = |at_u: u32, at_v: u32| i64::from(at_u) == u || i64::from(at_v) == v;
        ScreenImage::from_fn(width, height, |at_u, at_v| [if is_lit(at_u, at_v) { u8::MAX } else { 0 }; 3])
    }

    /// The correspondences up to the current point.
    fn samples(&self) -> Vec<Sample> {
        let sample = |(point, pixel): (&Point3<f64>, &Option<[i64; 2]>)| {
            let [u, v] = (*pixel)?;
            Some(Sample { sigma_px: SIGMA_PX, ..Sample::new(Point2::new(u as f64, v as f64), *point) })
        };
        self.points.iter().zip(&self.pixels).take(self.current).filter_map(sample).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crosshair() -> Crosshair {
        let lens = Lens::pinhole([1280, 800], [1000.0, 1000.0], [640.0, 400.0]);
        let points = [Point3::new(0.1, 0.0, 1.0), Point3::new(5.0, 0.0, 1.0), Point3::new(0.0, 0.0, 2.0)];
        Crosshair::of_given(&points, &lens, Some(&Isometry3::identity()))
    }

    #[test]
    fn the_crosshair_starts_where_the_point_is_expected_and_stays_in_the_image() {
        let mut crosshair = crosshair();
        assert_eq!(crosshair.pixels, [Some([740, 400]), Some([1279, 400]), Some([640, 400])]);
        for key in [WindowKey::Left, WindowKey::Left, WindowKey::Down, WindowKey::Character('w')] {
            crosshair.press(key);
        }
        assert_eq!(crosshair.pixels[0], Some([738, 376]));
        crosshair.press(WindowKey::Enter);
        crosshair.press(WindowKey::Character('d'));
        assert_eq!((crosshair.current, crosshair.pixels[1]), (1, Some([1279, 400])));
        let image = crosshair.image();
        assert_eq!(image, ScreenImage::from_fn(1280, 800, |u, v| [if u == 1279 || v == 400 { 255 } else { 0 }; 3]));
    }

    #[test]
    fn points_can_be_skipped_and_taken_up_again() {
        let mut crosshair = crosshair();
        for key in [WindowKey::Enter, WindowKey::Character('n'), WindowKey::Backspace, WindowKey::Character('n')] {
            crosshair.press(key);
        }
        assert!(!crosshair.is_finished());
        crosshair.press(WindowKey::Space);
        assert!(crosshair.is_finished());
        let samples = crosshair.samples();
        assert_eq!(samples.len(), 2);
        assert_eq!((samples[0].pixel, samples[0].point), (Point2::new(740.0, 400.0), Point3::new(0.1, 0.0, 1.0)));
        crosshair.press(WindowKey::Left);
        assert_eq!(crosshair.samples(), samples, "keys after the end do nothing");
    }

    #[test]
    fn clicked_points_come_one_by_one_until_the_user_has_enough() {
        let mut crosshair = Crosshair::new(&Lens::pinhole([1280, 800], [1000.0, 1000.0], [640.0, 400.0]), true);
        let none = ScreenImage::from_fn(1280, 800, |_, _| [0; 3]);
        for key in [WindowKey::Enter, WindowKey::Backspace, WindowKey::Left, WindowKey::Character('n')] {
            crosshair.press(key);
        }
        assert!(crosshair.image() == none && crosshair.current == 0);
        for number in 0..MIN_POINTS {
            let point = Point3::new(0.1 * number as f64, 0.0, 1.0);
            crosshair.add(point, (number > 0).then_some(point));
            assert_ne!(crosshair.image(), none);
            crosshair.press(WindowKey::Character('f'));
            assert!(!crosshair.is_finished() && crosshair.samples().len() == number);
            crosshair.press(WindowKey::Right);
            crosshair.press(WindowKey::Enter);
        }
        assert!(!crosshair.is_finished() && crosshair.image() == none);
        // One more that is not confirmed does not count.
        crosshair.add(Point3::new(0.0, 0.0, 1.0), None);
        crosshair.press(WindowKey::Character('f'));
        assert!(crosshair.is_finished());
        let pixels: Vec<f64> = crosshair.samples().iter().map(|sample| sample.pixel.x).collect();
        assert_eq!(pixels, [641.0, 741.0, 841.0, 941.0, 1041.0, 1141.0]);
    }
}
