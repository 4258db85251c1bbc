//! `line_of_sight`: the light between lens and target as an obstacle. See [`rcs_samples::line_of_sight`].

fn main() -> std::process::ExitCode {
    rcs_samples::line_of_sight::main()
}
