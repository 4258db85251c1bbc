//! What the fuzz targets do with foreign bytes: everything that comes from other processes or from files goes in here
//! as it would there, and what comes out is checked.
//!
//! Whatever the bytes are, a target ends without a panic, in little time and with little memory; what was understood is
//! valid, and reads as the same when it is written again, where there is a writer. `scripts/fuzz` runs the targets on bytes
//! that libFuzzer invents, guided by coverage; the tests of this crate replay what it has found so far: the corpora
//! (inputs that each reach something new) and the regressions (inputs that once failed), both in `fuzz`.

#![forbid(unsafe_code)]

mod bags;
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

/// All targets; each has a file in `fuzz/fuzz_targets` and a folder in `fuzz/corpus`.
pub const TARGETS: &[Target] = &[
    target("messages", "messages of every type, and requests of services", 32, messages::read),
    target("display_clouds", "clouds and scans, in all styles", 256, |data| displays::show("clouds", data)),
    target("display_markers", "Marker and MarkerArray", 256, |data| displays::show("markers", data)),
    target("display_interactive", "InteractiveMarkerInit and InteractiveMarkerUpdate", 256, |data| {
        displays::show("interactive", data)
    }),
    target("display_maps", "OccupancyGrid with updates, GridCells", 256, |data| displays::show("maps", data)),
    target("display_poses", "poses, paths, covariances, screws, ranges and the like", 256, |data| {
        displays::show("poses", data)
    }),
    target("display_depth", "Image and CompressedImage with CameraInfo", 256, |data| displays::show("depth", data)),
    target("display_frames", "TFMessage, and a camera's CameraInfo", 256, |data| displays::show("frames", data)),
    target("compressed_image", "JPEG, PNG and RVL of image_transport", 1024, displays::compressed_image),
    target("urdf", "robot descriptions", 64, robots::urdf),
    target("package_xml", "package.xml", 32, resources::package_xml),
    target("stl", "STL", 64, resources::stl),
    target("collada", "COLLADA", 64, resources::collada),
    target("obj", "OBJ and its MTL", 64, resources::obj),
    target("texture", "textures: PNG, JPEG, BMP, TGA, TIFF, GIF", 2048, resources::texture),
    target("rviz_config", ".rviz", 64, texts::rviz_config),
    target("projector", "projector files", 32, texts::projector),
    target("pcd", "PCD", 64, texts::pcd),
    target("bag", "bags", 256, bags::bag),
    target("tcpros_header", "connection headers of TCPROS", 32, wire::tcpros_header),
    target("http", "HTTP messages of XML-RPC", 32, wire::http),
    target("xmlrpc", "XML-RPC calls and answers", 64, wire::xmlrpc),
];

const fn target(name: &'static str, reads: &'static str, most_mib: usize, function: fn(&[u8])) -> Target {
    Target { name, reads, most_bytes: most_mib * MIB, function }
}

/// Runs the target of a name.
///
/// # Panics
/// As [`Target::run`], or when there is no such target.
pub fn run(name: &str, data: &[u8]) {
    let target = TARGETS.iter().find(|target| target.name == name);
    let target = target.unwrap_or_else(|| panic!("there is no target {name}"));
    target.run(data);
}

/// Splits off the first byte; 0 where there is none.
fn first_byte(data: &[u8]) -> (u8, &[u8]) {
    data.split_first().map_or((0, data), |(first, rest)| (*first, rest))
}
