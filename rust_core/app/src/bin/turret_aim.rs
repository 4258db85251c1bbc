//! `turret_aim`: points a pan-tilt unit at a target. See [`rcs_app::turret_aim`].

fn main() -> std::process::ExitCode {
    rcs_app::turret_aim::main()
}
