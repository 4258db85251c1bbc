//! Writes the inputs that fuzzing starts from into a folder with one folder for each target:
//!
//! ```text
//! cargo run --release -p rcs_fuzz_harness --example seeds -- FOLDER
//! ```
//!
//! They are taken from the conformance cases, the configs and the folder `seeds`, or are made here. `scripts/fuzz
//! --seeds` begins with them.
#![forbid(unsafe_code)]
#![expect(clippy::unwrap_used, reason = "a program for developers, whose inputs are the repository's own")]

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageFormat};
use rcs_bag::Bag;
use rcs_fuzz_harness::{display_topics, Record};
use rcs_messages::sensor_msgs::{CameraInfo, CompressedImage};
use rcs_messages::{std_msgs, Image, Message, MessageKind, RosMsg, Time};
use rcs_test_support::{BagWriter, McapWriter};

/// Longer inputs slow fuzzing down more than they help.
const MOST_BYTES: usize = 4096;

/// Files of the repository: the target that reads them, the folders, the end of their names.
const FILES: [(&str, &[&str], &str); 8] = [
    ("urdf", &["tests/conformance/assets", "tests/conformance/robots"], ".urdf"),
    ("package_xml", &["tests/conformance/assets", "ros_pkg"], "package.xml"),
    ("stl", &["tests/conformance/assets"], ".stl"),
    ("collada", &["tests/conformance/assets"], ".dae"),
    ("obj", &["tests/conformance/assets"], ".obj"),
    ("projector", &["config"], ".yaml"),
    ("pcd", &["config"], ".pcd"),
    ("rviz_config", &["config", "rviz", "tests/conformance/cases"], ".rviz"),
];

struct Seeds {
    folder: PathBuf,
    count: usize,
}

impl Seeds {
    fn add(&mut self, target: &str, bytes: &[u8]) {
        if bytes.len() <= MOST_BYTES {
            let folder = self.folder.join(target);
            fs::create_dir_all(&folder).unwrap();
            fs::write(folder.join(format!("seed_{}", self.count)), bytes).unwrap();
            self.count += 1;
        }
    }

    fn add_chosen(&mut self, target: &str, choice: usize, bytes: &[u8]) {
        self.add(target, &[&[choice as u8], bytes].concat());
    }

    fn add_files(&mut self, target: &str, folder: &Path, extension: &str) {
        for path in files(folder) {
            if path.to_string_lossy().ends_with(extension) {
                self.add(target, &fs::read(&path).unwrap());
            }
        }
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    entries.into_iter().flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

fn main() {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("seeds"), PathBuf::from);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut seeds = Seeds { folder, count: 0 };
    messages(&mut seeds, &root);
    for (target, folders, extension) in FILES {
        for folder in folders {
            seeds.add_files(target, &root.join(folder), extension);
        }
    }
    // What those lack.
    for path in files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds")) {
        let target = path.parent().unwrap().file_name().unwrap().to_string_lossy().into_owned();
        seeds.add(&target, &fs::read(&path).unwrap());
    }
    meshes(&mut seeds);
    images(&mut seeds);
    depth(&mut seeds);
    clouds(&mut seeds);
    bags(&mut seeds);
    connections(&mut seeds);
    println!("{} inputs in {}", seeds.count, seeds.folder.display());
}

/// What the bags of the conformance cases hold.
fn messages(seeds: &mut Seeds, root: &Path) {
    for path in files(&root.join("tests/conformance/cases")).iter().filter(|path| path.ends_with("scene.bag")) {
        let Ok(bag) = Bag::open(path) else { continue };
        let all: Vec<_> = (bag.messages(|_| true).filter_map(Result::ok))
            .filter_map(|message| {
                let kind = MessageKind::from_ros_type(&message.connection.ros_type)?;
                Some((kind, message.connection.latching, message.connection.topic.clone(), message.bytes))
            })
            .collect();
        for (kind, _, _, bytes) in &all {
            let index = MessageKind::ALL.iter().position(|known| known == kind).unwrap();
            seeds.add_chosen("messages", index, bytes);
        }
        for target in ["clouds", "markers", "interactive", "maps", "poses", "frames"] {
            for (index, topics) in display_topics(target).iter().enumerate() {
                let mut input = vec![index as u8, 0];
                let mut is_used = false;
                for (kind, latching, _, bytes) in &all {
                    let topic = match (topics.iter().position(|(_, topic)| topic == kind), kind) {
                        (Some(topic), _) => topic,
                        (None, MessageKind::TFMessage) => topics.len() + usize::from(!latching),
                        _ => continue,
                    };
                    is_used |= *kind != MessageKind::CameraInfo && (topic < topics.len() || target == "frames");
                    Record { topic: topic as u8, bytes }.write(&mut input);
                }
                if is_used {
                    seeds.add(&format!("display_{target}"), &input);
                }
            }
        }
    }
    let empty = |count: u32| [count.to_le_bytes().to_vec(), vec![0; 16]].concat();
    for choice in 0..4 {
        seeds.add_chosen("messages", MessageKind::ALL.len() + choice, &empty(0));
    }
    let names = [3_u32.to_le_bytes().as_slice(), b"ros", &4_u32.to_le_bytes(), b"info"].concat();
    seeds.add_chosen("messages", MessageKind::ALL.len() + 1, &names);
}

/// Depth images of 4 × 4 pixels with what belongs to them.
fn depth(seeds: &mut Seeds) {
    let header = || std_msgs::Header { frame_id: "base_link".to_owned(), ..Default::default() };
    let info = CameraInfo {
        header: header(),
        width: 4,
        height: 4,
        K: [4.0, 0.0, 2.0, 0.0, 4.0, 2.0, 0.0, 0.0, 1.0],
        P: [4.0, 0.0, 2.0, 0.0, 0.0, 4.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        ..CameraInfo::default()
    };
    let image = |encoding: &str, pixel: &[u8]| {
        let step = 4 * pixel.len() as u32;
        rcs_messages::encode(&Image::new(header(), [4, 4], encoding, step, pixel.repeat(16).into()))
    };
    let packed = |format: &str, data: &[u8]| {
        rcs_messages::encode(&CompressedImage { header: header(), format: format.to_owned(), data: data.to_vec() })
    };
    let metres = 1.5_f32.to_le_bytes();
    let pairs = [
        (image("32FC1", &metres), image("rgb8", &[200, 100, 50])),
        (image("16UC1", &[0xdc, 5]), image("bgra8", &[200, 100, 50, 255])),
        (image("mono16", &[0xdc, 5]), image("mono8", &[90])),
        (image("32FC1", &metres), image("bayer_rggb8", &[90])),
        (image("32FC1", &metres), image("rgb16", &[90; 6])),
    ];
    let jpeg = encoded_image(&sample_images()[1], ImageFormat::Jpeg);
    let depth_png = [&[0; 12][..], &encoded_image(&sample_images()[5], ImageFormat::Png)].concat();
    let packed_pairs = [
        (packed("16UC1; compressedDepth rvl", &rvl()), packed("rgb8; jpeg compressed bgr8", &jpeg)),
        (packed("16UC1; compressedDepth png", &depth_png), packed("rgb8; jpeg compressed bgr8", &jpeg)),
    ];
    for (index, topics) in display_topics("depth").iter().enumerate() {
        let is_packed = topics.iter().any(|(_, kind)| *kind == MessageKind::CompressedImage);
        for (depth, colour) in if is_packed { &packed_pairs[..] } else { &pairs[..] } {
            let mut input = vec![index as u8, 0];
            for (number, (topic, kind)) in topics.iter().enumerate() {
                let bytes = match kind {
                    MessageKind::CameraInfo => &rcs_messages::encode(&info),
                    _ if topic.starts_with("/d") => depth,
                    _ => colour,
                };
                Record { topic: number as u8, bytes }.write(&mut input);
            }
            seeds.add("display_depth", &input);
        }
    }
}

/// A binary STL of one triangle.
fn meshes(seeds: &mut Seeds) {
    let mut binary = vec![0; 80];
    binary.extend_from_slice(&1_u32.to_le_bytes());
    for number in [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        binary.extend_from_slice(&number.to_le_bytes());
    }
    binary.extend_from_slice(&[0; 2]);
    seeds.add("stl", &binary);
}

/// Images of 4 × 4 pixels, with all kinds of them.
fn sample_images() -> [DynamicImage; 6] {
    let pixel = |x: u32, y: u32| [(x * 60) as u8, (y * 50) as u8, 200, 128];
    let rgba = DynamicImage::ImageRgba8(image::ImageBuffer::from_fn(4, 4, |x, y| image::Rgba(pixel(x, y))));
    let grey = DynamicImage::ImageLuma16(image::ImageBuffer::from_fn(4, 4, |x, y| image::Luma([(x * y * 500) as u16])));
    [
        rgba.clone(),
        rgba.to_rgb8().into(),
        rgba.to_luma8().into(),
        rgba.to_luma_alpha8().into(),
        rgba.to_rgb16().into(),
        grey,
    ]
}

/// The file of an image; empty where the format has no such pixels.
fn encoded_image(encoded_image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    encoded_image.write_to(&mut bytes, format).map_or_else(|_| Vec::new(), |()| bytes.into_inner())
}

/// A depth image of 4 × 4 pixels.
fn rvl() -> Vec<u8> {
    [vec![0; 12], vec![4, 0, 0, 0, 4, 0, 0, 0], vec![0x11, 0x22, 0x93, 0x17, 0x80, 0x44, 0x21, 0x19]].concat()
}

/// Textures and compressed images in all formats.
fn images(seeds: &mut Seeds) {
    let formats =
        [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Bmp, ImageFormat::Tga, ImageFormat::Tiff, ImageFormat::Gif];
    for pixels in &sample_images() {
        for (choice, format) in formats.into_iter().enumerate() {
            let bytes = encoded_image(pixels, format);
            if bytes.is_empty() {
                continue;
            }
            seeds.add_chosen("texture", choice, &bytes);
            let with_header = [&[0; 12][..], &bytes].concat();
            match format {
                ImageFormat::Png => {
                    (0..2).for_each(|choice| seeds.add_chosen("compressed_image", choice, &with_header));
                    (5..8).for_each(|choice| seeds.add_chosen("compressed_image", choice, &bytes));
                }
                ImageFormat::Jpeg => {
                    [4, 7].into_iter().for_each(|choice| seeds.add_chosen("compressed_image", choice, &bytes));
                }
                _ => {}
            }
        }
    }
    (2..4).for_each(|choice| seeds.add_chosen("compressed_image", choice, &rvl()));
}

/// Points that are no text.
fn clouds(seeds: &mut Seeds) {
    let header =
        "VERSION 0.7\nFIELDS x y z rgb _ label\nSIZE 4 4 4 4 1 8\nTYPE F F F U U I\nCOUNT 1 1 1 1 3 2\nWIDTH 2\n\
                  HEIGHT 1\nPOINTS 2\nDATA ";
    seeds.add("pcd", &[format!("{header}binary\n").as_bytes(), &[7; 70]].concat());
    let mut packed = format!("{header}binary_compressed\n").into_bytes();
    // Seventy bytes in LZF: one as it is, 68 copies of it, one more.
    let body = [0, 7, 0xe0, 59, 0, 0, 7];
    packed.extend_from_slice(&(body.len() as u32).to_le_bytes());
    packed.extend_from_slice(&70_u32.to_le_bytes());
    packed.extend_from_slice(&body);
    seeds.add("pcd", &packed);
}

/// Small bags, with little padding behind their headers.
fn bags(seeds: &mut Seeds) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bag");
    let mut writer = BagWriter::create(&path).unwrap();
    let text = |data: &str| std_msgs::String { data: data.to_owned() };
    for sec in [3, 1, 2] {
        writer.write("/a", false, Time { sec, nsec: 0 }, &text("hello")).unwrap();
    }
    writer.write("/b", true, Time { sec: 2, nsec: 5 }, &rcs_messages::rosgraph_msgs::Clock::default()).unwrap();
    writer.finish().unwrap();
    seeds.add("bag", &fs::read(&path).unwrap());
    let mut writer = McapWriter::create(&path, 40).unwrap();
    for sec in [3, 1, 2] {
        let message = rcs_messages::encode(&text("hello"));
        writer.write("/a", "std_msgs/String", "ros1", Time { sec, nsec: 0 }, &message).unwrap();
    }
    writer.finish().unwrap();
    seeds.add("bag", &fs::read(&path).unwrap());
}

/// Headers, HTTP and XML-RPC as nodes send them.
fn connections(seeds: &mut Seeds) {
    let field = |text: String| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let fields = |texts: &[String]| {
        let all: Vec<u8> = texts.iter().flat_map(|text| field(text.clone())).collect();
        [&(all.len() as u32).to_le_bytes(), all.as_slice()].concat()
    };
    let kind = format!("type={}", std_msgs::String::msg_type());
    let sum = format!("md5sum={}", std_msgs::String::md5sum());
    let subscriber = [
        "callerid=/viewer".to_owned(),
        "topic=/chatter".to_owned(),
        sum.clone(),
        kind.clone(),
        "tcp_nodelay=1".to_owned(),
    ];
    seeds.add("tcpros_header", &fields(&subscriber));
    let service =
        ["service=/set".to_owned(), "persistent=1".to_owned(), "md5sum=*".to_owned(), "error=no = reason".to_owned()];
    seeds.add("tcpros_header", &fields(&service));
    seeds.add(
        "tcpros_header",
        &fields(&[kind, sum, "message_definition=string data\n".to_owned(), "latching=1".to_owned()]),
    );
    for (choice, http) in [
        (0, "POST /RPC2 HTTP/1.1\r\nHost: a:1\r\nContent-Type: text/xml\r\nContent-Length: 5\r\n\r\nhello"),
        (20, "POST / HTTP/1.0\r\nExpect: 100-continue\r\ncontent-length: 3\r\n\r\nabc"),
        (6, "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n1;x=y\r\n!\r\n0\r\n\r\n"),
        (1, "HTTP/1.1 200 OK\r\nServer: x\r\nContent-Length: 2\r\n\r\nok"),
        (9, "HTTP/1.0 200 OK\r\n\r\nuntil the end"),
        (1, "HTTP/1.1 404 Not Found\r\n\r\n"),
        (31, "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\na\r\n0123456789\r\n0\r\n\r\n"),
    ] {
        seeds.add_chosen("http", choice, http.as_bytes());
    }
    let level = rcs_messages::roscpp::SetLoggerLevelReq { logger: "ros".to_owned(), level: "warn".to_owned() };
    let mut bytes = Vec::new();
    level.encode(&mut bytes).unwrap();
    seeds.add_chosen("messages", MessageKind::ALL.len() + 1, &bytes);
}
