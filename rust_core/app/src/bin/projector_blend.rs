//! `projector_blend`: the shares that several projectors have of the light on one surface. See
//! [`rcs_app::projector_blend`].

fn main() -> std::process::ExitCode {
    rcs_app::projector_blend::main()
}
