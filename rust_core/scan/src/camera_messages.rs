//! Conversion of the camera's messages: its lens, the grey levels of an image, the depths of a depth image or of an
//! organised cloud. Images may be compressed.

use std::borrow::Cow;

use rcs_calibration::Lens;
use rcs_displays::unpack_image;
use rcs_files::projector::ProjectorFile;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::{AnyMessage, Image as ImageMessage, PointCloud2};

use crate::devices::DepthFrame;

/// The lens of a camera with images on this topic.
///
/// # Errors
/// The fault of the CameraInfo.
pub fn lens_of_topic(info: &CameraInfo, image_topic: &str) -> Result<Lens, String> {
    lens_of(info, is_rectified(image_topic))
}

/// `true` for a topic of rectified images, by the names of image_proc and image_transport.
fn is_rectified(topic: &str) -> bool {
    let name = topic.strip_suffix("/compressed").unwrap_or(topic).rsplit('/').next();
    name.is_some_and(|name| name.starts_with("image_rect"))
}

/// The lens of a CameraInfo: K and D for raw images, the left part of P for rectified ones.
fn lens_of(info: &CameraInfo, is_rectified: bool) -> Result<Lens, String> {
    let mut camera_info = info.clone();
    if is_rectified {
        let [fx, skew, cx, _, below, fy, cy, _, row @ ..] = info.P;
        camera_info.K = [fx, skew, cx, below, fy, cy, row[0], row[1], row[2]];
        camera_info.D.clear();
        camera_info.distortion_model.clear();
    }
    if camera_info.width == 0 || camera_info.height == 0 {
        return Err(format!("the camera's size is {}x{} pixels", camera_info.width, camera_info.height));
    }
    let file = ProjectorFile { camera_info, camera_info_topic: None, frames: Vec::new(), ignored_keys: Vec::new() };
    file.camera_lens().map_err(|problem| problem.to_string())
}

/// Size in pixels and grey levels of an image, compressed or not.
///
/// # Errors
/// The reason, for a message that names the topic.
pub fn grey_image(topic: &str, message: &AnyMessage) -> Result<([u32; 2], Vec<u8>), String> {
    let image = image_of(topic, message)?;
    Ok(([image.width, image.height], grey_levels(&image)?))
}

/// A depth image of an image, compressed or not, or of an organised cloud.
///
/// # Errors
/// The reason, for a message that names the topic.
pub fn depth_of(topic: &str, message: &AnyMessage) -> Result<DepthFrame, String> {
    if let AnyMessage::PointCloud2(cloud) = message {
        return Ok(DepthFrame { size_px: [cloud.width, cloud.height], depth_m: cloud_depths_m(cloud)? });
    }
    let image = image_of(topic, message)?;
    Ok(DepthFrame { size_px: [image.width, image.height], depth_m: depths_m(&image)? })
}

fn image_of<'a>(topic: &str, message: &'a AnyMessage) -> Result<Cow<'a, ImageMessage>, String> {
    match message {
        AnyMessage::Image(image) => Ok(Cow::Borrowed(image)),
        AnyMessage::CompressedImage(packed) => unpack_image(topic, packed).map(Cow::Owned),
        other => Err(format!("{} is not an image", other.kind().ros_type())),
    }
}

/// Grey levels of an image, row by row: the luma of ITU-R BT.601, as in cv_bridge. Bayer patterns are demosaiced.
fn grey_levels(image: &ImageMessage) -> Result<Vec<u8>, String> {
    if let Some(colors) = image.demosaic() {
        return Ok(colors?.as_chunks().0.iter().map(|color| luma(*color)).collect());
    }
    // Indices of red, green and blue in a pixel, and its bytes.
    let (channels, bytes) = match image.encoding.as_str() {
        "mono8" | "8UC1" => ([0, 0, 0], 1),
        "rgb8" => ([0, 1, 2], 3),
        "bgr8" | "8UC3" => ([2, 1, 0], 3),
        "rgba8" => ([0, 1, 2], 4),
        "bgra8" | "8UC4" => ([2, 1, 0], 4),
        other => {
            return Err(format!("unsupported encoding '{other}': use mono8, rgb8, bgr8, rgba8, bgra8 or bayer_*"));
        }
    };
    let mut grey = Vec::new();
    for row in image.rows(bytes)? {
        grey.extend(row.chunks_exact(bytes).map(|pixel| luma(channels.map(|channel| pixel[channel]))));
    }
    Ok(grey)
}

fn luma([red, green, blue]: [u8; 3]) -> u8 {
    ((299 * u32::from(red) + 587 * u32::from(green) + 114 * u32::from(blue) + 500) / 1000) as u8
}

/// Depths of a depth image, metres, row by row; none where not a positive number.
fn depths_m(image: &ImageMessage) -> Result<Vec<f32>, String> {
    let mut depths = Vec::new();
    match image.encoding.as_str() {
        "16UC1" | "mono16" => {
            for row in image.rows(2)? {
                depths.extend(row.as_chunks().0.iter().map(|bytes| f32::from(image.u16_of(*bytes)) / 1000.0));
            }
        }
        "32FC1" => {
            for row in image.rows(4)? {
                depths.extend(row.as_chunks().0.iter().map(|bytes| image.f32_of(*bytes)));
            }
        }
        other => {
            return Err(format!("unsupported depth encoding '{other}': use 16UC1 in millimetres or 32FC1 in metres"));
        }
    }
    Ok(depths)
}

/// Depths of an organised cloud in the camera's optical frame: the z of each point.
fn cloud_depths_m(cloud: &PointCloud2) -> Result<Vec<f32>, String> {
    if cloud.height < 2 {
        return Err(format!("the cloud is not organised: it has {} row", cloud.height));
    }
    let depths = cloud.numbers(["z"]).map_err(|error| error.to_string())?;
    Ok(depths.map(|[z]| z as f32).collect())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rcs_files::image_file;
    use rcs_messages::sensor_msgs::{CompressedImage, PointField};
    use rcs_messages::std_msgs::Header;
    use rcs_scene::{Encoding, Image};

    use super::*;

    #[test]
    fn rectified_images_have_another_lens() {
        let info = CameraInfo {
            width: 640,
            height: 480,
            distortion_model: "plumb_bob".to_owned(),
            D: vec![0.1, 0.0, 0.0, 0.0, 0.0],
            K: [500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0],
            P: [510.0, 0.0, 321.0, 0.0, 0.0, 511.0, 241.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            ..CameraInfo::default()
        };
        let (raw, rectified) = (lens_of(&info, false).unwrap(), lens_of(&info, true).unwrap());
        assert_eq!((raw.focal_px.x, raw.distortion.coefficients()[0]), (500.0, 0.1));
        assert_eq!(rectified, Lens::pinhole([640, 480], [510.0, 511.0], [321.0, 241.0]));
        assert!(is_rectified("/camera/rgb/image_rect_color") && !is_rectified("/camera/rgb/image_raw"));
        assert!(is_rectified("/camera/rgb/image_rect/compressed") && !is_rectified("/rgb/image_raw/compressed"));
    }

    #[test]
    fn an_uncalibrated_camera_is_an_error() {
        let info = CameraInfo { width: 640, height: 480, ..CameraInfo::default() };
        assert!(lens_of(&info, false).unwrap_err().contains("K"));
        assert!(lens_of(&CameraInfo::default(), false).unwrap_err().contains("0x0"));
    }

    fn image(encoding: &str, size_px: [u32; 2], step: u32, data: &[u8]) -> ImageMessage {
        ImageMessage::new(Header::default(), size_px, encoding, step, Arc::new(data.to_vec()))
    }

    #[test]
    fn grey_is_luma_in_any_order_of_channels() {
        let red = [("rgb8", vec![255, 0, 0]), ("bgr8", vec![0, 0, 255]), ("rgba8", vec![255, 0, 0, 9])];
        for (encoding, pixel) in red {
            let step = pixel.len() as u32;
            assert_eq!(grey_levels(&image(encoding, [1, 1], step, &pixel)), Ok(vec![76]), "{encoding}");
        }
        assert_eq!(grey_levels(&image("bgra8", [1, 1], 4, &[0, 255, 0, 0])), Ok(vec![150]));
        assert_eq!(grey_levels(&image("mono8", [2, 2], 3, &[1, 2, 0, 3, 4])), Ok(vec![1, 2, 3, 4]));
    }

    #[test]
    fn depth_is_metres() {
        let millimetres = [1500_u16, 0].map(u16::to_le_bytes).concat();
        assert_eq!(depths_m(&image("16UC1", [2, 1], 4, &millimetres)), Ok(vec![1.5, 0.0]));
        let metres = [1.25_f32, f32::NAN].map(f32::to_le_bytes).concat();
        let depths = depths_m(&image("32FC1", [1, 2], 4, &metres)).unwrap();
        assert!(depths[0] == 1.25 && depths[1].is_nan());
    }

    #[test]
    fn compressed_images_are_unpacked() {
        let folder = tempfile::tempdir().unwrap();
        let png = |encoding, data: &[u8]| {
            let path = folder.path().join("picture.png");
            let image = Image { width_px: 2, height_px: 1, encoding, data: data.to_vec() };
            image_file::write(&path, &image).unwrap();
            std::fs::read(path).unwrap()
        };
        let packed = |format: &str, data| {
            AnyMessage::CompressedImage(Arc::new(CompressedImage {
                format: format.to_owned(),
                data,
                ..Default::default()
            }))
        };
        let colours = packed("rgb8; png compressed bgr8", png(Encoding::Rgb8, &[255, 0, 0, 0, 255, 0]));
        assert_eq!(grey_image("/camera/image/compressed", &colours), Ok(([2, 1], vec![76, 150])));
        let mut data = vec![0; 12];
        data.extend(png(Encoding::Mono16, &[1500_u16, 0].map(u16::to_le_bytes).concat()));
        let depth = depth_of("/depth/compressedDepth", &packed("16UC1; compressedDepth png", data)).unwrap();
        assert_eq!((depth.size_px, depth.depth_m), ([2, 1], vec![1.5, 0.0]));
        let unknown = "an image of an unknown format: JPEG, PNG, BMP, TIFF and WebP are read".to_owned();
        assert_eq!(grey_image("/c", &packed("rgb8; jpeg", vec![1, 2])), Err(unknown));
        let cloud = AnyMessage::PointCloud2(Arc::default());
        assert!(grey_image("/c", &cloud).unwrap_err().contains("sensor_msgs/PointCloud2 is not an image"));
    }

    #[test]
    fn a_clouds_depth_is_its_z() {
        let cloud = |change: fn(&mut PointCloud2), len: usize| {
            let mut cloud = PointCloud2::default();
            (cloud.width, cloud.height, cloud.point_step, cloud.row_step) = (2, 2, 8, 16);
            cloud.fields =
                vec![PointField { name: "z".to_owned(), offset: 4, datatype: PointField::FLOAT32, count: 1 }];
            change(&mut cloud);
            let data: Vec<u8> = (0..8_u8).flat_map(|i| f32::from(i).to_le_bytes()).collect();
            cloud_depths_m(&cloud.with_data(data[..len].to_vec()))
        };
        assert_eq!(cloud(|_| (), 32), Ok(vec![1.0, 3.0, 5.0, 7.0]));
        assert_eq!(cloud(|cloud| cloud.row_step = 0, 32), Ok(vec![1.0, 3.0, 5.0, 7.0]));
        assert!(cloud(|cloud| (cloud.width, cloud.height) = (4, 1), 32).unwrap_err().contains("organised"));
        assert!(cloud(|cloud| cloud.fields.clear(), 32).unwrap_err().contains("no field z"));
        assert!(cloud(|_| (), 20).is_err());
        assert!(cloud(|cloud| (cloud.point_step, cloud.row_step) = (0, 0), 32).is_err());
    }

    #[test]
    fn invalid_images_are_errors() {
        for (encoding, size_px, step, len) in [
            ("mono8", [4, 4], 4, 15),
            ("rgb8", [4, 4], 11, 100),
            ("mono8", [0, 4], 4, 16),
            ("mono8", [4, 0], 4, 16),
            ("mono8", [u32::MAX, u32::MAX], u32::MAX, 16),
            ("bayer_rggb8", [4, 4], 4, 15),
            ("bayer_rggb16", [4, 4], 4, 16),
            ("bayer_rgbg8", [4, 4], 4, 16),
        ] {
            assert!(grey_levels(&image(encoding, size_px, step, &vec![0; len])).is_err(), "{encoding} {size_px:?}");
        }
        assert!(depths_m(&image("16UC1", [4, 4], 8, &[0; 31])).is_err());
        assert!(depths_m(&image("rgb8", [4, 4], 12, &[0; 48])).unwrap_err().contains("rgb8"));
    }
}
