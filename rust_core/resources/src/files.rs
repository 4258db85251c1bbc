//! Access to files that a message, a robot description or another file names.
//!
//! - **Folders.** With all links followed, a file must lie in a ROS package (a folder with a `package.xml` or
//!   `manifest.xml`, and all below it) or in [`ResourceOptions::folders`]. So a link from an installed package to the
//!   package in the source space works, a link to `/etc` does not. Links of a package may also lead to other folders of
//!   its repository or workspace, whose files may not be read by their own addresses.
//! - **Kind.** Regular files only, checked before and after opening, because opening a device can have effects. Opening
//!   does not block, so a FIFO is not waited for.
//! - **Size.** At most [`ResourceOptions::max_file_bytes`], also of a file that grows while it is read.

use std::{
    fs::{File, Metadata, OpenOptions},
    os::unix::fs::{MetadataExt, OpenOptionsExt},
    path::{Component, Path, PathBuf},
};

use rcs_user_files::{other_kind, read_up_to};
use rustix::fs::OFlags;

use crate::ResourceError;

/// The files that make a folder a ROS package.
const MANIFESTS: [&str; 2] = ["package.xml", "manifest.xml"];
/// Entries of the top folder of a repository or of a catkin workspace.
const TOPS: [&str; 5] = [".git", ".hg", ".svn", ".catkin_workspace", ".catkin_tools"];
/// The size of a triangle in a binary STL file.
const STL_TRIANGLE_BYTES: u64 = 50;

/// Limits for reading files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResourceOptions {
    /// Size of the largest file. A mesh of any format may not expand to more triangles than a binary STL file of this
    /// size has.
    pub max_file_bytes: u64,
    /// Folders, in addition to ROS packages, whose files may be read.
    pub folders: Vec<PathBuf>,
}

impl Default for ResourceOptions {
    fn default() -> Self {
        Self { max_file_bytes: 512 << 20, folders: Vec::new() }
    }
}

impl ResourceOptions {
    /// Most corners of triangles of a mesh.
    pub(crate) fn max_corners(&self) -> usize {
        usize::try_from(self.max_file_bytes / STL_TRIANGLE_BYTES * 3).unwrap_or(usize::MAX).max(3)
    }

    /// Opens a file and returns it with its size, after checking folder, kind and size.
    ///
    /// # Errors
    /// [`ResourceError::Io`], [`ResourceError::NotAFile`], [`ResourceError::NotAllowed`], [`ResourceError::TooLarge`].
    pub(crate) fn open(&self, path: &Path) -> Result<(File, u64), ResourceError> {
        let io = |source| ResourceError::io(path, source);
        let real = path.canonicalize().map_err(io)?;
        check_kind(path, &real.metadata().map_err(io)?)?;
        if !self.allows(&real) && !is_linked(path, &real) {
            return Err(ResourceError::NotAllowed { path: path.to_owned(), real });
        }
        // NONBLOCK for a FIFO, NOFOLLOW for a link, that has just replaced the file.
        let flags = OFlags::NONBLOCK | OFlags::NOFOLLOW | OFlags::NOCTTY;
        let flags = i32::try_from(flags.bits()).unwrap_or(0);
        let file = OpenOptions::new().read(true).custom_flags(flags).open(&real).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        check_kind(path, &metadata)?;
        if metadata.len() > self.max_file_bytes {
            return Err(self.too_large(path));
        }
        Ok((file, metadata.len()))
    }

    /// Reads a file, after checking folder, kind and size.
    ///
    /// # Errors
    /// As for [`ResourceOptions::open`].
    pub(crate) fn read(&self, path: &Path) -> Result<Vec<u8>, ResourceError> {
        let (file, size) = self.open(path)?;
        read_up_to(file, size, self.max_file_bytes)
            .map_err(|source| ResourceError::io(path, source))?
            .ok_or_else(|| self.too_large(path))
    }

    /// `true` if a path without links lies in an allowed folder or in a ROS package.
    fn allows(&self, real: &Path) -> bool {
        let is_in = |folder: &PathBuf| folder.canonicalize().is_ok_and(|folder| real.starts_with(folder));
        self.folders.iter().any(is_in) || real.ancestors().skip(1).any(is_package)
    }

    fn too_large(&self, path: &Path) -> ResourceError {
        ResourceError::TooLarge { path: path.to_owned(), max_mb: self.max_file_bytes >> 20 }
    }
}

fn is_package(folder: &Path) -> bool {
    MANIFESTS.iter().any(|name| folder.join(name).is_file())
}

/// `true` if a path goes through a package whose links lead to the package's repository or workspace. Not with `..`,
/// whose meaning changes after a link.
fn is_linked(path: &Path, real: &Path) -> bool {
    let is_plain = path.is_absolute() && !path.components().any(|component| component == Component::ParentDir);
    let packages = path.ancestors().skip(1).filter(|folder| is_plain && is_package(folder));
    let mut places = packages.filter_map(|package| package.canonicalize().ok());
    places.any(|package| {
        let mut tops = package.ancestors().filter(|folder| TOPS.iter().any(|name| folder.join(name).exists()));
        tops.any(|top| real.starts_with(top))
    })
}

/// Refuses everything but regular files.
fn check_kind(path: &Path, metadata: &Metadata) -> Result<(), ResourceError> {
    match other_kind(metadata) {
        Some(kind) => Err(ResourceError::NotAFile { path: path.to_owned(), kind }),
        None => Ok(()),
    }
}

/// The text of a small harmless file, such as a manifest, in any folder.
///
/// # Errors
/// Not a regular file of at most `max_bytes`, in one line.
pub(crate) fn read_small_text(path: &Path, max_bytes: u64) -> Result<String, String> {
    let options = ResourceOptions { max_file_bytes: max_bytes, folders: vec![PathBuf::from("/")] };
    let bytes = options.read(path).map_err(|error| error.to_string())?;
    Ok(rcs_text::decode(&bytes).into_owned())
}

/// Identity of a file's contents, to detect changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FileStamp {
    device: u64,
    inode: u64,
    size: u64,
    modified: (i64, i64),
}

impl FileStamp {
    /// The size of the file in bytes.
    pub(crate) fn size(&self) -> u64 {
        self.size
    }

    /// The current stamp of a file; `None` if there is no such file.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let metadata = path.metadata().ok()?;
        Some(Self {
            device: metadata.dev(),
            inode: metadata.ino(),
            size: metadata.size(),
            modified: (metadata.mtime(), metadata.mtime_nsec()),
        })
    }
}
