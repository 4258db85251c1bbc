//! Images as a video file, encoded by the program `ffmpeg`.
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

use anyhow::{anyhow, Context, Error, Result};
use rcs_process::join_within;
use rcs_scene::{Encoding, Image};

use super::{Output, OutputFrame};

/// Looked up in PATH.
const ENCODER: &str = "ffmpeg";
/// Time for the encoder to print its version.
const START_TIMEOUT: Duration = Duration::from_secs(60);
/// Time for an image, and for the rest once it has all of them.
const END_TIMEOUT: Duration = Duration::from_secs(600);
/// Time for the printed text, once it has ended.
const PRINTED_TIMEOUT: Duration = Duration::from_secs(5);
/// Time for its end once it is killed.
const KILL_TIMEOUT: Duration = Duration::from_secs(5);
const POLL_PERIOD: Duration = Duration::from_millis(10);

fn size([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

/// A video file. Without [`finish`](Output::finish) there is none: what was written of it is removed.
#[derive(Debug)]
pub(crate) struct VideoFile {
    file: PathBuf,
    unfinished: PathBuf,
    rate_hz: f64,
    end_timeout: Duration,
    running: Option<Running>,
}

/// The running encoder.
#[derive(Debug)]
struct Running {
    child: Child,
    size_px: [u32; 2],
    input: EncoderInput,
    /// Reads its standard error, so that it never blocks on it.
    printed: JoinHandle<String>,
}

impl VideoFile {
    /// Writes to this file, whose folder must exist, and replaces one that is there.
    ///
    /// # Errors
    /// ffmpeg is not installed or cannot be run.
    pub(crate) fn create(file: &Path, rate_hz: f64) -> Result<Self> {
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

    fn start(&self, size_px: [u32; 2], encoding: Encoding) -> Result<Running> {
        #[expect(clippy::disallowed_methods, reason = "the encoder, without a shell")]
        let mut command = Command::new(ENCODER);
        command.args(arguments(size_px, encoding, self.rate_hz, &self.unfinished));
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        Running::start(&mut command, size_px).map_err(|source| run_error(&self.file, source))
    }

    fn wait(&self, mut running: Running) -> Result<()> {
        // Closes its input.
        drop(running.input);
        let status = end_of(&mut running.child, self.end_timeout).map_err(|source| run_error(&self.file, source))?;
        let Some(status) = status else {
            let reason = format!("it has not ended within {:?} after the last picture", self.end_timeout);
            return Err(self.failure(&reason));
        };
        if status.success() {
            return Ok(());
        }
        // Another process may hold its standard error open.
        let printed = join_within(running.printed, PRINTED_TIMEOUT).and_then(Result::ok).unwrap_or_default();
        let last = printed.lines().map(str::trim).rfind(|line| !line.is_empty());
        let reason = last.map_or_else(|| status.to_string(), str::to_owned);
        Err(self.failure(&reason))
    }

    fn failure(&self, reason: &str) -> Error {
        anyhow!("{}: ffmpeg failed: {reason}", self.file.display())
    }

    fn add(&mut self, image: &Arc<Image>) -> Result<()> {
        let size_px = [image.width_px, image.height_px];
        let mut running = match self.running.take() {
            Some(running) => running,
            None => self.start(size_px, image.encoding)?,
        };
        if running.size_px != size_px {
            let (file, first, then) = (self.file.display(), size(running.size_px), size(size_px));
            let error =
                anyhow!("{file}: the CameraInfo changes the size from {first} to {then} pixels, but a video has one");
            self.running = Some(running);
            return Err(error);
        }
        match running.input.write(image, self.end_timeout) {
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
                Err(self.failure(&reason))
            }
        }
    }
}

impl Output for VideoFile {
    fn send(&mut self, frame: &OutputFrame) -> Result<()> {
        self.add(&frame.image.content(Instant::now()))
    }

    fn finish(&mut self) -> Result<()> {
        if let Some(running) = self.running.take() {
            self.wait(running)?;
            let replaced = rcs_files::atomic_file::replace(&self.unfinished, &self.file);
            replaced.with_context(|| format!("{}: cannot write", self.file.display()))?;
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
        let input = EncoderInput::start(child.stdin.take())?;
        Ok(Self { child, size_px, input, printed })
    }
}

/// Writes images to a process on a thread, so that the wait for one that reads none has a limit. Closes the process's
/// input when dropped.
#[derive(Debug)]
struct EncoderInput {
    images: SyncSender<Arc<Image>>,
    written: Receiver<io::Result<()>>,
}

impl EncoderInput {
    fn start(stdin: Option<ChildStdin>) -> io::Result<Self> {
        let (images, to_write) = sync_channel::<Arc<Image>>(1);
        let (outcome, written) = sync_channel(1);
        let writing = move || {
            let mut stdin = stdin;
            for image in to_write {
                let result = stdin.as_mut().map_or(Ok(()), |stdin| stdin.write_all(&image.data));
                drop(image);
                // Nobody receives it once it has taken too long.
                if outcome.send(result).is_err() {
                    return;
                }
            }
        };
        std::thread::Builder::new().name("ffmpeg-pictures".to_owned()).spawn(writing)?;
        Ok(Self { images, written })
    }

    /// Writes an image. `None` if that takes longer than `timeout`.
    fn write(&self, image: &Arc<Image>, timeout: Duration) -> Option<io::Result<()>> {
        let ended = || Err(io::ErrorKind::BrokenPipe.into());
        // There is room: each is waited for.
        if self.images.send(Arc::clone(image)).is_err() {
            return Some(ended());
        }
        match self.written.recv_timeout(timeout) {
            Ok(result) => Some(result),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => Some(ended()),
        }
    }
}

/// Starts a process, and a thread that reads its standard error.
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

/// Waits for the end of a process. `None` if it takes longer: then it is killed.
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

/// Kills a process and waits for its end, unless it hangs in a file system.
fn end_now(child: &mut Child) {
    // Fails only if it has ended.
    let _ = child.kill();
    let until = Instant::now() + KILL_TIMEOUT;
    while matches!(child.try_wait(), Ok(None)) && Instant::now() < until {
        std::thread::sleep(POLL_PERIOD);
    }
}

fn run_error(file: &Path, error: io::Error) -> Error {
    let file = file.display();
    match error.kind() {
        io::ErrorKind::NotFound => {
            anyhow!("{file}: ffmpeg is needed to write a video, and is not on PATH (apt install ffmpeg)")
        }
        _ => Error::new(error).context(format!("{file}: cannot run ffmpeg")),
    }
}

/// Name of the unfinished file: hidden, in the same folder, with the same ending.
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

/// ffmpeg's arguments: raw images from its standard input, the file in yuv420p, which every player shows. It needs even
/// sizes; a black column or row is added to odd ones. Players take the matrix of BT.709 for a video of HD size and that
/// of BT.601 (SMPTE 170M) for a smaller one, so the file is written and labelled with that. The primaries are the
/// image's in both, sRGB's, which are BT.709's.
fn arguments(size_px: [u32; 2], encoding: Encoding, rate_hz: f64, file: &Path) -> Vec<OsString> {
    let pixels = match encoding {
        Encoding::Rgb8 => "rgb24",
        Encoding::Rgba8 => "rgba",
        Encoding::Bgr8 => "bgr24",
        Encoding::Bgra8 => "bgra",
        Encoding::Mono8 => "gray",
        Encoding::Mono16 => "gray16le",
    };
    let (size, rate) = (size(size_px), rate_hz.to_string());
    let input = ["-f", "rawvideo", "-pixel_format", pixels, "-video_size", &size, "-framerate", &rate, "-i", "pipe:0"];
    let matrix = if size_px[0] >= 1280 || size_px[1] > 576 { "bt709" } else { "smpte170m" };
    let filter = format!("pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix={matrix}:out_range=tv");
    let output = ["-an", "-vf", &filter, "-pix_fmt", "yuv420p", "-y"];
    let labels = ["-colorspace", matrix, "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"];
    let general = ["-hide_banner", "-loglevel", "error"];
    let words = general.iter().chain(&input).chain(&output).chain(&labels).map(|word| OsStr::new(*word).to_owned());
    // The protocol in front, because ffmpeg takes a colon in a path for the end of one.
    let mut address = OsString::from("file:");
    address.push(file);
    words.chain([address]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error at the end of a video whose encoder is this script, and the time that took.
    fn error_of(
        script: &str,
        end_timeout: Duration,
        end: impl FnOnce(&mut VideoFile) -> Result<()>,
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

    /// The error of `finish` with this encoder, and the time that took.
    fn finished(script: &str, end_timeout: Duration) -> (String, Duration) {
        error_of(script, end_timeout, VideoFile::finish)
    }

    #[test]
    fn a_video_is_written_and_labelled_with_the_matrix_that_players_take_for_its_size() {
        for (size_px, matrix) in [([64, 48], "smpte170m"), ([1024, 576], "smpte170m"), ([1280, 720], "bt709")] {
            let words = arguments(size_px, Encoding::Rgb8, 5.0, Path::new("v.mp4"));
            let words = words.join(OsStr::new(" ")).into_string().unwrap();
            assert!(words.contains(&format!("scale=out_color_matrix={matrix}:out_range=tv ")), "{words}");
            assert!(words.contains(&format!(" -colorspace {matrix} -color_primaries bt709 ")), "{words}");
        }
    }

    #[test]
    fn an_encoder_that_takes_no_image_is_ended() {
        // More than a pipe holds.
        let data = vec![7; 512 * 512 * 3];
        let encoding = Encoding::Rgb8;
        let image = Arc::new(Image { width_px: 512, height_px: 512, encoding, data });
        let write = |video: &mut VideoFile| video.add(&image);
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
