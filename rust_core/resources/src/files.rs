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
    io::Read,
    os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt},
    path::{Component, Path, PathBuf},
};

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

/// The contents of an open file; `None` for more than `max_bytes`.
fn read_up_to(file: File, size: u64, max_bytes: u64) -> std::io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::with_capacity(usize::try_from(size.min(max_bytes)).unwrap_or(0));
    file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= max_bytes).then_some(bytes))
}

/// Refuses everything but regular files.
fn check_kind(path: &Path, metadata: &Metadata) -> Result<(), ResourceError> {
    match other_kind(metadata) {
        Some(kind) => Err(ResourceError::NotAFile { path: path.to_owned(), kind }),
        None => Ok(()),
    }
}

/// The kind of a file that is not regular.
fn other_kind(metadata: &Metadata) -> Option<&'static str> {
    match metadata.file_type() {
        kind if kind.is_file() => None,
        kind if kind.is_dir() => Some("a folder"),
        kind if kind.is_fifo() => Some("a FIFO"),
        kind if kind.is_socket() => Some("a socket"),
        _ => Some("a device"),
    }
}

/// The text of a small harmless file, such as a manifest, in any folder; `None` unless it is a regular file of at most
/// `max_bytes`.
pub(crate) fn read_small_text(path: &Path, max_bytes: u64) -> Option<String> {
    let options = ResourceOptions { max_file_bytes: max_bytes, folders: vec![PathBuf::from("/")] };
    String::from_utf8(options.read(path).ok()?).ok()
}

/// Reads a file that the user has named, in any folder: a regular file of at most `max_bytes`. Does not block on a
/// FIFO.
///
/// # Errors
/// The system's errors, and files that are not regular or too large.
pub fn read_regular_file(path: &Path, max_bytes: u64) -> std::io::Result<Vec<u8>> {
    let check = |metadata: &Metadata| match other_kind(metadata) {
        Some(kind) => Err(std::io::Error::other(format!("it is {kind}, only regular files are read"))),
        None => Ok(metadata.len()),
    };
    check(&path.metadata()?)?;
    let flags = i32::try_from((OFlags::NONBLOCK | OFlags::NOCTTY).bits()).unwrap_or(0);
    let file = OpenOptions::new().read(true).custom_flags(flags).open(path)?;
    let size = check(&file.metadata()?)?;
    let bytes = if size > max_bytes { None } else { read_up_to(file, size, max_bytes)? };
    bytes.ok_or_else(|| std::io::Error::other(format!("larger than {} MB", max_bytes >> 20)))
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

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn a_file_that_grows_while_it_is_read_is_not_read_past_the_limit() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[7; 1000]).unwrap();
        let open = || {
            use std::io::Seek;
            let mut file = file.try_clone().unwrap();
            file.rewind().unwrap();
            file
        };
        // It had 10 bytes when it was opened.
        assert_eq!(read_up_to(open(), 10, 1000).unwrap().unwrap().len(), 1000);
        assert_eq!(read_up_to(open(), 10, 999).unwrap(), None);
    }

    #[test]
    fn only_regular_files_within_the_limit_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("file"), "text").unwrap();
        std::os::unix::fs::symlink(at("file"), at("link")).unwrap();
        assert_eq!(read_regular_file(&at("link"), 4).unwrap(), b"text");
        std::fs::File::create(at("sparse")).unwrap().set_len(40 << 30).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(at("fifo")).status().unwrap().success());
        let refusal = |path: &Path| read_regular_file(path, 8 << 20).unwrap_err().to_string();
        assert_eq!(refusal(&at("sparse")), "larger than 8 MB");
        assert_eq!(refusal(&at("fifo")), "it is a FIFO, only regular files are read");
        assert_eq!(refusal(folder.path()), "it is a folder, only regular files are read");
        assert_eq!(refusal(Path::new("/dev/zero")), "it is a device, only regular files are read");
    }
}
