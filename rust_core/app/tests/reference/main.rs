//! The reference pages `docs/reference/nodes.md` and `launch-files.md` are what the programs and launch files say.
//!
//! With `RCS_WRITE_DOCS=1`, the pages are written instead of compared.

#![allow(clippy::expect_used, clippy::panic, reason = "what fails is the test")]

mod launch_files;
mod markdown;
mod nodes;

use std::fs;
use std::path::{Path, PathBuf};

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
