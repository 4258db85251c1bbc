//! `projector_window`: an image topic full screen on a monitor. See [`rcs_app::projector_window`].

fn main() -> std::process::ExitCode {
    rcs_app::projector_window::main()
}
