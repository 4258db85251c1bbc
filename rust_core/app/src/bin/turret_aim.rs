//! `turret_aim`: points a pan-tilt unit at a target. See [`rcs_samples::turret_aim`].

fn main() -> std::process::ExitCode {
    rcs_samples::turret_aim::main()
}
