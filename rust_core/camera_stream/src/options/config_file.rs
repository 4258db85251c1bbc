//! Finds the file of a config's name.
//!
//! As rviz does, a name without slashes that is no file here is looked for in `~/.rviz`, with or without the ending
//! `.rviz`. Unlike rviz, which shows its default config then, a name that is found nowhere is an error.

use std::path::{Path, PathBuf};

use rcs_node_support::user_file::relative_path_hint;

use crate::cli::Cli;

/// A config's name that is no file in any of the places where it could be.
#[derive(Debug, thiserror::Error)]
#[error("no config '{name}': there is no file {places}; {hint}", name = .name.display(), hint = relative_path_hint())]
pub(crate) struct ConfigNotFound {
    name: PathBuf,
    places: String,
}

/// Replaces the config's name by the file that it means.
///
/// # Errors
/// [`ConfigNotFound`].
pub(crate) fn find_config(cli: &mut Cli) -> Result<(), ConfigNotFound> {
    let Some(name) = cli.config_mut() else { return Ok(()) };
    let found = find(name, std::env::home_dir().as_deref())?;
    if found != *name {
        log::info!("config '{}': reading {}", name.display(), found.display());
    }
    *name = found;
    Ok(())
}

/// The file that a name means. A name with slashes is itself, whether there is such a file or not.
fn find(name: &Path, home: Option<&Path>) -> Result<PathBuf, ConfigNotFound> {
    // A pipe is a file, too.
    let is_file = |path: &Path| path.metadata().is_ok_and(|metadata| !metadata.is_dir());
    let is_plain = !name.as_os_str().is_empty() && name.file_name() == Some(name.as_os_str());
    if is_file(name) || !is_plain {
        return Ok(name.to_owned());
    }
    let mut places = vec![name.to_owned()];
    if let Some(folder) = home.map(|home| home.join(".rviz")) {
        let mut with_ending = name.as_os_str().to_owned();
        with_ending.push(".rviz");
        places.extend([folder.join(name), folder.join(with_ending)]);
    }
    if let Some(found) = places.iter().find(|place| is_file(place)) {
        return Ok(found.clone());
    }
    let places: Vec<String> = places.iter().map(|place| place.display().to_string()).collect();
    Err(ConfigNotFound { name: name.to_owned(), places: places.join(", ") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_without_slashes_is_looked_for_here_and_then_in_the_users_folder() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join(".rviz");
        std::fs::create_dir_all(folder.join("both")).unwrap();
        for file in ["scene.rviz", "plain", "both.rviz"] {
            std::fs::write(folder.join(file), "").unwrap();
        }
        let find = |name: &str| find(Path::new(name), Some(home.path()));
        for (name, found) in
            [("scene", "scene.rviz"), ("scene.rviz", "scene.rviz"), ("plain", "plain"), ("both", "both.rviz")]
        {
            assert_eq!(find(name).unwrap(), folder.join(found), "{name}");
        }
        let here = tempfile::NamedTempFile::new_in(".").unwrap();
        let name = Path::new(here.path().file_name().unwrap());
        std::fs::write(folder.join(name), "").unwrap();
        assert_eq!(super::find(name, Some(home.path())).unwrap(), name, "a file here comes first");
        for path in ["./scene", "config/scene", "/scene", "..", "", "scene/"] {
            assert_eq!(find(path).unwrap(), Path::new(path), "{path} is itself");
        }
    }

    #[test]
    fn an_error_names_the_places() {
        let error = find(Path::new("scene"), Some(Path::new("/nowhere"))).unwrap_err();
        let error = error.to_string();
        let places =
            "no config 'scene': there is no file scene, /nowhere/.rviz/scene, /nowhere/.rviz/scene.rviz; relative to";
        assert!(error.starts_with(places) && error.ends_with("or an absolute path"), "{error}");
        let error = find(Path::new("scene"), None).unwrap_err().to_string();
        assert!(error.contains("there is no file scene; "), "{error}");
    }
}
