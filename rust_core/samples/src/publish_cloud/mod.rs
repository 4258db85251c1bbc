//! `publish_cloud`: a PCD file as a latched `sensor_msgs/PointCloud2`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use clap::{Command, CommandFactory, Parser};
use rcs_files::pcd::PcdCloud;
use rcs_files::FileError;
use rcs_messages::PointCloud2;
use rcs_ros::RosNode;

use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::node_options::{with_parameters, within};
use rcs_node_support::ros_names::{publishes, RosName};
use rcs_node_support::user_file;

/// Topics of the node.
pub const ROS_NAMES: &[RosName] = &[publishes("cloud", "sensor_msgs/PointCloud2", "the file's points, latched")];

/// Publishes a PCD file as a latched sensor_msgs/PointCloud2.
///
/// Reads ascii, binary and binary_compressed files with any fields; x, y and z of doubles or integers become float32,
/// which rviz needs. The file's VIEWPOINT is ignored. ROS's remappings and special arguments work: cloud:=/other
/// __name:=name __ns:=namespace.
#[derive(Parser)]
#[command(
    name = "publish_cloud",
    display_name = "rviz_camera_stream",
    version,
    before_help = "\
Examples:
  publish_cloud objects.pcd --frame base_link cloud:=/objects",
    after_help = "\
Topic published: cloud (sensor_msgs/PointCloud2, latched)
Parameters: each option is one, too: --file is ~file
Exit codes: 0 ended by SIGINT, SIGTERM or rosnode kill; 1 the file or the node failed; 2 invalid arguments"
)]
struct PublishCloudArguments {
    /// The PCD file
    #[arg(value_name = "FILE")]
    positional: Option<PathBuf>,
    /// The PCD file, as an option
    #[arg(long, conflicts_with = "positional")]
    file: Option<PathBuf>,
    /// The topic; a remapping cloud:=/other does the same
    #[arg(long, default_value = "cloud")]
    topic: String,
    /// The frame of the points (header.frame_id)
    #[arg(long, default_value = "map")]
    frame: String,
    /// How often to publish, in Hz, each time with the current time as stamp; 0: once
    #[arg(long, default_value_t = 1.0, value_parser = within(0.0, 1000.0))]
    rate: f64,
}

impl PublishCloudArguments {
    fn path(&self) -> Option<&Path> {
        self.positional.as_deref().or(self.file.as_deref())
    }
}

/// The command line.
pub fn command() -> Command {
    PublishCloudArguments::command()
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    lifecycle::run_main(|arguments: PublishCloudArguments| run(&arguments))
}

fn run(arguments: &PublishCloudArguments) -> anyhow::Result<()> {
    // An invalid file is reported at once, not when the master is up.
    let message = arguments.path().map(|path| read_users(path, &arguments.frame)).transpose()?;
    lifecycle::with_node("publish_cloud", |node, end| {
        let arguments: PublishCloudArguments = with_parameters(node)?;
        let path = arguments.path().context("no PCD file: give FILE, --file FILE or the parameter ~file")?;
        let message = message.map_or_else(|| read_users(path, &arguments.frame), Ok)?;
        publish(node, end, path, &arguments, message)
    })
}

/// [`read`] of a file that a user names.
fn read_users(path: &Path, frame: &str) -> anyhow::Result<PointCloud2> {
    user_file::check(path)?;
    Ok(read(path, frame)?)
}

/// Publishes the cloud at the rate until the shutdown is requested.
fn publish(
    node: &RosNode,
    end: &EndRequest,
    path: &Path,
    arguments: &PublishCloudArguments,
    mut message: PointCloud2,
) -> anyhow::Result<()> {
    message.header.frame_id.clone_from(&arguments.frame);
    let publisher = node.latched_publisher::<PointCloud2>(&arguments.topic, 1)?;
    let PointCloud2 { width, height, .. } = message;
    log::info!(
        "{}: {width}x{height} points in frame {} on {} at {} Hz",
        path.display(),
        arguments.frame,
        publisher.topic(),
        arguments.rate
    );
    loop {
        let mut stamped = message.clone();
        stamped.header.stamp = node.now();
        publisher.send(stamped)?;
        if end.wait_for(period(arguments.rate)) {
            return Ok(());
        }
    }
}

/// The time between two messages; the longest there is for a rate of 0.
fn period(rate_hz: f64) -> Duration {
    Duration::try_from_secs_f64(rate_hz.recip()).unwrap_or(Duration::MAX)
}

/// The cloud of a PCD file as a message in a frame, with coordinates of float32.
///
/// # Errors
/// [`FileError`] with the file and the line or offset.
pub fn read(path: &Path, frame: &str) -> Result<PointCloud2, FileError> {
    let mut cloud = PcdCloud::read(path)?;
    if let Some(change) = cloud.coordinates_to_f32() {
        let file = path.display();
        log::warn!("{file}: x, y and z are not float32 and were converted, with rounding by up to {change:.1e}");
    }
    Ok(message(cloud, frame))
}

fn message(cloud: PcdCloud, frame: &str) -> PointCloud2 {
    let mut message = PointCloud2::default().with_data(cloud.data);
    message.header.frame_id = frame.to_owned();
    message.height = cloud.height;
    message.width = cloud.width;
    message.fields = cloud.fields;
    message.point_step = cloud.point_step_bytes;
    // The reader rejects a cloud with more bytes than fit into a u32.
    message.row_step = cloud.point_step_bytes.saturating_mul(cloud.width);
    message.is_dense = cloud.is_dense;
    message
}

#[cfg(test)]
mod tests {
    use rcs_messages::sensor_msgs::PointField;

    use super::*;

    #[test]
    fn doubles_and_integers_are_published_as_float32() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cloud.pcd");
        let file = "FIELDS x y z\nSIZE 8 2 4\nTYPE F I F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n0.5 -2 3\n";
        std::fs::write(&path, file).unwrap();
        let cloud = read(&path, "map").unwrap();
        assert!(cloud.fields.iter().all(|field| field.datatype == PointField::FLOAT32));
        assert_eq!((cloud.point_step, cloud.row_step, cloud.header.frame_id.as_str()), (12, 12, "map"));
        assert_eq!(cloud.data(), [0.5_f32, -2.0, 3.0].map(f32::to_le_bytes).concat());
    }

    #[test]
    fn a_rate_of_next_to_nothing_is_a_wait_without_end() {
        assert_eq!(period(2.0), Duration::from_millis(500));
        assert_eq!([0.0, 1e-300, 1e-20].map(period), [Duration::MAX; 3]);
        assert!(period(1e-19) < Duration::MAX);
    }
}
