//! Files that messages and robot descriptions name: packages, meshes and textures.
//!
//! Each input becomes files of a package in a temporary folder, because meshes name other files. The folder is kept
//! for the next input: making and removing one takes longer than reading most inputs.

use std::io::Cursor;
use std::panic::catch_unwind;
use std::path::Path;
use std::task::Poll;

use image::{ImageFormat, ImageReader};
use rcs_resources::{MeshStore, PackageIndex, Retry};
use tempfile::TempDir;

use crate::first_byte;

const PACKAGE: &[u8] = b"<package><name>robot</name></package>";
/// Stands between the OBJ and the MTL in one input.
const BETWEEN_FILES: &[u8] = b"\n=====\n";
/// A triangle whose material has a texture.
const TEXTURED: &[u8] = b"mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

/// The key of a glTF file's list of images.
const IMAGES: &[u8] = b"images";

thread_local! {
    static FOLDER: TempDir = packages();
}

/// A folder of packages that has one, `robot`.
fn packages() -> TempDir {
    let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("no temporary folder: {error}"));
    let package = folder.path().join("robot");
    std::fs::create_dir(&package).unwrap_or_else(|error| panic!("{}: {error}", package.display()));
    write(folder.path(), "package.xml", PACKAGE);
    folder
}

fn write(folder: &Path, name: &str, bytes: &[u8]) {
    let path = folder.join("robot").join(name);
    std::fs::write(&path, bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

fn index(folder: &Path) -> PackageIndex {
    PackageIndex::new([folder.to_owned()])
}

/// A `package.xml`: the package is found by the name in it or by its folder's.
pub(crate) fn package_xml(data: &[u8]) {
    thread_local! {
        static OWN_FOLDER: TempDir = packages();
    }
    OWN_FOLDER.with(|folder| {
        write(folder.path(), "package.xml", data);
        let index = index(folder.path());
        for name in ["robot", "a_package", ""] {
            if let Some(found) = index.package(name) {
                assert!(found.starts_with(folder.path()));
            }
        }
    });
}

/// Loads a mesh of the package; what loads is fit to draw.
fn load(files: &[(&str, &[u8])], name: &str) {
    FOLDER.with(|folder| {
        files.iter().for_each(|(name, bytes)| write(folder.path(), name, bytes));
        let store = MeshStore::new(index(folder.path()));
        let url = format!("file://{}/robot/{name}", folder.path().display());
        let mesh = match store.mesh(&url, Retry::Yes) {
            Poll::Ready(Ok(mesh)) => mesh,
            Poll::Ready(Err(error)) => {
                assert!(!error.to_string().is_empty());
                return;
            }
            Poll::Pending => panic!("a store that loads on the thread that asks is never pending"),
        };
        assert!(!mesh.parts.is_empty());
        for part in &mesh.parts {
            assert!(!part.mesh.indices.is_empty() && part.mesh.indices.len() % 3 == 0);
            assert!(part.mesh.indices.iter().all(|&index| (index as usize) < part.mesh.vertices.len()));
            for vertex in &part.mesh.vertices {
                assert!(vertex.position.iter().chain(&vertex.normal).all(|number| number.is_finite()));
            }
            if let Some(texture) = &part.material.texture {
                assert_eq!(texture.rgba.len(), texture.width as usize * texture.height as usize);
            }
        }
        mesh.warnings.iter().for_each(|warning| drop(warning.to_string()));
    });
}

/// An STL, binary or text.
pub(crate) fn stl(data: &[u8]) {
    load(&[("a.stl", data)], "a.stl");
}

/// A COLLADA file.
pub(crate) fn collada(data: &[u8]) {
    load(&[("a.dae", data)], "a.dae");
}

/// An OBJ and, after a line of `=====`, its MTL.
pub(crate) fn obj(data: &[u8]) {
    let split = data.windows(BETWEEN_FILES.len()).position(|window| window == BETWEEN_FILES);
    let (obj, mtl) = match split {
        Some(at) => (data.get(..at).unwrap_or_default(), data.get(at + BETWEEN_FILES.len()..).unwrap_or_default()),
        None => (data, &[][..]),
    };
    // One that names itself as its texture, and is a GIF of 8192×8192: textures have a target of their own.
    if [obj, mtl].iter().any(|file| image::guess_format(file).is_ok()) {
        return;
    }
    load(&[("a.obj", obj), ("a.mtl", mtl)], "a.obj");
}

/// A PLY file.
pub(crate) fn ply(data: &[u8]) {
    load(&[("a.ply", data)], "a.ply");
}

/// A glTF file, of text or a GLB. Its images are another target's.
pub(crate) fn gltf(data: &[u8]) {
    if data.windows(IMAGES.len()).any(|window| window == IMAGES) {
        return;
    }
    load(&[("a.glb", data)], "a.glb");
}

/// Whether an image of this width and height has so many pixels that most of the time goes into memory for them: a
/// few bytes can claim that. Only smaller ones, and those of more than any reader allows, are tried.
pub(crate) fn is_large((width, height): (u32, u32)) -> bool {
    const MANY_PX: u64 = 1 << 16;
    const MOST_PX: u64 = 1 << 26;
    (MANY_PX..=MOST_PX).contains(&(u64::from(width) * u64::from(height)))
}

/// Whether an image file [is large](is_large). Its format is that of its contents, else the given one.
pub(crate) fn is_large_image(bytes: &[u8], otherwise: Option<ImageFormat>) -> bool {
    let Some(format) = image::guess_format(bytes).ok().or(otherwise) else { return false };
    // Some decoders panic on damaged headers, too.
    catch_unwind(|| ImageReader::with_format(Cursor::new(bytes), format).into_dimensions())
        .is_ok_and(|size| size.is_ok_and(is_large))
}

/// A texture; the first byte chooses its file's extension.
pub(crate) fn texture(data: &[u8]) {
    let (choice, bytes) = first_byte(data);
    let extensions = ["png", "jpg", "bmp", "tga", "tif", "gif"];
    let extension = extensions[usize::from(choice) % extensions.len()];
    if is_large_image(bytes, ImageFormat::from_extension(extension)) {
        return;
    }
    let name = format!("t.{extension}");
    let mtl = format!("newmtl m\nmap_Kd {name}\n");
    let files = [("a.obj", TEXTURED), ("a.mtl", mtl.as_bytes()), (&*name, bytes)];
    load(&files, "a.obj");
}
