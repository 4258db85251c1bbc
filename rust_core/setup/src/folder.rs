//! The folder that is written: its path, whether it may be written, and the files.

use std::fs;
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{anyhow, Context as _};
use rcs_files::atomic_file::write_atomically;
use rcs_files::projector::ProjectorFile;

use crate::arguments::plain;
use crate::error::SetupError;
use crate::plan::Plan;
use crate::profile::Profile;
use crate::scene_names::{LAUNCH_FILE, PROJECTOR_FILE, README_FILE, SCENE_FILE, WINDOW_LAUNCH_FILE};
use crate::{launch, projector_guess, readme, scene};

/// A file's name and text.
pub(crate) type NamedText = (&'static str, String);

/// The folder's absolute path. It stands in launch files, where roslaunch splits words at spaces.
///
/// # Errors
/// [`SetupError::Invalid`] for a path that cannot stand there.
pub(crate) fn absolute(folder: &Path) -> Result<PathBuf, SetupError> {
    let invalid = |error: anyhow::Error| SetupError::Invalid(error.context("folder"));
    let path = std::path::absolute(folder).map_err(|error| invalid(error.into()))?;
    // Without `.` in its end, and without links, which may lead elsewhere later.
    let path = fs::canonicalize(&path).unwrap_or(path);
    let text = path.to_str().ok_or_else(|| invalid(anyhow!("{} is not UTF-8", path.display())))?;
    plain(text, "/._-+@~,").map_err(|reason| invalid(anyhow!(reason)))?;
    Ok(path)
}

/// Checks that the folder does not exist, is empty, or may be written to.
///
/// # Errors
/// [`SetupError::Refused`].
pub(crate) fn check_free(folder: &Path, overwrite: bool) -> Result<(), SetupError> {
    let is_used = match fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_some(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => false,
        Err(error) => return Err(SetupError::Refused(anyhow!("{}: {error}", folder.display()))),
    };
    if is_used && !overwrite {
        let name = folder.display();
        return Err(SetupError::Refused(anyhow!("{name}: has files; choose another folder or give --overwrite")));
    }
    Ok(())
}

/// All files of a plan.
///
/// # Errors
/// [`SetupError::Invalid`] for answers that cannot be written.
pub(crate) fn files(plan: &Plan) -> Result<Vec<NamedText>, SetupError> {
    let projector = projector_guess::text(plan).map_err(|error| SetupError::Invalid(error.into()))?;
    let mut files = vec![
        (PROJECTOR_FILE, projector),
        (SCENE_FILE, scene::text(plan)),
        (LAUNCH_FILE, launch::text(plan)),
        (README_FILE, readme::text(plan)),
    ];
    if plan.answers.profile == Profile::TwoComputers {
        files.push((WINDOW_LAUNCH_FILE, launch::window_text(plan)));
    }
    Ok(files)
}

/// Writes the files, and the folder if it does not exist. Returns the files that were kept: a calibrated
/// `projector.yaml` is not replaced by a guess.
///
/// # Errors
/// [`SetupError::Refused`] with the file that cannot be written.
pub(crate) fn write(folder: &Path, files: &[NamedText]) -> Result<Vec<&'static str>, SetupError> {
    let refused =
        |error: io::Error, path: &Path| SetupError::Refused(anyhow!("{}: cannot write: {error}", path.display()));
    fs::create_dir_all(folder).map_err(|error| refused(error, folder))?;
    let mut kept = Vec::new();
    for (name, text) in files {
        let path = folder.join(name);
        if *name == PROJECTOR_FILE && is_calibrated(&path).map_err(SetupError::Refused)? {
            kept.push(*name);
            continue;
        }
        write_atomically(&path, |file| file.write_all(text.as_bytes()), |error| error)
            .map_err(|error| refused(error, &path))?;
    }
    Ok(kept)
}

/// A folder's projector, if it is calibrated.
///
/// # Errors
/// [`SetupError::Refused`] for a file that cannot be read.
pub(crate) fn calibrated(folder: &Path) -> Result<Option<ProjectorFile>, SetupError> {
    let path = folder.join(PROJECTOR_FILE);
    if !is_calibrated(&path).map_err(SetupError::Refused)? {
        return Ok(None);
    }
    ProjectorFile::read(&path).map(Some).map_err(|error| SetupError::Refused(error.into()))
}

/// `true` for a file of the projector that is not a setup's guess.
fn is_calibrated(path: &Path) -> anyhow::Result<bool> {
    let mut first = vec![0; projector_guess::MARK.len()];
    match rcs_user_files::open(path).and_then(|(mut file, _)| file.read_exact(&mut first)) {
        Ok(()) => Ok(first != projector_guess::MARK.as_bytes()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error).with_context(|| path.display().to_string()),
    }
}
