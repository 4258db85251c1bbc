//! `all_programs`: what packages hold in place of the single programs. See [`rcs_app::all_programs`].

fn main() -> std::process::ExitCode {
    rcs_app::all_programs::main()
}
