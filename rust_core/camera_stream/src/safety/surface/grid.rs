//! Points of a depth image or an organised cloud, in the depth camera's frame.

use std::sync::Arc;

use nalgebra::Point2;
use rcs_confirm::PointGrid;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::{AnyMessage, PointCloud2};
use rcs_scan::{depth_of, lens_of_topic};

/// Endings of the topics of image_transport's compressed images.
const TRANSPORTS: [&str; 2] = ["/compressedDepth", "/compressed"];

/// Converts the messages of one topic. Rays are computed again when the CameraInfo changes.
#[derive(Debug, Default)]
pub(super) struct GridDecoder {
    rays: Option<(Arc<CameraInfo>, Vec<[f32; 2]>)>,
}

/// Topic of an image without the ending of its transport.
pub(super) fn raw_topic(topic: &str) -> &str {
    TRANSPORTS.iter().find_map(|transport| topic.strip_suffix(transport)).unwrap_or(topic)
}

impl GridDecoder {
    /// The points of a message. `info` is the CameraInfo beside a depth image.
    ///
    /// # Errors
    /// The reason, for a message that names the topic.
    pub(super) fn decode(
        &mut self,
        topic: &str,
        message: &AnyMessage,
        info: Option<&Arc<CameraInfo>>,
    ) -> Result<PointGrid, String> {
        if let AnyMessage::PointCloud2(cloud) = message {
            return cloud_grid(cloud);
        }
        let info = info.ok_or("no CameraInfo beside it yet")?;
        let frame = depth_of(topic, message)?;
        if frame.size_px != [info.width, info.height] {
            let [width, height] = frame.size_px;
            let of_info = format!("{}x{}", info.width, info.height);
            return Err(format!("the depth image has {width}x{height} pixels, its CameraInfo {of_info}"));
        }
        let rays = self.rays(raw_topic(topic), info)?;
        Ok(PointGrid::from_depths(frame.size_px, &frame.depth_m, rays))
    }

    fn rays(&mut self, topic: &str, info: &Arc<CameraInfo>) -> Result<&[[f32; 2]], String> {
        let known = self.rays.take().filter(|(known, _)| Arc::ptr_eq(known, info) || has_same_lens(known, info));
        let rays = match known {
            Some((_, rays)) => rays,
            None => rays_of(topic, info)?,
        };
        Ok(&self.rays.insert((Arc::clone(info), rays)).1)
    }
}

fn has_same_lens(a: &CameraInfo, b: &CameraInfo) -> bool {
    (a.width, a.height, &a.distortion_model, &a.D, &a.K, &a.P)
        == (b.width, b.height, &b.distortion_model, &b.D, &b.K, &b.P)
}

/// Directions x/z and y/z of all pixels; NaN where the lens has none.
fn rays_of(topic: &str, info: &CameraInfo) -> Result<Vec<[f32; 2]>, String> {
    let lens = lens_of_topic(info, topic)?;
    let pixels = (0..info.height).flat_map(|row| (0..info.width).map(move |column| [column, row].map(f64::from)));
    let ray = |[u, v]: [f64; 2]| lens.plane(Point2::new(u, v)).map_or([f32::NAN; 2], |at| [at.x as f32, at.y as f32]);
    Ok(pixels.map(ray).collect())
}

fn cloud_grid(cloud: &PointCloud2) -> Result<PointGrid, String> {
    if cloud.height < 2 {
        return Err(format!("the cloud is not organised: it has {} row", cloud.height));
    }
    let points = cloud.positions().map_err(|error| error.to_string())?;
    let points = points.map(|point| point.map(|number| number as f32)).collect();
    Ok(PointGrid { size_px: [cloud.width, cloud.height], points })
}

#[cfg(test)]
mod tests {
    use rcs_messages::sensor_msgs::PointField;
    use rcs_messages::std_msgs::Header;
    use rcs_messages::Image;

    use super::*;

    fn info(fx: f64) -> Arc<CameraInfo> {
        Arc::new(CameraInfo {
            width: 2,
            height: 1,
            K: [fx, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            P: [fx, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            ..CameraInfo::default()
        })
    }

    fn depth_image(width: u32) -> AnyMessage {
        let data = [1500_u16, 0, 0].map(u16::to_le_bytes).concat()[..2 * width as usize].to_vec();
        AnyMessage::Image(Arc::new(Image::new(Header::default(), [width, 1], "16UC1", 2 * width, Arc::new(data))))
    }

    #[test]
    fn a_depth_image_has_the_rays_of_its_camera_info() {
        let mut decoder = GridDecoder::default();
        let image = depth_image(2);
        assert_eq!(decoder.decode("/d", &image, None), Err("no CameraInfo beside it yet".to_owned()));
        let grid = decoder.decode("/d", &image, Some(&info(2.0))).unwrap();
        assert_eq!((grid.size_px, grid.points[0]), ([2, 1], [0.0, 0.0, 1.5]));
        assert!(grid.points[1][2].is_nan());
        assert_eq!(decoder.rays("/d", &info(2.0)).unwrap()[1], [0.5, 0.0]);
        assert_eq!(decoder.rays("/d", &info(4.0)).unwrap()[1], [0.25, 0.0], "another lens");
        let error = decoder.decode("/d", &depth_image(3), Some(&info(2.0))).unwrap_err();
        assert_eq!(error, "the depth image has 3x1 pixels, its CameraInfo 2x1");
    }

    #[test]
    fn an_organised_cloud_is_a_grid_and_one_row_is_none() {
        let field = |name: &str, offset| PointField { name: name.to_owned(), offset, datatype: 7, count: 1 };
        let cloud = |width, height| {
            let mut cloud = PointCloud2::default();
            (cloud.width, cloud.height, cloud.point_step, cloud.row_step) = (width, height, 12, 12 * width);
            cloud.fields = vec![field("x", 0), field("y", 4), field("z", 8)];
            let data = (0..12_u8).flat_map(|number| f32::from(number).to_le_bytes()).collect();
            AnyMessage::PointCloud2(Arc::new(cloud.with_data(data)))
        };
        let grid = GridDecoder::default().decode("/c", &cloud(2, 2), None).unwrap();
        assert_eq!((grid.size_px, grid.points[3]), ([2, 2], [9.0, 10.0, 11.0]));
        let error = GridDecoder::default().decode("/c", &cloud(4, 1), None).unwrap_err();
        assert_eq!(error, "the cloud is not organised: it has 1 row");
    }

    #[test]
    fn a_compressed_image_belongs_to_the_topic_before_its_transport() {
        let raw = ["/d/image_rect/compressedDepth", "/d/image_rect/compressed", "/d/image_rect"].map(raw_topic);
        assert_eq!(raw, ["/d/image_rect"; 3]);
    }
}
