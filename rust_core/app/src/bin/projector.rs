//! `projector`: a projector's CameraInfo and frames from a YAML file. See [`rcs_app::projector`].

fn main() -> std::process::ExitCode {
    rcs_app::projector::main()
}
