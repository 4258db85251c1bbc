//! `rviz/DepthCloud`: a depth image as a cloud of points, coloured by a second image.

use crate::displays::cloud::CloudSettings;
use crate::section::{at_least, Section, ANY};

properties! {
    /// The properties of a DepthCloud display.
    pub struct DepthCloudSettings {
        /// How points are drawn. Its queue size, at least 1, is the images'; its topic is not used.
        cloud: CloudSettings = CloudSettings { queue_size: 5, ..CloudSettings::default() } => properties();
        /// Topic of the depth image; empty when none is chosen. Its `CameraInfo` comes on the topic `camera_info`
        /// beside it.
        depth_topic: String = String::new() => text("Depth Map Topic");
        /// The image transport of the depth image: `raw`, `compressed` or `compressedDepth`.
        depth_transport: String = "raw".to_owned() => text("Depth Map Transport Hint");
        /// Topic of the colour image; empty when there is none.
        color_topic: String = String::new() => text("Color Image Topic");
        /// The image transport of the colour image.
        color_transport: String = "raw".to_owned() => text("Color Transport Hint");
    }
    inside "Auto Size" {
        /// `true` if points are as large as their pixels, times `auto_size_factor`, instead of the cloud's size.
        auto_size: bool = true => bool("Value");
        /// Factor of the automatic size; at least 0.0001.
        auto_size_factor: f32 = 1.0 => float("Auto Size Factor", at_least(0.0001));
    }
    inside "Occlusion Compensation" {
        /// `true` if points stay, darkened, while something nearer occludes them.
        occlusion_compensation: bool = false => bool("Value");
        /// Seconds that occluded points stay.
        occlusion_timeout_secs: f32 = 30.0 => float("Occlusion Time-Out", ANY);
    }
    // Only narrows down the topics that rviz offers.
    skip ["Topic Filter"];
    then read_queue_size;
}

impl DepthCloudSettings {
    fn read_queue_size(&mut self, section: &mut Section<'_>) {
        section.count("Queue Size", 1, &mut self.cloud.queue_size);
    }
}
