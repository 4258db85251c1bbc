//! `simulate_scan`: a camera and a projector to rehearse with. See [`rcs_samples::simulate_scan`].

fn main() -> std::process::ExitCode {
    rcs_samples::simulate_scan::main()
}
