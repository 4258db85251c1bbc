//! `write_help`: man pages and completions. See [`rcs_app::help_files`].

fn main() -> std::process::ExitCode {
    rcs_app::help_files::main()
}
