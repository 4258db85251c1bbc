//! `publish_cloud`: a PCD file as a latched PointCloud2. See [`rcs_samples::publish_cloud`].

fn main() -> std::process::ExitCode {
    rcs_samples::publish_cloud::main()
}
