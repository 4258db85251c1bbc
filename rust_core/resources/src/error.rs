//! Why a file could not be found, read or understood.
//!
//! Errors are clonable, since the store keeps the failure of a mesh as it keeps a mesh.

use std::{
    io,
    path::{Path, PathBuf},
    sync::Arc,
};

use thiserror::Error;

/// Why a resource cannot be used.
#[derive(Clone, Debug, Error)]
pub enum ResourceError {
    /// The scheme is one that is not fetched, such as `http://`.
    #[error("{url}: {scheme}:// addresses are not supported, only package:// and file://; nothing is downloaded")]
    UnsupportedScheme {
        /// The address as it was given.
        url: String,
        /// What stands before `://`.
        scheme: String,
    },
    /// Not an address: neither a scheme nor an absolute path.
    #[error("{url:?} is neither a package:// or file:// address nor an absolute path")]
    BadUrl {
        /// The address as it was given.
        url: String,
    },
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
        /// Which file.
        path: PathBuf,
        /// Why.
        source: Arc<io::Error>,
    },
    /// Something other than a regular file.
    #[error("{}: it is {kind}, only regular files are read", path.display())]
    NotAFile {
        /// Which.
        path: PathBuf,
        /// Such as `a FIFO`.
        kind: &'static str,
    },
    /// A file that may not be read.
    #[error(
        "{}{} is outside of all ROS packages; to allow it, add its folder to the parameter ~mesh_folders (option \
         --mesh-folder)",
        path.display(),
        leads_to(.path, .real)
    )]
    NotAllowed {
        /// Which file.
        path: PathBuf,
        /// The same without links.
        real: PathBuf,
    },
    /// A `package://` address that leads out of its package by `..`.
    #[error("{url}: the path leaves package {package:?}")]
    LeavesPackage {
        /// The address as it was given.
        url: String,
        /// The package's name.
        package: String,
    },
    /// A larger file than is read.
    #[error("{}: larger than {max_mb} MB; the parameter ~max_mesh_mb (option --max-mesh-mb) sets the limit", path.display())]
    TooLarge {
        /// Which file.
        path: PathBuf,
        /// The limit.
        max_mb: u64,
    },
    /// More resources are in use than are kept.
    #[error("{url}: {limit} meshes and textures are in use, no more are loaded")]
    TooMany {
        /// The address as it was given.
        url: String,
        /// The limit.
        limit: usize,
    },
    /// The reader of a file failed, which it never should.
    #[error("{url}: the file's reader failed: please report this with the file")]
    ReaderFailed {
        /// The address as it was given.
        url: String,
    },
    /// A mesh format that is not read.
    #[error("{}: mesh format {format} is not supported, only STL, COLLADA (.dae), OBJ, PLY and glTF (.gltf, .glb)", path.display())]
    UnsupportedFormat {
        /// Which file.
        path: PathBuf,
        /// The format's name.
        format: String,
    },
    /// A mesh file that cannot be understood.
    #[error("{}: {fault}", path.display())]
    BadMesh {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        fault: MeshFault,
    },
    /// A material names textures, none of them for its diffuse colour; rviz then requests one without a name.
    #[error("{}: a material names textures, but none for its diffuse colour", path.display())]
    NoDiffuseTexture {
        /// The mesh file.
        path: PathBuf,
    },
    /// An image that cannot be decoded.
    #[error("{}: not a readable image: {reason}", path.display())]
    BadImage {
        /// Which file.
        path: PathBuf,
        /// The decoder's message.
        reason: String,
    },
}

/// What is wrong with a mesh file's contents.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MeshFault {
    /// A binary STL file that ends before its last triangle.
    #[error("cut off: its header announces {announced} triangles, but only {present} are there")]
    TruncatedStl {
        /// The count in the header.
        announced: u32,
        /// The count that the bytes suffice for.
        present: u64,
    },
    /// Neither a binary nor a text STL file.
    #[error("not an STL file")]
    NotStl,
    /// Not well-formed XML.
    #[error("not well-formed XML: {0}")]
    Xml(String),
    /// A COLLADA file that breaks a rule.
    #[error("line {line}: {what}")]
    Collada {
        /// Line in the file, from 1.
        line: u32,
        /// Which rule.
        what: String,
    },
    /// A line of an OBJ, STL or PLY text file that cannot be read.
    #[error("line {line}: {what}")]
    Line {
        /// Line in the file, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// A rule of the format that is broken, in a file that has no lines.
    #[error("{0}")]
    Malformed(String),
    /// There is nothing to draw in it.
    #[error("no triangles in it")]
    Empty,
    /// More than is plausible; a damaged or hostile file.
    #[error("too large: more than {limit} {what}")]
    TooLarge {
        /// The most that is read.
        limit: usize,
        /// Of what.
        what: &'static str,
    },
}

impl ResourceError {
    pub(crate) fn io(path: impl Into<PathBuf>, source: io::Error) -> Self {
        Self::Io { path: path.into(), source: Arc::new(source) }
    }
}

/// Where the links of a path lead, if there are any.
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
