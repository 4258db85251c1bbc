//! `publish_cloud`: a PCD file as a latched PointCloud2. See [`rcs_app::publish_cloud`].

fn main() -> std::process::ExitCode {
    rcs_app::publish_cloud::main()
}
