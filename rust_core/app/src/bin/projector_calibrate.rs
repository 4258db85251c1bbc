//! `projector_calibrate`: a projector's intrinsics and pose. See [`rcs_projector_calibrate`].

fn main() -> std::process::ExitCode {
    rcs_projector_calibrate::main()
}
