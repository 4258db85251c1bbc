//! Captures of `projector_calibrate`: an input is a `capture.yaml`, in a folder with a few files that it may name.

use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::sync::OnceLock;

use image::{DynamicImage, GrayImage, ImageFormat, RgbaImage};
use rcs_files::capture::{parse_patterns, Capture, CAPTURE_FILE};
use rcs_files::projector::ProjectorFile;
use tempfile::TempDir;

/// Width and height of the camera, pixels.
const SIZE_PX: [u32; 2] = [4, 3];

/// Those of a folder that stay when a capture is replaced: a writer of captures never gives such names.
const FOREIGN: [&str; 6] = ["colours.png", "c7.png", "c7.d/grey", "other_size.png", "depth_of_field.png", "wide.yaml"];

/// Names and contents.
type Files = Vec<(&'static str, Vec<u8>)>;

/// A capture: what was read is of one size, and is read as the same when it is written, also over itself.
pub(crate) fn capture(data: &[u8]) {
    thread_local! {
        static FOLDER: TempDir = filled_folder();
    }
    let read = FOLDER.with(|folder| {
        write(&folder.path().join(CAPTURE_FILE), data);
        let read = Capture::read(folder.path());
        (read, folder.path().display().to_string())
    });
    let capture = match read {
        (Ok(capture), _) => capture,
        (Err(error), folder) => {
            let error = error.to_string();
            assert!(error.starts_with(&folder) && error.lines().count() == 1, "{error:?}");
            return;
        }
    };
    // It begins as a list of patterns does.
    let list = std::str::from_utf8(data).ok().and_then(|text| parse_patterns(Path::new(CAPTURE_FILE), text).ok());
    let list = list.unwrap_or_else(|| panic!("a capture, but no list of patterns"));
    assert_eq!(list.projector_size_px, capture.projector_size_px);
    assert!(list.patterns.iter().map(|(_, pattern)| pattern).eq(capture.images.iter().map(|shown| &shown.pattern)));

    assert_eq!(capture.image_size_px(), SIZE_PX);
    let pixels = (SIZE_PX[0] * SIZE_PX[1]) as usize;
    assert!(capture.images.iter().all(|image| image.grey.len() == pixels));
    assert!(capture.depth_m.iter().all(|depth_m| depth_m.len() == pixels));
    assert!(capture.warnings.iter().all(|warning| warning.lines().count() == 1), "{:?}", capture.warnings);
    check_written(data, &capture);
}

/// Writes it over the capture that it came from, and over the one that this makes.
fn check_written(data: &[u8], capture: &Capture) {
    let folder = filled_folder();
    write(&folder.path().join(CAPTURE_FILE), data);
    let written = written(capture, folder.path());
    // Depths are rounded, once.
    assert_eq!(Capture { depth_m: written.depth_m.clone(), warnings: Vec::new(), ..capture.clone() }, written);
    assert_eq!(capture.depth_m.is_some(), written.depth_m.is_some());
    let count = || fs::read_dir(folder.path()).map_or(0, Iterator::count);
    let before = count();
    assert_eq!(self::written(&written, folder.path()), written);
    assert!(count() <= before, "files are left over");
    for (name, bytes) in files().iter().filter(|(name, _)| FOREIGN.contains(name)) {
        assert_eq!(fs::read(folder.path().join(name)).ok().as_ref(), Some(bytes), "{name} is not what it was");
    }
}

fn written(capture: &Capture, folder: &Path) -> Capture {
    capture.write(folder).unwrap_or_else(|error| panic!("{error}"));
    Capture::read(folder).unwrap_or_else(|error| panic!("{error} in what was written"))
}

fn write(path: &Path, bytes: &[u8]) {
    fs::write(path, bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

fn filled_folder() -> TempDir {
    // In memory where there is such a folder: a disk takes ten times as long.
    let folder = tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir());
    let folder = folder.unwrap_or_else(|error| panic!("no temporary folder: {error}"));
    for (name, bytes) in files() {
        let path = folder.path().join(name);
        if name.contains('/') {
            let inner = path.parent().unwrap_or(&path);
            fs::create_dir_all(inner).unwrap_or_else(|error| panic!("{}: {error}", inner.display()));
        }
        write(&path, bytes);
    }
    folder
}

/// The files of the folder.
fn files() -> &'static Files {
    static FILES: OnceLock<Files> = OnceLock::new();
    FILES.get_or_init(|| {
        let [width, height] = SIZE_PX;
        let grey = |width, height| {
            DynamicImage::from(GrayImage::from_fn(width, height, |x, y| image::Luma([(x * 60 + y * 20) as u8])))
        };
        let colours = RgbaImage::from_fn(width, height, |x, y| image::Rgba([(x * 60) as u8, (y * 90) as u8, 200, 128]));
        let depth = image::ImageBuffer::from_fn(width, height, |x, y| image::Luma([(x * y * 10_000) as u16]));
        let camera_info = |name: &'static str, [width, height]: [u32; 2]| {
            let text =
                format!("width: {width}\nheight: {height}\nK: [500.0, 0.0, 2.0, 0.0, 500.0, 1.5, 0.0, 0.0, 1.0]\n");
            let file = ProjectorFile::parse(Path::new(name), &text);
            file.unwrap_or_else(|error| panic!("{error}"));
            (name, text.into_bytes())
        };
        vec![
            ("c000.png", png(&grey(width, height))),
            ("c001.png", png(&grey(width, height).into_luma_alpha8().into())),
            ("c002_2.png", png(&grey(width, height))),
            ("colours.png", png(&colours.into())),
            ("c7.png", png(&grey(width, height))),
            ("c7.d/grey", png(&grey(width, height))),
            ("other_size.png", png(&grey(width + 1, height))),
            ("depth_of_field.png", png(&depth.clone().into())),
            ("depth.png", png(&depth.into())),
            ("robot.urdf", b"<robot name='r'/>".to_vec()),
            camera_info("camera_info.yaml", SIZE_PX),
            camera_info("wide.yaml", [16_384, 16_384]),
        ]
    })
}

fn png(image: &DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap_or_else(|error| panic!("{error}"));
    bytes.into_inner()
}
