//! `projector_calibrate`: a projector's intrinsics and pose. See [`rcs_app::projector_calibrate`].

fn main() -> std::process::ExitCode {
    rcs_app::projector_calibrate::main()
}
