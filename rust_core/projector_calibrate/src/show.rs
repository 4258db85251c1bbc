//! `projector_calibrate show`: patterns and test images full screen on the projector, pixel for pixel.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use anyhow::Context as _;
use clap::builder::PossibleValuesParser;
use clap::Args;
use rcs_calibration::patterns::Pattern;
use rcs_files::capture::{read_patterns, PatternList, PATTERNS_FILE};
use rcs_files::image_file;
use rcs_node_support::lifecycle::EndRequest;
use rcs_node_support::monitor_arguments::MonitorArguments;
use rcs_node_support::window_watch::WindowWatch;
use rcs_process::lock;
use rcs_window::test_images::TestImage;
use rcs_window::{self as window, ImageSink, MonitorInfo, ScreenImage, UserEvent, WindowKey};

use super::arguments::{positive_seconds, size_px};
use super::window_support::{close_on_end, spawn};
use super::Failure;

/// Shows patterns or test images full screen on the projector
///
/// Each in the projector's own resolution, unscaled: grid (lines with their coordinates), checkerboard, crosshair,
/// border (the outermost pixels), ramp (levels of grey), name (the monitor's name and resolution) and orientation
/// (marks that tell a mirrored or turned image).
#[derive(Debug, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate show --test grid --monitor HDMI-1
  projector_calibrate show --patterns patterns --seconds 1 --pause 0.5 \\
      --monitor HDMI-1")]
#[command(after_help = "\
Keys: space, enter, right, down, page down: next; backspace, left, up, page up: previous; home, end; escape, q: end
Exit codes: 0 ended by a key, Ctrl-C or after the last picture; 1 the window failed; 2 invalid arguments or an \
unreadable file")]
pub(super) struct ShowArguments {
    /// The folder of patterns, or its patterns.yaml
    #[arg(long, value_name = "DIR|FILE", conflicts_with = "test")]
    patterns: Option<PathBuf>,
    /// The test image
    #[arg(long, value_name = "NAME", default_value = ALL, value_parser = test_names())]
    test: String,
    /// Time to show each image, ending after the last [default: until a key is pressed]
    #[arg(long, value_name = "SECONDS", value_parser = positive_seconds)]
    seconds: Option<Duration>,
    /// Time to show a checkerboard before each pattern and after the last: `projector_calibrate scan --bag` finds the
    /// patterns between them
    #[arg(long, value_name = "SECONDS", value_parser = positive_seconds, requires_all = ["patterns", "seconds"])]
    pause: Option<Duration>,
    /// Write the test images to this folder instead, as NAME.png; it must exist. Needs --size
    #[arg(short, long, value_name = "DIR", requires = "size", conflicts_with_all = ["patterns", "seconds"])]
    output: Option<PathBuf>,
    /// Width and height of the images written with -o, pixels
    #[arg(long, value_name = "WxH", value_parser = size_px, requires = "output")]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    monitor: MonitorArguments,
}

/// The name of all test images.
const ALL: &str = "all";

fn test_names() -> PossibleValuesParser {
    PossibleValuesParser::new(TestImage::ALL.map(TestImage::name).into_iter().chain([ALL]))
}

impl ShowArguments {
    /// The chosen test images.
    fn test_images(&self) -> Vec<TestImage> {
        self.test.parse().map_or_else(|_| TestImage::ALL.to_vec(), |image| vec![image])
    }

    fn slides(&self) -> Result<Slides, Failure> {
        let Some(path) = &self.patterns else {
            return Ok(Slides::Tests(self.test_images()));
        };
        let PatternList { projector_size_px, patterns, .. } = read_list(path)?;
        let patterns = patterns.into_iter().map(|(_, pattern)| pattern).collect();
        Ok(Slides::Patterns { size_px: projector_size_px, patterns, has_checkerboards: self.pause.is_some() })
    }
}

/// Reads a list of patterns, by its folder or its file, and logs its warnings.
///
/// # Errors
/// [`Failure::Unreadable`] with the file.
pub(super) fn read_list(path: &Path) -> Result<PatternList, Failure> {
    let file = if path.is_dir() { path.join(PATTERNS_FILE) } else { path.to_owned() };
    let list = read_patterns(&file).map_err(Failure::unreadable)?;
    list.warnings.iter().for_each(|warning| log::warn!("{warning}"));
    Ok(list)
}

/// Runs the command.
pub(super) fn run(arguments: &ShowArguments) -> Result<(), Failure> {
    if let (Some(folder), Some(size_px)) = (&arguments.output, arguments.size) {
        for test in arguments.test_images() {
            let path = folder.join(format!("{}.png", test.name()));
            image_file::write(&path, &test.draw(size_px, "projector")).map_err(Failure::refused)?;
        }
        return Ok(());
    }
    if arguments.monitor.tell_monitors().map_err(Failure::refused)? {
        return Ok(());
    }
    let slides = arguments.slides()?;
    let source = if arguments.patterns.is_some() { "patterns" } else { "test pictures" };
    let end = EndRequest::watch_signals().context("cannot handle signals").map_err(Failure::Refused)?;
    let watched = end.clone();
    let watch = WindowWatch::start(0, move || watched.is_requested());
    let _watch = watch.context("cannot watch the window").map_err(Failure::Refused)?;
    let times = arguments.seconds.map(|seconds| SlideTimes { seconds, pause: arguments.pause.unwrap_or_default() });
    let mut start = Some((end, times));
    let show = Arc::new(Mutex::new(SlideShow { slides, current: 0, monitor: None }));
    let mut failure = None;
    let shown = window::run_interactive(&arguments.monitor.window_options(source), |event, sink| {
        match event {
            UserEvent::Opened(monitor) | UserEvent::MonitorChanged(monitor) => {
                lock(&show).monitor = Some(monitor.clone());
            }
            UserEvent::Key { key, .. } if lock(&show).step(key) => {}
            UserEvent::Key { .. } => return,
        }
        lock(&show).present(sink);
        let started = start.take().map_or(Ok(()), |(end, times)| {
            close_on_end(end, sink.clone())?;
            times.map_or(Ok(()), |times| start_timer(Arc::clone(&show), times, sink.clone()))
        });
        if let Err(error) = started {
            failure = Some(error);
            sink.close();
        }
    });
    shown.map_err(Failure::refused)?;
    failure.map_or(Ok(()), |error| Err(Failure::Refused(error)))
}

/// Times to show images.
#[derive(Debug, Clone, Copy)]
struct SlideTimes {
    /// Time of a pattern or test image.
    seconds: Duration,
    /// Time of a checkerboard between patterns.
    pause: Duration,
}

/// Steps to the next image after the time of each, and closes the window after the last.
fn start_timer(show: Arc<Mutex<SlideShow>>, times: SlideTimes, sink: ImageSink) -> anyhow::Result<()> {
    let stepping = move || {
        loop {
            let is_checkerboard = lock(&show).is_checkerboard();
            thread::sleep(if is_checkerboard { times.pause } else { times.seconds });
            let mut show = lock(&show);
            if !show.advance() {
                break;
            }
            show.present(&sink);
        }
        sink.close();
    };
    spawn("slides", stepping).map(drop)
}

/// The images of a show.
#[derive(Debug)]
enum Slides {
    /// Test images in the monitor's resolution.
    Tests(Vec<TestImage>),
    /// Patterns in the resolution of their list, optionally with checkerboards before, between and after them.
    Patterns { size_px: [u32; 2], patterns: Vec<Pattern>, has_checkerboards: bool },
}

impl Slides {
    fn count(&self) -> usize {
        match self {
            Self::Tests(tests) => tests.len(),
            Self::Patterns { patterns, has_checkerboards: true, .. } => 2 * patterns.len() + 1,
            Self::Patterns { patterns, .. } => patterns.len(),
        }
    }

    /// `true` for a checkerboard: the first image and every other one after it.
    fn is_checkerboard(&self, index: usize) -> bool {
        matches!(self, Self::Patterns { has_checkerboards: true, .. }) && index.is_multiple_of(2)
    }

    /// An image; `None` for a monitor without pixels.
    fn image(&self, index: usize, monitor: &MonitorInfo) -> Option<ScreenImage> {
        match self {
            Self::Tests(tests) => {
                let (width, height) = monitor.size_px;
                ScreenImage::from_image(&tests.get(index)?.draw([width, height], &monitor.name)).ok()
            }
            Self::Patterns { size_px, .. } if self.is_checkerboard(index) => {
                ScreenImage::from_image(&TestImage::Checkerboard.draw(*size_px, &monitor.name)).ok()
            }
            Self::Patterns { size_px: [width, height], patterns, has_checkerboards } => {
                let pattern = patterns.get(if *has_checkerboards { index / 2 } else { index })?;
                let level = |is_lit| if is_lit { u8::MAX } else { 0 };
                Some(ScreenImage::from_fn(*width, *height, |u, v| [level(pattern.is_lit(u, v)); 3]))
            }
        }
    }
}

/// The image that is shown now, and its monitor.
#[derive(Debug)]
struct SlideShow {
    slides: Slides,
    current: usize,
    monitor: Option<MonitorInfo>,
}

impl SlideShow {
    fn is_checkerboard(&self) -> bool {
        self.slides.is_checkerboard(self.current)
    }

    /// Steps as a key says, from the last image to the first and back; `false` for other keys.
    fn step(&mut self, key: WindowKey) -> bool {
        let count = self.slides.count().max(1);
        self.current = match key {
            WindowKey::Space | WindowKey::Enter | WindowKey::Right | WindowKey::Down | WindowKey::PageDown => {
                (self.current + 1) % count
            }
            WindowKey::Backspace | WindowKey::Left | WindowKey::Up | WindowKey::PageUp => {
                (self.current + count - 1) % count
            }
            WindowKey::Home => 0,
            WindowKey::End => count - 1,
            WindowKey::Tab | WindowKey::Character(_) => return false,
        };
        true
    }

    /// Steps to the next image; `false` after the last.
    fn advance(&mut self) -> bool {
        self.current += 1;
        self.current < self.slides.count()
    }

    fn present(&self, sink: &ImageSink) {
        if let Some(image) = self.monitor.as_ref().and_then(|monitor| self.slides.image(self.current, monitor)) {
            sink.show(image);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_step_around_and_time_ends_after_the_last() {
        let slides = Slides::Tests(vec![TestImage::Grid, TestImage::Ramp, TestImage::Name]);
        let mut show = SlideShow { slides, current: 0, monitor: None };
        let mut after = |key| {
            assert!(show.step(key), "{key:?}");
            show.current
        };
        let keys =
            [WindowKey::Space, WindowKey::Right, WindowKey::PageDown, WindowKey::Left, WindowKey::Home, WindowKey::End];
        assert_eq!(keys.map(&mut after), [1, 2, 0, 2, 0, 2]);
        assert!(!show.step(WindowKey::Character('x')));
        assert!(!show.advance());
    }

    #[test]
    fn patterns_have_the_size_of_their_list_and_tests_that_of_the_monitor() {
        let monitor = MonitorInfo {
            name: "HDMI-1".to_owned(),
            position_px: (0, 0),
            size_px: (64, 48),
            is_primary: false,
            is_virtual: false,
        };
        let tests = Slides::Tests(vec![TestImage::Border]);
        assert_eq!(tests.image(0, &monitor).unwrap().size_px(), (64, 48));
        assert!(tests.image(1, &monitor).is_none());
        let patterns = vec![Pattern::White];
        let slides = Slides::Patterns { size_px: [8, 6], patterns: patterns.clone(), has_checkerboards: false };
        assert_eq!(slides.image(0, &monitor), Some(ScreenImage::from_fn(8, 6, |_, _| [255; 3])));
        let slides = Slides::Patterns { size_px: [8, 6], patterns, has_checkerboards: true };
        let images = [0, 1, 2].map(|index| slides.image(index, &monitor).unwrap());
        assert!(images[0] == images[2] && images[0].size_px() == (8, 6));
        assert_eq!(images[1], ScreenImage::from_fn(8, 6, |_, _| [255; 3]));
        assert_eq!((slides.count(), [0, 1, 2].map(|index| slides.is_checkerboard(index))), (3, [true, false, true]));
    }
}
