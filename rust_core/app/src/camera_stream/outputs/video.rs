//! Pictures as a video file, encoded by the program `ffmpeg`.
//!
//! ffmpeg reads the pixels from its standard input and writes a file beside the final one, which gets its name when it
//! is whole. The ending of the name decides the format, as always with ffmpeg.

use std::ffi::{OsStr, OsString};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;

use rcs_scene::Encoding;

use super::{Frame, Output, OutputError};

/// Looked up in PATH.
const ENCODER: &str = "ffmpeg";

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
    running: Option<Running>,
}

/// The encoder at work.
#[derive(Debug)]
struct Running {
    child: Child,
    size_px: [u32; 2],
    /// Reads what it prints, so that it never waits for that.
    printed: JoinHandle<String>,
}

impl VideoFile {
    /// Writes to this file, whose folder must exist, and replaces one that is there.
    ///
    /// # Errors
    /// [`VideoError`] if there is no ffmpeg.
    pub fn create(file: &Path, rate_hz: f64) -> Result<Self, VideoError> {
        let mut version = Command::new(ENCODER);
        version.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        version.status().map_err(|source| run_error(file, source))?;
        let (file, unfinished) = (file.to_owned(), unfinished_name(file));
        Ok(Self { file, unfinished, rate_hz, running: None })
    }

    fn start(&self, size_px: [u32; 2], encoding: Encoding) -> Result<Running, VideoError> {
        let mut command = Command::new(ENCODER);
        command.args(arguments(size_px, encoding, self.rate_hz, &self.unfinished));
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|source| run_error(&self.file, source))?;
        let mut stderr = child.stderr.take();
        let read = move || {
            let mut text = Vec::new();
            if let Some(stderr) = &mut stderr {
                // What was read before an error is all there is to report.
                let _ = stderr.read_to_end(&mut text);
            }
            String::from_utf8_lossy(&text).into_owned()
        };
        let printed = std::thread::Builder::new().name("ffmpeg-errors".to_owned()).spawn(read);
        let printed = printed.map_err(|source| run_error(&self.file, source))?;
        Ok(Running { child, size_px, printed })
    }

    /// Waits for the encoder's end, and returns why it failed.
    fn wait(&self, mut running: Running) -> Result<(), VideoError> {
        // The end of the pictures.
        drop(running.child.stdin.take());
        let status = running.child.wait().map_err(|source| run_error(&self.file, source))?;
        let printed = running.printed.join().unwrap_or_default();
        if status.success() {
            return Ok(());
        }
        let last = printed.lines().map(str::trim).rfind(|line| !line.is_empty());
        let reason = last.map_or_else(|| status.to_string(), str::to_owned);
        Err(VideoError::Failed { path: self.file.clone(), reason })
    }

    fn add(&mut self, frame: &Frame) -> Result<(), VideoError> {
        let picture = &frame.picture;
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
        let written = running.child.stdin.as_mut().map_or(Ok(()), |stdin| stdin.write_all(&picture.data));
        match written {
            Ok(()) => {
                self.running = Some(running);
                Ok(())
            }
            // It has closed its input; its own error says why.
            Err(source) => {
                self.wait(running)?;
                Err(run_error(&self.file, source))
            }
        }
    }
}

impl Output for VideoFile {
    fn send(&mut self, frame: &Frame) -> Result<(), OutputError> {
        Ok(self.add(frame)?)
    }

    fn finish(&mut self) -> Result<(), OutputError> {
        if let Some(running) = self.running.take() {
            self.wait(running)?;
            let failed = |source| VideoError::Write { path: self.file.clone(), source };
            std::fs::rename(&self.unfinished, &self.file).map_err(failed)?;
        }
        Ok(())
    }
}

impl Drop for VideoFile {
    fn drop(&mut self) {
        if let Some(mut running) = self.running.take() {
            // Both fail only if it has ended.
            let _ = running.child.kill();
            let _ = running.child.wait();
        }
        // There is none after success, and after a failure at the start.
        let _ = std::fs::remove_file(&self.unfinished);
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
