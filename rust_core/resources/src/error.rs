//! Errors of finding, reading and parsing files. They are clonable because the store keeps a mesh's failure.

use std::{
    io,
    path::{Path, PathBuf},
    sync::Arc,
};

use rcs_text::xml::PassedOver;
use thiserror::Error;

/// Error of a resource.
#[derive(Clone, Debug, Error)]
pub enum ResourceError {
    /// A scheme that is not supported, such as `http://`.
    #[error("{url}: {scheme}:// addresses are not supported, only package:// and file://; nothing is downloaded")]
    UnsupportedScheme {
        /// The address as it was given.
        url: String,
        /// The part before `://`.
        scheme: String,
    },
    /// Not an address: neither a scheme nor an absolute path.
    #[error("{0:?} is neither a package:// or file:// address nor an absolute path")]
    BadUrl(String),
    /// No such package on the search path.
    #[error("{url}: package {package:?} is not on the search path ({})", list(.searched))]
    NoSuchPackage {
        /// The address as it was given.
        url: String,
        /// The package's name.
        package: String,
        /// The folders that were searched.
        searched: Vec<PathBuf>,
    },
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: Arc<io::Error>,
    },
    /// Something other than a regular file.
    #[error("{}: it is {kind}, only regular files are read", path.display())]
    NotAFile {
        /// The path.
        path: PathBuf,
        /// A kind such as `a FIFO`.
        kind: &'static str,
    },
    /// A file outside of all packages and allowed folders.
    #[error(
        "{}{} is outside of all ROS packages; to allow it, add its folder to the parameter ~mesh_folder (option \
         --mesh-folder)",
        path.display(),
        leads_to(.path, .real)
    )]
    NotAllowed {
        /// The file.
        path: PathBuf,
        /// The path without symbolic links.
        real: PathBuf,
    },
    /// A `package://` address that leaves its package by `..`.
    #[error("{url}: the path leaves package {package:?}")]
    LeavesPackage {
        /// The address as it was given.
        url: String,
        /// The package's name.
        package: String,
    },
    /// A file above the size limit.
    #[error("{}: larger than {max_mb} MB; the parameter ~max_mesh_mb (option --max-mesh-mb) sets the limit", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The limit.
        max_mb: u64,
    },
    /// All resources of a full store are in use.
    #[error("{url}: {limit} meshes and textures are in use, no more are loaded")]
    TooMany {
        /// The address as it was given.
        url: String,
        /// The limit.
        limit: usize,
    },
    /// The reader of a file panicked.
    #[error("{0}: the file's reader failed: please report this with the file")]
    ReaderFailed(String),
    /// A mesh format that is not supported.
    #[error("{}: mesh format {format} is not supported, only STL, COLLADA (.dae), OBJ, PLY and glTF (.gltf, .glb)", path.display())]
    UnsupportedFormat {
        /// The file.
        path: PathBuf,
        /// The format's name.
        format: String,
    },
    /// An invalid mesh file.
    #[error("{}: {fault}", path.display())]
    BadMesh {
        /// The file.
        path: PathBuf,
        /// The fault in its contents.
        fault: MeshFault,
    },
    /// A material names textures, none of them for its diffuse colour; rviz then requests one without a name.
    #[error("{0}: a material names textures, but none for its diffuse colour")]
    NoDiffuseTexture(PathBuf),
    /// A fault of a mesh file that changes nothing.
    #[error("{}: passed over: {fault}", path.display())]
    PassedOver {
        /// The file.
        path: PathBuf,
        /// The fault.
        fault: PassedOver,
    },
    /// An image that cannot be decoded.
    #[error("{}: not a readable image: {reason}", path.display())]
    BadImage {
        /// The file.
        path: PathBuf,
        /// The decoder's message.
        reason: String,
    },
}

/// Fault in a mesh file's contents.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MeshFault {
    /// A truncated binary STL file.
    #[error("cut off: its header announces {announced} triangles, but only {present} are there")]
    TruncatedStl {
        /// The count in the header.
        announced: u32,
        /// The count of complete triangles.
        present: u64,
    },
    /// Neither a binary nor a text STL file.
    #[error("not an STL file")]
    NotStl,
    /// Not well-formed XML.
    #[error("not well-formed XML: {0}")]
    Xml(String),
    /// An invalid line of a text file, or element of a COLLADA file.
    #[error("line {line}: {what}")]
    Line {
        /// Line in the file, from 1.
        line: usize,
        /// The fault.
        what: String,
    },
    /// A fault in a format without lines.
    #[error("{0}")]
    Malformed(String),
    /// A file without triangles.
    #[error("no triangles in it")]
    Empty,
    /// A count above a limit, in a damaged or hostile file.
    #[error("too large: more than {limit} {what}")]
    TooLarge {
        /// The limit.
        limit: usize,
        /// The counted items.
        what: &'static str,
    },
}

impl ResourceError {
    pub(crate) fn io(path: impl Into<PathBuf>, source: io::Error) -> Self {
        Self::Io { path: path.into(), source: Arc::new(source) }
    }
}

/// The target of a path with symbolic links, for a message.
fn leads_to(path: &Path, real: &Path) -> String {
    if path == real {
        String::new()
    } else {
        format!(": {}", real.display())
    }
}

fn list(paths: &[PathBuf]) -> String {
    if paths.is_empty() {
        return "ROS_PACKAGE_PATH is empty".to_owned();
    }
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(":")
}
