//! `camera_stream`: the virtual cameras of a `.rviz` config, as a ROS node or over a bag. See
//! [`rcs_camera_stream`].

fn main() -> std::process::ExitCode {
    rcs_camera_stream::main()
}
