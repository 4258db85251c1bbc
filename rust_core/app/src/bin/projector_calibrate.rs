//! `projector_calibrate`: a projector's intrinsics and pose. See [`rcs_calibrate`].

fn main() -> std::process::ExitCode {
    rcs_calibrate::main()
}
