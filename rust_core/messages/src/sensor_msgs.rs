//! `sensor_msgs`, without the two big ones: those are [`crate::PointCloud2`] and [`crate::Image`].

use crate::message::ros_message;
use crate::std_msgs::Header;

pub use crate::image::Image;
pub use crate::point_cloud2::PointCloud2;

ros_message! {
    /// The part of a picture that is used; all zeros is the whole.
    "sensor_msgs/RegionOfInterest" "bdb633039d588fcccb441a4d43ccfe09" struct RegionOfInterest {
        x_offset: u32,
        y_offset: u32,
        height: u32,
        width: u32,
        do_rectify: bool,
    }

    /// The geometry of a camera or projector: size in pixels, distortion `D`, intrinsics `K` (3×3), rectification `R`
    /// (3×3) and projection `P` (3×4), matrices row by row.
    "sensor_msgs/CameraInfo" "c9a58c1b0b154e0e6da7578cb991d214" struct CameraInfo {
        header: Header,
        height: u32,
        width: u32,
        distortion_model: String,
        D: Vec<f64>,
        K: [f64; 9],
        R: [f64; 9],
        P: [f64; 12],
        binning_x: u32,
        binning_y: u32,
        roi: RegionOfInterest,
    }

    /// One channel of a point: where in the point's bytes it lies and what number it is.
    "sensor_msgs/PointField" "268eacb2962780ceac86cbd17e328150" struct PointField {
        [
            INT8: u8 = 1,
            UINT8: u8 = 2,
            INT16: u8 = 3,
            UINT16: u8 = 4,
            INT32: u8 = 5,
            UINT32: u8 = 6,
            FLOAT32: u8 = 7,
            FLOAT64: u8 = 8,
        ]
        name: String,
        offset: u32,
        datatype: u8,
        count: u32,
    }
}
