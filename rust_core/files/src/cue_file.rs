//! Cues of an operator: named sets of visible displays with a brightness, in a YAML file beside a config.
//!
//! ```yaml
//! cues:
//! - name: Only the path
//!   brightness: 0.8
//!   cameras:
//!     CameraPub: [path, sensors / scan]
//! ```
//!
//! A camera shows the listed displays and hides all others. A file with a value that cannot be used has no cues.

use std::collections::{BTreeMap, HashSet};
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::atomic_file::write_atomically;
use crate::FileError;

const MAX_FILE_BYTES: u64 = 1 << 20;
/// Most characters of a name.
const MOST_NAME_CHARS: usize = 80;

/// A named state of all cameras.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cue {
    /// Name, unique in a file.
    pub name: String,
    /// Share of each level that is shown, 0 to 1.
    pub brightness: f64,
    /// Displays that each camera shows, by names with those of their groups before them: `group / display`.
    pub cameras: BTreeMap<String, Vec<String>>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CueFile {
    cues: Vec<Cue>,
}

/// The file of a config's cues: `scene.cues.yaml` beside `scene.rviz`.
pub fn cue_file(config: &Path) -> PathBuf {
    config.with_extension("cues.yaml")
}

/// Reads a file's cues in their order; none if there is no file.
///
/// # Errors
/// The file cannot be read, or has a value that cannot be used.
pub fn read_cues(path: &Path) -> Result<Vec<Cue>, FileError> {
    let bytes = match rcs_user_files::read(path, MAX_FILE_BYTES) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(FileError::new(path, error)),
    };
    let file: CueFile = serde_yaml_ng::from_slice(&bytes).map_err(|error| FileError::new(path, error))?;
    check(&file.cues).map_err(|why| FileError::new(path, why))?;
    Ok(file.cues)
}

/// Writes a file's cues, all or none.
///
/// # Errors
/// A cue has a value that cannot be used, or the file cannot be written; the previous file stays.
pub fn write_cues(path: &Path, cues: Vec<Cue>) -> Result<(), FileError> {
    check(&cues).map_err(|why| FileError::new(path, why))?;
    let text = serde_yaml_ng::to_string(&CueFile { cues }).map_err(|error| FileError::writing(path, error))?;
    let io_error = |error| FileError::writing(path, error);
    write_atomically(path, |out| out.write_all(text.as_bytes()).map_err(io_error), io_error)
}

/// Checks that each cue can be used.
fn check(cues: &[Cue]) -> Result<(), String> {
    let mut names = HashSet::new();
    for Cue { name, brightness, .. } in cues {
        let count = name.chars().count();
        if name.trim() != name || name.chars().any(char::is_control) || !(1..=MOST_NAME_CHARS).contains(&count) {
            return Err(format!("{name:?} is no name: 1 to {MOST_NAME_CHARS} characters without spaces around them"));
        }
        if !names.insert(name) {
            return Err(format!("there are two cues {name}"));
        }
        if !(0.0..=1.0).contains(brightness) {
            return Err(format!("cue {name}: brightness: {brightness} is no number from 0 to 1"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cue(name: &str, brightness: f64) -> Cue {
        let shown = vec!["path".to_owned(), "sensors / scan".to_owned()];
        Cue { name: name.to_owned(), brightness, cameras: [("Left".to_owned(), shown)].into() }
    }

    #[test]
    fn cues_are_read_as_they_were_written_and_no_file_has_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = cue_file(&folder.path().join("my.scene.rviz"));
        assert_eq!(path.file_name().unwrap(), "my.scene.cues.yaml");
        assert_eq!(read_cues(&path), Ok(Vec::new()));
        let cues = vec![cue("Only the path", 0.8), cue("2", 1.0), cue("nothing: at \"all\"", 0.0)];
        write_cues(&path, cues.clone()).unwrap();
        assert_eq!(read_cues(&path), Ok(cues));
    }

    #[test]
    fn a_damaged_file_has_no_cues_and_names_the_fault() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.cues.yaml");
        let whole = "cues:\n- name: a\n  brightness: 0.5\n  cameras: {Left: [path]}\n";
        let second = "- name: b\n  brightness: 1\n  cameras: {}\n";
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_cues(&path).map_err(|error| error.to_string())
        };
        assert_eq!(read(&format!("{whole}{second}")).unwrap().len(), 2);
        let faults = [
            (String::new(), "x.cues.yaml: "),
            (whole[..20].to_owned(), "x.cues.yaml: "),
            (whole.replace("0.5", ".nan"), "cue a: brightness: NaN is no number from 0 to 1"),
            (whole.replace("0.5", "1.5"), "1.5 is no number from 0 to 1"),
            (whole.replace("0.5", "half"), "brightness"),
            (whole.replace("name: a", "name: ' '"), "is no name"),
            (format!("{whole}  fade: 1\n"), "fade"),
            (format!("{whole}{}", second.replace("b\n", "a\n")), "two cues a"),
        ];
        for (text, expected) in faults {
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
        let before = read(whole);
        write_cues(&path, vec![cue("a", f64::NAN)]).unwrap_err();
        assert_eq!(read_cues(&path).map_err(|error| error.to_string()), before);
    }
}
