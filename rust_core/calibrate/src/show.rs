//! `projector_calibrate show`: patterns and test pictures full screen on the projector, pixel for pixel.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use anyhow::{anyhow, Context as _};
use clap::builder::PossibleValuesParser;
use clap::Args;
use rcs_calibration::patterns::Pattern;
use rcs_files::capture::{read_patterns, PatternList, PATTERNS_FILE};
use rcs_files::picture_file;
use rcs_window::test_pictures::TestPicture;
use rcs_window::{self as window, MonitorInfo, PictureSink, ScreenPicture, UserEvent, WindowKey};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::arguments::{size, Size};
use super::Failure;
use rcs_node_support::monitor_arguments::MonitorArguments;
use rcs_node_support::window_watch::WindowWatch;

/// The longest that a picture is shown by itself, seconds.
const MOST_SECONDS: f64 = 86_400.0;

/// Shows patterns or test pictures full screen on the projector
///
/// Each in the projector's own resolution, unscaled: grid (lines with their coordinates), checkerboard, crosshair,
/// border (the outermost pixels), ramp (levels of grey), name (the monitor's name and resolution) and orientation
/// (marks that tell a mirrored or turned picture).
#[derive(Debug, Args)]
#[command(after_help = "\
Keys: space, enter, right, down, page down: next; backspace, left, up, page up: previous; home, end; escape, q: end
Exit codes: 0 ended by a key, Ctrl-C or after the last picture; 1 the window failed; 2 invalid arguments or an
unreadable file

Examples: projector_calibrate show --test grid --monitor HDMI-1
          projector_calibrate show --patterns patterns --seconds 1 --pause 0.5 --monitor HDMI-1")]
pub(super) struct ShowArguments {
    /// The folder of patterns, or its patterns.yaml
    #[arg(long, value_name = "DIR|FILE", conflicts_with = "test")]
    patterns: Option<PathBuf>,
    /// The test picture
    #[arg(long, value_name = "NAME", default_value = ALL, value_parser = test_names())]
    test: String,
    /// Show each picture so long and end after the last [default: until a key is pressed]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    seconds: Option<Duration>,
    /// Show a checkerboard for so long before each pattern and after the last: a camera that is recorded meanwhile sees
    /// where each begins, and `projector_calibrate scan --bag` finds them
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires_all = ["patterns", "seconds"])]
    pause: Option<Duration>,
    /// Write the test pictures to this folder instead, as NAME.png; it must exist. Needs --size
    #[arg(short, long, value_name = "DIR", requires = "size", conflicts_with_all = ["patterns", "seconds"])]
    output: Option<PathBuf>,
    /// Width and height of the pictures written with -o, pixels
    #[arg(long, value_name = "WxH", value_parser = size, requires = "output")]
    size: Option<Size>,
    #[command(flatten)]
    monitor: MonitorArguments,
}

/// What `--test` means all pictures by.
const ALL: &str = "all";

fn test_names() -> PossibleValuesParser {
    PossibleValuesParser::new(TestPicture::ALL.map(TestPicture::name).into_iter().chain([ALL]))
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if seconds > 0.0 && seconds <= MOST_SECONDS {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(format!("not more than 0 and at most {MOST_SECONDS}"))
    }
}

impl ShowArguments {
    /// The test pictures that are asked for.
    fn test_pictures(&self) -> Vec<TestPicture> {
        self.test.parse().map_or_else(|_| TestPicture::ALL.to_vec(), |picture| vec![picture])
    }

    fn slides(&self) -> Result<Slides, Failure> {
        let Some(path) = &self.patterns else {
            return Ok(Slides::Tests(self.test_pictures()));
        };
        let PatternList { projector_size_px, patterns, .. } = read_list(path)?;
        let patterns = patterns.into_iter().map(|(_, pattern)| pattern).collect();
        Ok(Slides::Patterns { size_px: projector_size_px, patterns, has_marks: self.pause.is_some() })
    }
}

/// Reads a list of patterns, by its folder or its file. What it warns of is logged.
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
    if let (Some(folder), Some(Size(size_px))) = (&arguments.output, arguments.size) {
        for test in arguments.test_pictures() {
            let path = folder.join(format!("{}.png", test.name()));
            picture_file::write(&path, &test.draw(size_px, "projector")).map_err(Failure::refused)?;
        }
        return Ok(());
    }
    if arguments.monitor.tell_monitors().map_err(Failure::refused)? {
        return Ok(());
    }
    let slides = arguments.slides()?;
    let source = if arguments.patterns.is_some() { "patterns" } else { "test pictures" };
    let signals = Signals::new([SIGINT, SIGTERM]).context("cannot handle signals").map_err(Failure::Refused)?;
    let _watch = WindowWatch::start_with_signals(0).context("cannot watch the window").map_err(Failure::Refused)?;
    let times = arguments.seconds.map(|seconds| Times { seconds, pause: arguments.pause.unwrap_or_default() });
    let mut start = Some((signals, times));
    let show = Arc::new(Mutex::new(Show { slides, current: 0, monitor: None }));
    let mut failure = None;
    let shown = window::run_interactive(&arguments.monitor.window_options(source), |event, sink| {
        match event {
            UserEvent::Opened(monitor) | UserEvent::MonitorChanged(monitor) => {
                lock(&show).monitor = Some(monitor.clone());
            }
            UserEvent::Key(key) if lock(&show).step(key) => {}
            UserEvent::Key(_) => return,
        }
        lock(&show).present(sink);
        let started = start.take().map_or(Ok(()), |(signals, times)| {
            close_on_signal(signals, sink.clone())?;
            times.map_or(Ok(()), |times| step_by_itself(Arc::clone(&show), times, sink.clone()))
        });
        if let Err(error) = started {
            failure = Some(error);
            sink.close();
        }
    });
    shown.map_err(Failure::refused)?;
    failure.map_or(Ok(()), |error| Err(Failure::Refused(anyhow!("cannot start a thread: {error}"))))
}

fn lock(show: &Mutex<Show>) -> MutexGuard<'_, Show> {
    show.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Closes the window when one of the signals comes.
pub(super) fn close_on_signal(mut signals: Signals, sink: PictureSink) -> io::Result<()> {
    let waiting = move || {
        if signals.forever().next().is_some() {
            sink.close();
        }
    };
    thread::Builder::new().name("signals".to_owned()).spawn(waiting).map(drop)
}

/// For how long pictures are shown.
#[derive(Debug, Clone, Copy)]
struct Times {
    seconds: Duration,
    /// For how long marks are.
    pause: Duration,
}

/// Shows the next picture after the time of each, and closes the window after the last.
fn step_by_itself(show: Arc<Mutex<Show>>, times: Times, sink: PictureSink) -> io::Result<()> {
    let stepping = move || {
        loop {
            let is_mark = {
                let show = lock(&show);
                show.slides.is_mark(show.current)
            };
            thread::sleep(if is_mark { times.pause } else { times.seconds });
            let mut show = lock(&show);
            if !show.advance() {
                break;
            }
            show.present(&sink);
        }
        sink.close();
    };
    thread::Builder::new().name("slides".to_owned()).spawn(stepping).map(drop)
}

/// What is shown one after the other.
#[derive(Debug)]
enum Slides {
    /// Drawn in the monitor's resolution.
    Tests(Vec<TestPicture>),
    /// In the resolution of their list; with marks before, between and after them.
    Patterns { size_px: [u32; 2], patterns: Vec<Pattern>, has_marks: bool },
}

impl Slides {
    fn count(&self) -> usize {
        match self {
            Self::Tests(tests) => tests.len(),
            Self::Patterns { patterns, has_marks: true, .. } => 2 * patterns.len() + 1,
            Self::Patterns { patterns, .. } => patterns.len(),
        }
    }

    /// Whether a picture is a mark: the first one and every other one after it.
    fn is_mark(&self, index: usize) -> bool {
        matches!(self, Self::Patterns { has_marks: true, .. }) && index.is_multiple_of(2)
    }

    /// A picture; none for a monitor without pixels.
    fn picture(&self, index: usize, monitor: &MonitorInfo) -> Option<ScreenPicture> {
        match self {
            Self::Tests(tests) => {
                let (width, height) = monitor.size_px;
                ScreenPicture::from_picture(&tests.get(index)?.draw([width, height], &monitor.name)).ok()
            }
            Self::Patterns { size_px, .. } if self.is_mark(index) => {
                ScreenPicture::from_picture(&TestPicture::Checkerboard.draw(*size_px, &monitor.name)).ok()
            }
            Self::Patterns { size_px: [width, height], patterns, has_marks } => {
                let pattern = patterns.get(if *has_marks { index / 2 } else { index })?;
                let level = |is_lit| if is_lit { u8::MAX } else { 0 };
                Some(ScreenPicture::from_fn(*width, *height, |u, v| [level(pattern.is_lit(u, v)); 3]))
            }
        }
    }
}

/// Which picture is shown where.
#[derive(Debug)]
struct Show {
    slides: Slides,
    current: usize,
    monitor: Option<MonitorInfo>,
}

impl Show {
    /// Goes where a key leads, from the last picture to the first and back; false for a key that leads nowhere.
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

    /// Goes to the next picture; false after the last.
    fn advance(&mut self) -> bool {
        self.current += 1;
        self.current < self.slides.count()
    }

    fn present(&self, sink: &PictureSink) {
        if let Some(picture) = self.monitor.as_ref().and_then(|monitor| self.slides.picture(self.current, monitor)) {
            sink.show(picture);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_step_around_and_time_ends_after_the_last() {
        let slides = Slides::Tests(vec![TestPicture::Grid, TestPicture::Ramp, TestPicture::Name]);
        let mut show = Show { slides, current: 0, monitor: None };
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
        let tests = Slides::Tests(vec![TestPicture::Border]);
        assert_eq!(tests.picture(0, &monitor).unwrap().size_px(), (64, 48));
        assert!(tests.picture(1, &monitor).is_none());
        let patterns = vec![Pattern::White];
        let slides = Slides::Patterns { size_px: [8, 6], patterns: patterns.clone(), has_marks: false };
        assert_eq!(slides.picture(0, &monitor), Some(ScreenPicture::from_fn(8, 6, |_, _| [255; 3])));
        let slides = Slides::Patterns { size_px: [8, 6], patterns, has_marks: true };
        let pictures = [0, 1, 2].map(|index| slides.picture(index, &monitor).unwrap());
        assert!(pictures[0] == pictures[2] && pictures[0].size_px() == (8, 6));
        assert_eq!(pictures[1], ScreenPicture::from_fn(8, 6, |_, _| [255; 3]));
        assert_eq!((slides.count(), [0, 1, 2].map(|index| slides.is_mark(index))), (3, [true, false, true]));
    }

    #[test]
    fn the_seconds_are_more_than_none_and_not_endless() {
        assert_eq!(seconds("0.5"), Ok(Duration::from_millis(500)));
        for text in ["0", "-1", "nan", "inf", "1e9", "soon"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
