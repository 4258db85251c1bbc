//! File names in a capture folder. They never lead out of it, links included: a folder that somebody sent must not make
//! a program read or write other files.

use std::fmt;
use std::path::{Component, Path, PathBuf};

use serde::de::{Deserializer, Error, Visitor};
use serde::Deserialize;

use super::error::CaptureError;

/// A relative name without `..` and control characters.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct FileName(String);

impl FileName {
    /// Path of the file.
    pub(super) fn in_folder(&self, folder: &Path) -> PathBuf {
        folder.join(&self.0)
    }

    /// Path for reading.
    ///
    /// # Errors
    /// [`CaptureError::Outside`] or [`CaptureError::Read`].
    pub(super) fn to_read(&self, folder: &Path) -> Result<PathBuf, CaptureError> {
        let path = self.in_folder(folder);
        let real =
            |path: &Path| path.canonicalize().map_err(|source| CaptureError::Read { path: path.to_owned(), source });
        let (target, real_folder) = (real(&path)?, real(folder)?);
        if target.starts_with(real_folder) {
            Ok(path)
        } else {
            Err(CaptureError::Outside { path, target })
        }
    }

    /// The name as given.
    pub(super) fn as_str(&self) -> &str {
        &self.0
    }
}

impl<'de> Deserialize<'de> for FileName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameVisitor;
        impl Visitor<'_> for NameVisitor {
            type Value = FileName;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a file's name")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<FileName, E> {
                let is_inside = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
                if name.is_empty() || name.contains(char::is_control) {
                    return Err(E::custom(format!("{name:?} is not a file's name")));
                }
                if !Path::new(name).components().all(is_inside) {
                    return Err(E::custom(format!("the file {name:?} is not in the folder")));
                }
                Ok(FileName(name.to_owned()))
            }
        }
        deserializer.deserialize_str(NameVisitor)
    }
}
