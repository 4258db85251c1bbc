//! `rviz_camera_stream/CameraPub`: a virtual camera that takes its optics from a CameraInfo topic and publishes what
//! it sees.

use rcs_scene::Encoding;

use crate::displays::visibility::Visibility;
use crate::section::{at_least, Section};

/// The properties of a CameraPub display.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPubSettings {
    /// Topic on which images are published; empty when none is chosen, and then nothing is.
    pub image_topic: String,
    /// Topic of `sensor_msgs/CameraInfo` that gives the camera its optics and frame; empty when none is chosen.
    pub camera_info_topic: String,
    /// Namespace of the display's topics and its trigger service.
    pub display_namespace: String,
    /// How many CameraInfos may wait for their transform; at least 1.
    pub queue_size: u32,
    /// Images a second; below 0 as fast as the scene changes, 0 only on trigger; at least -1.
    pub frame_rate_hz: f32,
    /// What is seen where there is nothing, as red, green and blue.
    pub background_color: [u8; 3],
    /// Pixel layout of the images.
    pub image_encoding: Encoding,
    /// Nearer than this nothing is drawn, in metres; at least 0.01.
    pub near_clip_m: f32,
    /// Whether P is taken exactly, and not as rviz draws it: what the plugin does; the node has an argument for it.
    pub is_exact: bool,
    /// Whether the picture is bent for the lens of K and D: what the plugin does; the node has an argument for it.
    pub undistort: bool,
    /// Topic on which the plugin publishes depths; empty for none. The node publishes them beside the picture.
    pub depth_topic: String,
    /// Which displays this camera sees.
    pub visibility: Visibility,
}

impl Default for CameraPubSettings {
    fn default() -> Self {
        CameraPubSettings {
            image_topic: String::new(),
            camera_info_topic: String::new(),
            display_namespace: String::new(),
            queue_size: 2,
            frame_rate_hz: -1.0,
            background_color: [0, 0, 0],
            image_encoding: Encoding::Rgb8,
            near_clip_m: 0.01,
            is_exact: false,
            undistort: false,
            depth_topic: String::new(),
            visibility: Visibility::default(),
        }
    }
}

impl CameraPubSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = CameraPubSettings::default();
        section.text("Image Topic", &mut settings.image_topic);
        section.text("Camera Info Topic", &mut settings.camera_info_topic);
        section.text("Display namespace", &mut settings.display_namespace);
        section.count("Queue Size", 1, &mut settings.queue_size);
        section.float("Frame Rate", at_least(-1.0), &mut settings.frame_rate_hz);
        section.color("Background Color", &mut settings.background_color);
        section.choice(
            "Image Encoding",
            &Encoding::ALL.map(|encoding| (encoding.name(), encoding)),
            &mut settings.image_encoding,
        );
        section.float("Near Clip Distance", at_least(0.01), &mut settings.near_clip_m);
        section.choice("Projection", &[("rviz", false), ("exact", true)], &mut settings.is_exact);
        section.bool("Undistort", &mut settings.undistort);
        section.text("Depth Topic", &mut settings.depth_topic);
        // A file that the plugin writes.
        section.skip(&["Headless Twin"]);
        settings.visibility = Visibility::read(section.child("Visibility"));
        settings
    }
}
