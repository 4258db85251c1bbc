//! Pictures as a video file, encoded by the program `ffmpeg`.
//!
//! ffmpeg reads the pixels from its standard input and writes a file beside the final one, which gets its name when it
//! is whole. The ending of the name decides the format, as always with ffmpeg.

use std::ffi::{OsStr, OsString};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{sync_channel, Receiver, RecvTimeoutError, SyncSender};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rcs_scene::{join_within, Encoding, Picture};

use super::{Frame, Output, OutputError};

/// Looked up in PATH.
const ENCODER: &str = "ffmpeg";
/// How long the encoder may take to say which one it is.
const START_TIMEOUT: Duration = Duration::from_secs(60);
/// How long it may take for a picture, and for the rest once it has all of them.
const END_TIMEOUT: Duration = Duration::from_secs(600);
/// How long what it printed may take, once it has ended.
const PRINTED_TIMEOUT: Duration = Duration::from_secs(5);
/// How long its end may take once it is killed.
const KILL_TIMEOUT: Duration = Duration::from_secs(5);
/// How often its end is looked for.
const POLL_PERIOD: Duration = Duration::from_millis(10);

/// Why a video was not written.
#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    /// The encoder is not installed.
    #[error("{}: ffmpeg is needed to write a video, and is not on PATH (apt install ffmpeg)", path.display())]
    NoEncoder {
        /// The video.
        path: PathBuf,
    },
    /// The encoder cannot be run.
    #[error("{}: cannot run ffmpeg: {source}", path.display())]
    Run {
        /// The video.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The encoder failed.
    #[error("{}: ffmpeg failed: {reason}", path.display())]
    Failed {
        /// The video.
        path: PathBuf,
        /// The last line that it printed, or how it ended.
        reason: String,
    },
    /// All pictures of a video have one size.
    #[error("{}: the CameraInfo changes the size from {} to {} pixels, but a video has one", path.display(), size(.first_px), size(.then_px))]
    SizeChanged {
        /// The video.
        path: PathBuf,
        /// Columns and rows so far.
        first_px: [u32; 2],
        /// Columns and rows of the next picture.
        then_px: [u32; 2],
    },
    /// The finished file cannot get its name.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// The video.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
}

fn size([width, height]: &[u32; 2]) -> String {
    format!("{width}x{height}")
}

/// A video file. Without [`finish`](Output::finish) there is none: what was written of it is removed.
#[derive(Debug)]
pub struct VideoFile {
    file: PathBuf,
    unfinished: PathBuf,
    rate_hz: f64,
    end_timeout: Duration,
    running: Option<Running>,
}

/// The encoder at work.
#[derive(Debug)]
struct Running {
    child: Child,
    size_px: [u32; 2],
    /// The thread that writes to its input.
    input: Input,
    /// Reads what it prints, so that it never waits for that.
    printed: JoinHandle<String>,
}

impl VideoFile {
    /// Writes to this file, whose folder must exist, and replaces one that is there.
    ///
    /// # Errors
    /// [`VideoError`] if there is no ffmpeg.
    pub fn create(file: &Path, rate_hz: f64) -> Result<Self, VideoError> {
        #[expect(clippy::disallowed_methods, reason = "the encoder, without a shell")]
        let mut version = Command::new(ENCODER);
        version.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = version.spawn().map_err(|source| run_error(file, source))?;
        if end_of(&mut child, START_TIMEOUT).map_err(|source| run_error(file, source))?.is_none() {
            return Err(run_error(file, io::ErrorKind::TimedOut.into()));
        }
        let (file, unfinished) = (file.to_owned(), unfinished_name(file));
        Ok(Self { file, unfinished, rate_hz, end_timeout: END_TIMEOUT, running: None })
    }

    fn start(&self, size_px: [u32; 2], encoding: Encoding) -> Result<Running, VideoError> {
        #[expect(clippy::disallowed_methods, reason = "the encoder, without a shell")]
        let mut command = Command::new(ENCODER);
        command.args(arguments(size_px, encoding, self.rate_hz, &self.unfinished));
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        Running::start(&mut command, size_px).map_err(|source| run_error(&self.file, source))
    }

    /// Waits for the encoder's end, and returns why it failed.
    fn wait(&self, mut running: Running) -> Result<(), VideoError> {
        // The end of the pictures.
        drop(running.input);
        let status = end_of(&mut running.child, self.end_timeout).map_err(|source| run_error(&self.file, source))?;
        let Some(status) = status else {
            let reason = format!("it has not ended within {:?} after the last picture", self.end_timeout);
            return Err(VideoError::Failed { path: self.file.clone(), reason });
        };
        if status.success() {
            return Ok(());
        }
        // Another process may hold its standard error open.
        let printed = join_within(running.printed, PRINTED_TIMEOUT).and_then(Result::ok).unwrap_or_default();
        let last = printed.lines().map(str::trim).rfind(|line| !line.is_empty());
        let reason = last.map_or_else(|| status.to_string(), str::to_owned);
        Err(VideoError::Failed { path: self.file.clone(), reason })
    }

    fn add(&mut self, picture: &Arc<Picture>) -> Result<(), VideoError> {
        let size_px = [picture.width_px, picture.height_px];
        let mut running = match self.running.take() {
            Some(running) => running,
            None => self.start(size_px, picture.encoding)?,
        };
        if running.size_px != size_px {
            let (path, first_px) = (self.file.clone(), running.size_px);
            self.running = Some(running);
            return Err(VideoError::SizeChanged { path, first_px, then_px: size_px });
        }
        match running.input.write(picture, self.end_timeout) {
            Some(Ok(())) => {
                self.running = Some(running);
                Ok(())
            }
            // It has closed its input; its own error says why.
            Some(Err(source)) => {
                self.wait(running)?;
                Err(run_error(&self.file, source))
            }
            None => {
                end_now(&mut running.child);
                let reason = format!("it has not taken a picture within {:?}", self.end_timeout);
                Err(VideoError::Failed { path: self.file.clone(), reason })
            }
        }
    }
}

impl Output for VideoFile {
    fn send(&mut self, frame: &Frame) -> Result<(), OutputError> {
        Ok(self.add(&frame.picture)?)
    }

    fn finish(&mut self) -> Result<(), OutputError> {
        if let Some(running) = self.running.take() {
            self.wait(running)?;
            let failed = |source| VideoError::Write { path: self.file.clone(), source };
            rcs_files::atomic_file::replace(&self.unfinished, &self.file).map_err(failed)?;
        }
        Ok(())
    }
}

impl Drop for VideoFile {
    fn drop(&mut self) {
        if let Some(mut running) = self.running.take() {
            end_now(&mut running.child);
        }
        // There is none after success, and after a failure at the start.
        let _ = std::fs::remove_file(&self.unfinished);
    }
}

impl Running {
    fn start(command: &mut Command, size_px: [u32; 2]) -> io::Result<Self> {
        let (mut child, printed) = started(command)?;
        let input = Input::start(child.stdin.take())?;
        Ok(Self { child, size_px, input, printed })
    }
}

/// Writes pictures to a process on a thread, so that one that takes none is not waited for without a limit. Dropped, it
/// ends the process's input.
#[derive(Debug)]
struct Input {
    pictures: SyncSender<Arc<Picture>>,
    written: Receiver<io::Result<()>>,
}

impl Input {
    fn start(stdin: Option<ChildStdin>) -> io::Result<Self> {
        let (pictures, to_write) = sync_channel::<Arc<Picture>>(1);
        let (outcome, written) = sync_channel(1);
        let writing = move || {
            let mut stdin = stdin;
            for picture in to_write {
                let result = stdin.as_mut().map_or(Ok(()), |stdin| stdin.write_all(&picture.data));
                drop(picture);
                // Nobody receives it once it has taken too long.
                if outcome.send(result).is_err() {
                    return;
                }
            }
        };
        std::thread::Builder::new().name("ffmpeg-pictures".to_owned()).spawn(writing)?;
        Ok(Self { pictures, written })
    }

    /// Writes a picture. `None` if that takes longer than `timeout`.
    fn write(&self, picture: &Arc<Picture>, timeout: Duration) -> Option<io::Result<()>> {
        let ended = || Err(io::ErrorKind::BrokenPipe.into());
        // There is room: each is waited for.
        if self.pictures.send(Arc::clone(picture)).is_err() {
            return Some(ended());
        }
        match self.written.recv_timeout(timeout) {
            Ok(result) => Some(result),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => Some(ended()),
        }
    }
}

/// A process, and what it prints on standard error, which a thread reads.
fn started(command: &mut Command) -> io::Result<(Child, JoinHandle<String>)> {
    let mut child = command.spawn()?;
    let mut stderr = child.stderr.take();
    let read = move || {
        let mut text = Vec::new();
        if let Some(stderr) = &mut stderr {
            // What was read before an error is all there is to report.
            let _ = stderr.read_to_end(&mut text);
        }
        String::from_utf8_lossy(&text).into_owned()
    };
    let printed = std::thread::Builder::new().name("ffmpeg-errors".to_owned()).spawn(read)?;
    Ok((child, printed))
}

/// How a process has ended. `None` if it has not within this time: then it is killed.
fn end_of(child: &mut Child, timeout: Duration) -> io::Result<Option<ExitStatus>> {
    let until = Instant::now() + timeout;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if Instant::now() >= until {
            end_now(child);
            return Ok(None);
        }
        std::thread::sleep(POLL_PERIOD);
    }
}

/// Kills a process and waits for its end: a moment, or it hangs in a file system and is left to that.
fn end_now(child: &mut Child) {
    // Fails only if it has ended.
    let _ = child.kill();
    let until = Instant::now() + KILL_TIMEOUT;
    while matches!(child.try_wait(), Ok(None)) && Instant::now() < until {
        std::thread::sleep(POLL_PERIOD);
    }
}

fn run_error(file: &Path, source: io::Error) -> VideoError {
    let path = file.to_owned();
    if source.kind() == io::ErrorKind::NotFound {
        VideoError::NoEncoder { path }
    } else {
        VideoError::Run { path, source }
    }
}

/// The name of the file until it is whole: hidden, in the same folder, with the same ending.
fn unfinished_name(file: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(file.file_stem().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    if let Some(ending) = file.extension() {
        name.push(".");
        name.push(ending);
    }
    file.with_file_name(name)
}

/// ffmpeg's arguments: raw pictures from its standard input, the file in colours that every player shows. Those need
/// an even number of columns and rows; a black one is added to an odd number.
fn arguments(size_px: [u32; 2], encoding: Encoding, rate_hz: f64, file: &Path) -> Vec<OsString> {
    let pixels = match encoding {
        Encoding::Rgb8 => "rgb24",
        Encoding::Rgba8 => "rgba",
        Encoding::Bgr8 => "bgr24",
        Encoding::Bgra8 => "bgra",
        Encoding::Mono8 => "gray",
        Encoding::Mono16 => "gray16le",
    };
    let (size, rate) = (size(&size_px), rate_hz.to_string());
    let input = ["-f", "rawvideo", "-pixel_format", pixels, "-video_size", &size, "-framerate", &rate, "-i", "pipe:0"];
    let output = ["-an", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-y"];
    let general = ["-hide_banner", "-loglevel", "error"];
    let words = general.iter().chain(&input).chain(&output).map(|word| OsStr::new(*word).to_owned());
    // The protocol in front, because ffmpeg takes a colon in a path for the end of one.
    let mut address = OsString::from("file:");
    address.push(file);
    words.chain([address]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What an end of the video says where the encoder does this, and how long that took.
    fn error_of<E: std::fmt::Display + std::fmt::Debug>(
        script: &str,
        end_timeout: Duration,
        end: impl FnOnce(&mut VideoFile) -> Result<(), E>,
    ) -> (String, Duration) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("out.mp4");
        let unfinished = unfinished_name(&file);
        let mut video = VideoFile { file, unfinished, rate_hz: 1.0, end_timeout, running: None };
        let mut command = Command::new("sh");
        command.args(["-c", script]).stdin(Stdio::piped()).stderr(Stdio::piped());
        video.running = Some(Running::start(&mut command, [512, 512]).unwrap());
        let begun = Instant::now();
        let error = end(&mut video).unwrap_err().to_string();
        assert!(video.running.is_none());
        (error, begun.elapsed())
    }

    /// What `finish` says where the encoder does this once it has all pictures, and how long that took.
    fn finished(script: &str, end_timeout: Duration) -> (String, Duration) {
        error_of(script, end_timeout, VideoFile::finish)
    }

    #[test]
    fn an_encoder_that_takes_no_picture_is_ended() {
        // More than a pipe holds.
        let data = vec![7; 512 * 512 * 3];
        let encoding = Encoding::Rgb8;
        let picture = Arc::new(Picture { width_px: 512, height_px: 512, encoding, data });
        let write = |video: &mut VideoFile| video.add(&picture);
        let (error, took) = error_of("exec sleep 100", Duration::from_millis(200), write);
        assert!(error.ends_with("ffmpeg failed: it has not taken a picture within 200ms"), "{error}");
        assert!(took < Duration::from_secs(50), "{took:?}");
        let (error, _) = error_of("echo wrong >&2; exit 3", END_TIMEOUT, write);
        assert!(error.ends_with("ffmpeg failed: wrong"), "{error}");
    }

    #[test]
    fn an_encoder_that_hangs_at_the_end_is_ended_and_what_it_leaves_running_is_not_waited_for() {
        let (error, took) = finished("exec sleep 100", Duration::from_millis(200));
        assert!(error.ends_with("ffmpeg failed: it has not ended within 200ms after the last picture"), "{error}");
        assert!(took < Duration::from_secs(50), "{took:?}");
        let (error, took) = finished("echo wrong >&2; sleep 60 & exit 3", END_TIMEOUT);
        assert!(error.contains("ffmpeg failed: exit status: 3"), "{error}");
        assert!(took < Duration::from_secs(50), "{took:?}");
        let (error, _) = finished("echo first >&2; echo wrong >&2; exit 3", END_TIMEOUT);
        assert!(error.ends_with("ffmpeg failed: wrong"), "{error}");
    }
}
