//! `nav_path_markers`: a planned path as arrows on the floor. See [`rcs_samples::nav_path_markers`].

fn main() -> std::process::ExitCode {
    rcs_samples::nav_path_markers::main()
}
