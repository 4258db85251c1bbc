//! What the fuzz targets do with foreign bytes: everything that comes from other processes or from files goes in here
//! as it would there, and what comes out is checked.
//!
//! Whatever the bytes are, a target ends without a panic, in little time and with little memory; what was understood is
//! valid, and reads as the same when it is written again, where there is a writer. `scripts/fuzz` runs the targets on
//! bytes that libFuzzer invents, guided by coverage; the tests of this crate replay what it has found so far: the
//! seeds (at most ten for each target) and the regressions (inputs that once failed), both in `fuzz`.

#![forbid(unsafe_code)]

mod bags;
mod cameras;
mod captures;
mod displays;
mod messages;
mod resources;
mod robots;
mod stream;
mod texts;
mod wire;

pub use displays::display_topics;
pub use stream::Record;

use std::alloc::System;
use std::panic::PanicHookInfo;

use stats_alloc::{Region, StatsAlloc, INSTRUMENTED_SYSTEM};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

const MIB: usize = 1 << 20;

/// Something that reads foreign bytes.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// The name of its binary and of its folders.
    pub name: &'static str,
    /// What it reads.
    pub reads: &'static str,
    /// The most bytes that it may allocate for one input, those that it gave back included.
    pub most_bytes: usize,
    function: fn(&[u8]),
}

impl Target {
    /// Reads the bytes.
    ///
    /// # Panics
    /// When something is wrong with what reads them.
    pub fn run(&self, data: &[u8]) {
        let region = Region::new(ALLOCATOR);
        (self.function)(data);
        let bytes = region.change().bytes_allocated;
        let most = self.most_bytes;
        assert!(bytes <= most, "{}: {bytes} bytes allocated for {}, at most {most} are allowed", self.name, data.len());
    }
}

/// Makes a constant of each target, and the list of all.
macro_rules! targets {
    ($($constant:ident: $name:literal, $reads:literal, $most_mib:literal MiB, $function:expr;)*) => {
        $(
            #[doc = concat!("Reads ", $reads, ".")]
            ///
            /// A constant of its own: a binary that names it has nothing of what others run. libFuzzer looks at the
            /// whole binary's counters after each input, which takes longer than reading most inputs.
            pub const $constant: Target =
                Target { name: $name, reads: $reads, most_bytes: $most_mib * MIB, function: $function };
        )*

        /// All targets; each has a file in `fuzz/fuzz_targets` and a folder in `fuzz/seeds`.
        pub const TARGETS: &[Target] = &[$($constant),*];
    };
}

// `display_depth` may allocate as much as `compressed_image`, because it takes the same images.
targets! {
    MESSAGES: "messages", "messages of every type, and requests of services", 32 MiB, messages::read;
    DISPLAY_CLOUDS: "display_clouds", "clouds and scans, in all styles", 256 MiB, |data| displays::show("clouds", data);
    DISPLAY_MARKERS: "display_markers", "Marker and MarkerArray", 256 MiB, |data| displays::show("markers", data);
    DISPLAY_INTERACTIVE: "display_interactive", "InteractiveMarkerInit and InteractiveMarkerUpdate", 256 MiB,
        |data| displays::show("interactive", data);
    DISPLAY_MAPS: "display_maps", "OccupancyGrid with updates, GridCells", 256 MiB, |data| displays::show("maps", data);
    DISPLAY_POSES: "display_poses", "poses, paths, covariances, screws, ranges and the like", 256 MiB,
        |data| displays::show("poses", data);
    DISPLAY_DEPTH: "display_depth", "Image and CompressedImage with CameraInfo", 1024 MiB,
        |data| displays::show("depth", data);
    DISPLAY_FRAMES: "display_frames", "TFMessage, and a camera's CameraInfo", 256 MiB,
        |data| displays::show("frames", data);
    COMPRESSED_IMAGE: "compressed_image", "JPEG, PNG and RVL of image_transport", 1024 MiB, displays::compressed_image;
    URDF: "urdf", "robot descriptions", 64 MiB, robots::urdf;
    PACKAGE_XML: "package_xml", "package.xml", 32 MiB, resources::package_xml;
    STL: "stl", "STL", 64 MiB, resources::stl;
    COLLADA: "collada", "COLLADA", 64 MiB, resources::collada;
    OBJ: "obj", "OBJ and its MTL", 64 MiB, resources::obj;
    PLY: "ply", "PLY", 64 MiB, resources::ply;
    GLTF: "gltf", "glTF, text and GLB", 256 MiB, resources::gltf;
    TEXTURE: "texture", "textures: PNG, JPEG, BMP, TGA, TIFF, GIF", 2048 MiB, resources::texture;
    TEXT: "text", "text in any encoding, and the XML in it", 64 MiB, texts::text;
    RVIZ_CONFIG: "rviz_config", ".rviz", 64 MiB, texts::rviz_config;
    NEW_CAMERA: "new_camera", ".rviz that a camera is added to", 64 MiB, cameras::new_camera;
    PROJECTOR: "projector", "projector files, and those of other calibrators", 32 MiB, texts::projector;
    CORRESPONDENCES: "correspondences", "lists of correspondences", 32 MiB, texts::correspondences;
    PATTERN_LIST: "pattern_list", "lists of patterns", 32 MiB, texts::pattern_list;
    CAPTURE: "capture", "capture.yaml", 32 MiB, captures::capture;
    PCD: "pcd", "PCD", 64 MiB, texts::pcd;
    BAG: "bag", "bags and MCAP files", 256 MiB, bags::bag;
    TCPROS_HEADER: "tcpros_header", "connection headers of TCPROS", 32 MiB, wire::tcpros_header;
    HTTP: "http", "HTTP messages of XML-RPC", 32 MiB, wire::http;
    XMLRPC: "xmlrpc", "XML-RPC calls and answers", 64 MiB, wire::xmlrpc;
}

/// Whether a panic is one of the decoders of images, some of which panic on damaged ones. The node expects these.
pub fn is_of_decoder(panic: &PanicHookInfo<'_>) -> bool {
    const DECODERS: [&str; 9] =
        ["image", "image-webp", "zune-jpeg", "png", "tiff", "gif", "weezl", "fdeflate", "miniz_oxide"];
    // …/registry/src/INDEX/NAME-VERSION/src/…
    let file = panic.location().map(|location| location.file()).unwrap_or_default();
    let package = file.split_once("/registry/src/").and_then(|(_, path)| path.split('/').nth(1));
    package.and_then(|package| package.rsplit_once('-')).is_some_and(|(name, _)| DECODERS.contains(&name))
}

/// Lets the panics of decoders be caught as in the node: libFuzzer's hook ends the process at every panic. To be called
/// once that hook is set.
pub fn catch_decoder_panics() {
    let end = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !is_of_decoder(panic) {
            end(panic);
        }
    }));
}

/// Splits off the first byte; 0 where there is none.
fn first_byte(data: &[u8]) -> (u8, &[u8]) {
    data.split_first().map_or((0, data), |(first, rest)| (*first, rest))
}
