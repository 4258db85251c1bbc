//! The operator's blackouts on the disk, so that a node which ends during one does not come back lit.
//!
//! The file is written before a blackout is acknowledged. One that cannot be read is a blackout of everything.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use rcs_files::atomic_file::write_atomically;
use serde_json::{json, Map, Value};

/// Most bytes of the file.
const MAX_BYTES: u64 = 1 << 20;

/// The blackouts that hold, each with who said so.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Blackouts {
    /// Of everything.
    pub all: Option<String>,
    /// Of single cameras, by name.
    pub cameras: BTreeMap<String, String>,
}

/// A node's file of blackouts.
#[derive(Clone, Debug)]
pub struct BlackoutFile(Option<PathBuf>);

impl BlackoutFile {
    /// The file of a node, by its whole name, below the folder in which ROS keeps a user's files.
    pub fn of_node(ros_folder: Option<&Path>, node: &str) -> Self {
        let name = node.trim_matches('/').replace('/', "-");
        Self(ros_folder.map(|folder| folder.join("rviz_camera_stream").join(format!("{name}.blackout.json"))))
    }

    /// The blackouts that an earlier run left. An unreadable file blacks out everything, and says so.
    pub fn read(&self) -> Blackouts {
        let Some(path) = &self.0 else { return Blackouts::default() };
        self.try_read(path).unwrap_or_else(|reason| {
            let why = format!("the blackouts of the last run are not known: {}: {reason}", path.display());
            log::error!("black until it is released: {why}");
            Blackouts { all: Some(why), ..Blackouts::default() }
        })
    }

    fn try_read(&self, path: &Path) -> Result<Blackouts, String> {
        let about = match fs::metadata(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Blackouts::default()),
            about => about.map_err(|error| error.to_string())?,
        };
        if !about.is_file() || about.len() > MAX_BYTES {
            return Err("it is no file of blackouts".to_owned());
        }
        let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
        blackouts_of(&text).ok_or_else(|| "it is damaged".to_owned())
    }

    /// Keeps blackouts for the next run.
    ///
    /// # Errors
    /// Why the file cannot be written, with its path.
    pub fn write(&self, blackouts: &Blackouts) -> Result<(), String> {
        let path = self.0.as_ref().ok_or("there is no home folder for it; set ROS_HOME")?;
        let cameras: Map<_, _> = blackouts.cameras.iter().map(|(name, by)| (name.clone(), json!(by))).collect();
        let text = json!({"all": blackouts.all, "cameras": cameras}).to_string();
        let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| {
            let write = |file: &mut io::BufWriter<fs::File>| file.write_all(text.as_bytes());
            write_atomically(path, write, |error| error)
        });
        written.map_err(|error| format!("{}: {error}", path.display()))
    }
}

/// The blackouts in a file's text; `None` if anything in it is not as it was written.
fn blackouts_of(text: &str) -> Option<Blackouts> {
    let value: Value = serde_json::from_str(text).ok()?;
    let all = match value.get("all")? {
        Value::Null => None,
        by => Some(by.as_str()?.to_owned()),
    };
    let camera = |(name, by): (&String, &Value)| Some((name.clone(), by.as_str()?.to_owned()));
    let cameras = value.get("cameras")?.as_object()?.iter().map(camera).collect::<Option<_>>()?;
    Some(Blackouts { all, cameras })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_and_what_cannot_be_read_is_black() {
        let folder = tempfile::tempdir().unwrap();
        let file = BlackoutFile::of_node(Some(folder.path()), "/robot/eye");
        assert_eq!(file.read(), Blackouts::default());
        let cameras = [("Left \"1\"".to_owned(), "key b".to_owned())].into();
        let blackouts = Blackouts { all: Some("/script".to_owned()), cameras };
        file.write(&blackouts).unwrap();
        assert_eq!(file.read(), blackouts);
        let path = folder.path().join("rviz_camera_stream/robot-eye.blackout.json");
        for damaged in ["", "{}", "{\"all\": null}", "{\"all\": true, \"cameras\": {}}", "\u{0}"] {
            fs::write(&path, damaged).unwrap();
            assert!(file.read().all.is_some_and(|why| why.contains("robot-eye")), "{damaged}");
        }
        file.write(&blackouts).unwrap();
        let valid = fs::read_to_string(&path).unwrap();
        for (padding, is_read) in [(MAX_BYTES as usize - valid.len(), true), (MAX_BYTES as usize, false)] {
            fs::write(&path, format!("{valid}{}", " ".repeat(padding))).unwrap();
            assert_eq!(file.read() == blackouts, is_read, "{padding} blanks");
        }
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        assert!(file.read().all.is_some());
        fs::remove_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path.parent().unwrap(), "").unwrap();
        assert!(file.read().all.is_some(), "a file in place of its folder");
        assert!(BlackoutFile::of_node(None, "/eye").write(&blackouts).is_err());
    }
}
