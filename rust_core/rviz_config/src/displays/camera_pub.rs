//! `rviz_camera_stream/CameraPub`: a virtual camera that takes its optics from a CameraInfo topic and publishes images.

use rcs_scene::Encoding;

use crate::displays::visibility::Visibility;
use crate::section::at_least;

properties! {
    /// The properties of a CameraPub display.
    pub struct CameraPubSettings {
        /// Topic on which images are published; empty when none is chosen, and then nothing is.
        image_topic: String = String::new() => text("Image Topic");
        /// Topic of `sensor_msgs/CameraInfo` that gives the camera its optics and frame; empty when none is chosen.
        camera_info_topic: String = String::new() => text("Camera Info Topic");
        /// Namespace of the display's topics and its trigger service.
        display_namespace: String = String::new() => text("Display namespace");
        /// Most CameraInfos that wait for their transform; at least 1.
        queue_size: u32 = 2 => count("Queue Size", 1);
        /// Images a second; below 0 as fast as the scene changes, 0 only on trigger; at least -1.
        frame_rate_hz: f32 = -1.0 => float("Frame Rate", at_least(-1.0));
        /// Red, green and blue where nothing is drawn.
        background_color: [u8; 3] = [0, 0, 0] => color("Background Color");
        /// Pixel layout of the images.
        image_encoding: Encoding = Encoding::Rgb8
            => choice("Image Encoding", &Encoding::ALL.map(|encoding| (encoding.name(), encoding)));
        /// Near clip distance in metres; at least 0.01.
        near_clip_m: f32 = 0.01 => float("Near Clip Distance", at_least(0.01));
        /// `true` if P is followed exactly, instead of as rviz draws it. For the plugin; the node has an option.
        is_exact: bool = false => choice("Projection", &[("rviz", false), ("exact", true)]);
        /// `true` if the image is bent for the lens of K and D. For the plugin; the node has an option.
        undistort: bool = false => bool("Undistort");
        /// Topic on which the plugin publishes depths; empty for none. The node publishes them beside the image.
        depth_topic: String = String::new() => text("Depth Topic");
        /// The displays that this camera draws.
        visibility: Visibility = Visibility::default() => inside("Visibility");
    }
    // A file that the plugin writes.
    skip ["Headless Twin"];
}
