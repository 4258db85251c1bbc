//! Records of a study beside the config: marks in a CSV file, and snapshots of images.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use rcs_files::atomic_file::write_atomically;
use rcs_files::image_file::{encode, Coding};
use rcs_messages::Time;
use rcs_process::lock;

use crate::camera::output::CameraPublisher;
use crate::runtime::shared::NodeState;

const HEADER: &str = "time,cue,brightness,shown\n";
const MAX_MARKS_BYTES: u64 = 16 << 20;
const PNG_LEVEL: u8 = 6;
/// Held while a line is written, as several pages may do so.
static WRITING: Mutex<()> = Mutex::new(());

/// Appends a line to the config's marks: ROS time, cue, brightness, and what each camera shows. Returns the line.
///
/// # Errors
/// The file cannot be written.
pub(super) fn mark(shared: &NodeState) -> Result<String, String> {
    let time = seconds(shared.ros.now(), 9);
    let share = shared.control.brightness().fade.share(Instant::now());
    let cue = shared.cues.current().map(|cue| cue.name).unwrap_or_default();
    let shown: Vec<String> = shared.cameras().iter().map(|camera| shown_text(shared, camera)).collect();
    let line = [time, cell(&cue), format!("{share:.3}"), cell(&shown.join(" | "))].join(",");
    let file = marks_file(shared);
    append(&file, &line).map_err(|error| format!("{}: cannot write: {error}", file.display()))?;
    Ok(line)
}

/// The marks as CSV.
///
/// # Errors
/// There are none, or the file cannot be read.
pub(super) fn marks(shared: &NodeState) -> Result<String, String> {
    let file = marks_file(shared);
    rcs_user_files::read_text(&file, MAX_MARKS_BYTES).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => "there are no marks so far".to_owned(),
        _ => format!("{}: {error}", file.display()),
    })
}

/// Writes a camera's image, as it is shown, into a PNG file. Returns its name in the config's folder.
///
/// # Errors
/// There is no such camera or no image, or the file cannot be written.
pub(super) fn snapshot(shared: &NodeState, camera: &str) -> Result<String, String> {
    let cameras = shared.cameras();
    let found = cameras.iter().find(|known| known.view().name == camera);
    let found = found.ok_or_else(|| format!("there is no camera {camera}"))?;
    let image = found.shown_image().ok_or_else(|| format!("camera {camera} has no image so far"))?;
    drop(cameras);
    let image = image.content(Instant::now());
    let png = encode(&image, Coding::Png { level: PNG_LEVEL }).map_err(|error| error.to_string())?;
    let folder = shared.config_file().with_extension("snapshots");
    let plain = |c: char| if c.is_alphanumeric() || c == '-' { c } else { '_' };
    let name: String = camera.chars().map(plain).collect();
    let file = folder.join(format!("{name}-{}.png", seconds(shared.ros.now(), 3)));
    let written = fs::create_dir_all(&folder).and_then(|()| write_atomically(&file, |out| out.write_all(&png), |e| e));
    written.map_err(|error| format!("{}: cannot write: {error}", file.display()))?;
    let shown = folder.parent().and_then(|parent| file.strip_prefix(parent).ok()).unwrap_or(&file);
    Ok(shown.display().to_string())
}

fn marks_file(shared: &NodeState) -> PathBuf {
    shared.config_file().with_extension("marks.csv")
}

/// Contents of a camera's image: its displays, or what stands in their place.
fn shown_text(shared: &NodeState, camera: &CameraPublisher) -> String {
    let name = &camera.view().name;
    let (operator, dark) = (shared.control.of_camera(name), camera.figures().dark);
    let scene =
        || format!("{}{}", operator.paused.as_ref().map_or("", |_| "paused: "), camera.shown_displays().join("; "));
    let test = operator.test_image.map(|test| format!("test picture {}", test.name()));
    let shown = dark.map(|why| format!("black: {why}")).or(test).unwrap_or_else(scene);
    format!("{name}: {shown}")
}

/// A text as a cell of CSV.
fn cell(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

fn seconds(time: Time, digits: usize) -> String {
    let fraction = format!("{:09}", time.nsec);
    format!("{}.{}", time.sec, fraction.get(..digits).unwrap_or(&fraction))
}

/// Appends a line, with the header before the first one and after what an interrupted write has left.
fn append(path: &Path, line: &str) -> io::Result<()> {
    let _writing = lock(&WRITING);
    if fs::metadata(path).is_ok_and(|known| !known.is_file()) {
        return Err(io::Error::other("it is no regular file"));
    }
    let mut file = File::options().read(true).append(true).create(true).open(path)?;
    let mut last = [b'\n'];
    let before = match file.seek(SeekFrom::End(0))? {
        0 => HEADER,
        _ => {
            file.seek(SeekFrom::End(-1))?;
            file.read_exact(&mut last)?;
            if last == *b"\n" {
                ""
            } else {
                "\n"
            }
        }
    };
    file.write_all(format!("{before}{line}\n").as_bytes())?;
    file.sync_data()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_follow_each_other_below_one_header() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.marks.csv");
        append(&path, "1").unwrap();
        append(&path, "2").unwrap();
        fs::write(&path, fs::read_to_string(&path).unwrap() + "half").unwrap();
        append(&path, "3").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), format!("{HEADER}1\n2\nhalf\n3\n"));
        assert!(append(folder.path(), "4").is_err() && append(&folder.path().join("no/x.csv"), "4").is_err());
    }

    #[test]
    fn cells_keep_commas_and_quotes() {
        assert_eq!(["a b", "a,b", "a\"b"].map(cell), ["a b", "\"a,b\"", "\"a\"\"b\""]);
        let time = Time { sec: 12, nsec: 3_400_000 };
        assert_eq!([9, 3].map(|digits| seconds(time, digits)), ["12.003400000", "12.003"]);
    }
}
