//! Files that a user names: a relative path that leads nowhere is explained, because `roslaunch` starts nodes in a
//! folder that few people expect.

use std::env;
use std::path::{Path, PathBuf};

/// Argument that `roslaunch` gives each node, and nobody else does.
const LAUNCHED: &str = "__log:=";

/// A relative path without a file.
#[derive(Debug, thiserror::Error)]
#[error("{path}: no such file; {hint}", path = .0.display(), hint = relative_path_hint())]
pub struct NoSuchFile(PathBuf);

/// Checks that a relative path leads to something. Problems of other paths are their readers' to report.
///
/// # Errors
/// [`NoSuchFile`].
pub fn check(path: &Path) -> Result<(), NoSuchFile> {
    if path.is_relative() && !path.exists() {
        return Err(NoSuchFile(path.to_owned()));
    }
    Ok(())
}

/// The folder that relative paths start from, and what to write instead.
pub fn relative_path_hint() -> String {
    let is_launched = env::args_os().any(|argument| argument.to_string_lossy().starts_with(LAUNCHED));
    hint(&env::current_dir().unwrap_or_default(), env::home_dir().as_deref(), is_launched)
}

fn hint(folder: &Path, home: Option<&Path>, is_launched: bool) -> String {
    let folder = match home.and_then(|home| folder.strip_prefix(home).ok()) {
        Some(below) => Path::new("~").join(below),
        None => folder.to_owned(),
    };
    let who = if is_launched { "roslaunch starts nodes in" } else { "the program was started in" };
    format!("relative to the folder {who} ({}); use $(find PACKAGE)/… or an absolute path", folder.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hint_names_the_folder() {
        let home = Some(Path::new("/home/me"));
        assert_eq!(
            hint(Path::new("/home/me/.ros"), home, true),
            "relative to the folder roslaunch starts nodes in (~/.ros); use $(find PACKAGE)/… or an absolute path"
        );
        let hint = hint(Path::new("/tmp"), home, false);
        assert!(hint.starts_with("relative to the folder the program was started in (/tmp); use "), "{hint}");
    }

    #[test]
    fn only_a_relative_path_without_a_file_is_an_error() {
        assert!(check(Path::new("Cargo.toml")).is_ok() && check(Path::new("/missing/scene.rviz")).is_ok());
        let error = check(Path::new("missing/scene.rviz")).unwrap_err().to_string();
        assert!(error.starts_with("missing/scene.rviz: no such file; relative to the folder "), "{error}");
    }
}
