//! `rviz/DepthCloud`: a depth image as a cloud of points, coloured by a second image.

use crate::displays::cloud::CloudSettings;
use crate::section::{at_least, Section, ANY};

/// The properties of a DepthCloud display.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthCloudSettings {
    /// How points are drawn. Its queue size, at least 1, is that of the images; its topic is not used.
    pub cloud: CloudSettings,
    /// Topic of the depth image; empty when none is chosen. Its `CameraInfo` comes on the topic `camera_info` beside
    /// it.
    pub depth_topic: String,
    /// The image transport of the depth image: `raw`, `compressed` or `compressedDepth`.
    pub depth_transport: String,
    /// Topic of the colour image; empty when there is none.
    pub color_topic: String,
    /// The image transport of the colour image.
    pub color_transport: String,
    /// Whether points are as large as their pixels, times `auto_size_factor`, instead of the cloud's size.
    pub auto_size: bool,
    /// At least 0.0001.
    pub auto_size_factor: f32,
    /// Whether points stay, darkened, while something nearer hides them.
    pub occlusion_compensation: bool,
    /// For how long, in seconds.
    pub occlusion_timeout_secs: f32,
}

impl Default for DepthCloudSettings {
    fn default() -> Self {
        DepthCloudSettings {
            cloud: CloudSettings { queue_size: 5, ..CloudSettings::default() },
            depth_topic: String::new(),
            depth_transport: "raw".to_owned(),
            color_topic: String::new(),
            color_transport: "raw".to_owned(),
            auto_size: true,
            auto_size_factor: 1.0,
            occlusion_compensation: false,
            occlusion_timeout_secs: 30.0,
        }
    }
}

impl DepthCloudSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = DepthCloudSettings::default();
        settings.cloud.read_points(section);
        section.count("Queue Size", 1, &mut settings.cloud.queue_size);
        section.text("Depth Map Topic", &mut settings.depth_topic);
        section.text("Depth Map Transport Hint", &mut settings.depth_transport);
        section.text("Color Image Topic", &mut settings.color_topic);
        section.text("Color Transport Hint", &mut settings.color_transport);
        let mut auto_size = section.child("Auto Size");
        auto_size.bool("Value", &mut settings.auto_size);
        auto_size.float("Auto Size Factor", at_least(0.0001), &mut settings.auto_size_factor);
        auto_size.finish();
        let mut occlusion = section.child("Occlusion Compensation");
        occlusion.bool("Value", &mut settings.occlusion_compensation);
        occlusion.float("Occlusion Time-Out", ANY, &mut settings.occlusion_timeout_secs);
        occlusion.finish();
        // Only narrows down the topics that rviz offers.
        section.skip(&["Topic Filter"]);
        settings
    }
}
