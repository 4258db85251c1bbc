//! The reference pages `docs/reference/nodes.md` and `launch-files.md` are what the programs and launch files say.
//!
//! With `RCS_WRITE_DOCS=1`, the pages are written instead of compared.

#![allow(clippy::expect_used, clippy::panic, reason = "what fails is the test")]

mod launch_files;
mod markdown;
mod nodes;

use std::fs;
use std::path::{Path, PathBuf};

use rcs_app::all_programs::PROGRAMS;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Compares a page with the generated text, or writes it.
fn check(page: &str, generated: &str) {
    let path = repository().join("docs/reference").join(page);
    if std::env::var_os("RCS_WRITE_DOCS").is_some() {
        fs::write(&path, generated).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    let present = fs::read_to_string(&path).unwrap_or_default();
    let same = generated.lines().zip(present.lines()).take_while(|(a, b)| a == b).count();
    assert!(
        generated == present,
        "docs/reference/{page} is stale from line {} on; write it: {}",
        same + 1,
        markdown::COMMAND
    );
}

#[test]
fn the_page_of_nodes_is_what_the_programs_say() {
    check("nodes.md", &nodes::page());
}

#[test]
fn the_page_of_launch_files_is_what_the_files_say() {
    check("launch-files.md", &launch_files::page());
}

#[test]
fn the_help_of_each_command_begins_with_examples_that_it_takes_and_that_fit_a_terminal() {
    for program in &PROGRAMS {
        let mut root = (program.command)().term_width(80);
        root.build();
        for command in std::iter::once(&root).chain(root.get_subcommands().filter(|inner| inner.get_name() != "help")) {
            let examples = command.get_before_help().map(ToString::to_string).unwrap_or_default();
            assert!(examples.starts_with("Examples:\n  "), "{}: {examples}", command.get_name());
            let help = command.clone().render_long_help().to_string();
            assert_eq!(help.lines().find(|line| line.chars().count() > 80), None, "{}", command.get_name());
            assert!(help.starts_with(&examples), "an example is too long: {help}");
            for example in examples.replace("\\\n", "").lines().skip(1) {
                // What contains := is ROS's.
                let words = example.split_whitespace().filter(|word| !word.contains(":="));
                let matches = root.clone().try_get_matches_from(words).unwrap_or_else(|error| panic!("{error}"));
                let is_of_command = matches.subcommand_name() == Some(command.get_name());
                assert!(is_of_command || command.get_name() == program.name, "{example}");
            }
        }
    }
}
