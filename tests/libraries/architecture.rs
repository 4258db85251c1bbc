//! The structure of `docs/contributing/architecture.md`: files do not use each other in circles, and the page explains
//! each crate. Dependencies between crates are checked by deny.toml.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use rcs_tests::modules::Modules;
use rcs_tests::programs::repository;
use rcs_tests::sources::{missing, rust_files, texts};

/// The crates that may have `unsafe`: neither C's pointers can be read nor the C library be called without it.
const UNSAFE: [&str; 2] = ["rust_core/capi", "rust_core/process"];

/// The folders of all crates.
fn crates() -> Vec<String> {
    let core = fs::read_dir(repository().join("rust_core")).unwrap_or_else(|error| panic!("rust_core: {error}"));
    let folders =
        core.filter_map(|entry| entry.ok().filter(|entry| entry.path().is_dir())?.file_name().into_string().ok());
    let tests = ["tests", "tests/support", "tests/fuzz"].map(str::to_owned);
    folders.map(|name| format!("rust_core/{name}")).chain(tests).collect()
}

/// A crate's manifest.
fn manifest(folder: &str) -> String {
    let path = repository().join(folder).join("Cargo.toml");
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn files_do_not_use_each_other_in_a_circle() {
    let mut crates: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for (file, text) in texts() {
        let parts = file.strip_prefix("rust_core/").and_then(|file| file.split_once("/src/"));
        let (name, file) = parts.unwrap_or_else(|| panic!("{file} is in no crate"));
        crates.entry(name.to_owned()).or_default().push((file.to_owned(), text));
    }
    for (name, files) in crates {
        let circles = Modules::new(&files).circles();
        assert!(circles.is_empty(), "rust_core/{name}: files in circles: {circles:#?}");
    }
}

#[test]
fn circles_of_files_are_recognised() {
    let circles = |files: &[(&str, &str)]| {
        let files: Vec<_> = files.iter().map(|(file, text)| ((*file).to_owned(), (*text).to_owned())).collect();
        Modules::new(&files).circles().into_iter().flatten().collect::<Vec<_>>()
    };
    let root = ("lib.rs", "mod a;\nmod b;\npub use a::Ant;\npub use b::{\n    Bee,\n    Wasp as Hornet,\n};\n");
    let ant = ("a.rs", "use crate::Hornet;\n\npub struct Ant(Hornet);\n");
    assert_eq!(circles(&[root, ant, ("b.rs", "pub struct Bee;\npub struct Wasp(Vec<crate::Ant>);\n")]), ["a", "b"]);
    assert_eq!(circles(&[root, ant, ("b/mod.rs", "use super::*;\n\npub enum Wasp {\n    Of(Ant),\n}\n")]), ["a", "b"]);
    assert_eq!(circles(&[root, ant, ("b.rs", "pub struct Bee;\npub struct Wasp(Bee);\n")]), [""; 0]);
    // A module and what it consists of.
    let parent = ("a/mod.rs", "mod c;\n\npub const fn sting() {\n    c::sting(Ant);\n}\npub(crate) struct Ant;\n");
    assert_eq!(circles(&[root, parent, ("a/c.rs", "pub fn sting(_: super::Ant) {}\n")]), [""; 0]);
}

/// rustc forbids `unsafe` in all crates that take the workspace's lints; the others must repeat all other lints.
#[test]
fn every_crate_takes_the_lints_of_the_workspace() {
    let workspace = manifest(".");
    let lints = workspace.split("[workspace.lints.").skip(1).flat_map(|table| table.lines().skip(1));
    let lints = lints.take_while(|line| !line.starts_with("[profile"));
    let lints: Vec<&str> = lints.filter(|line| line.contains(" = ") && !line.contains("unsafe_code")).collect();
    assert!(lints.len() > 5 && workspace.contains("unsafe_code = \"forbid\""), "{lints:?}");
    for folder in crates() {
        let text = manifest(&folder);
        if UNSAFE.contains(&&*folder) {
            for lint in
                ["unsafe_op_in_unsafe_fn = \"deny\"", "undocumented_unsafe_blocks = \"warn\""].iter().chain(&lints)
            {
                assert!(text.contains(lint), "{folder}: no {lint}");
            }
        } else {
            assert!(text.contains("[lints]\nworkspace = true"), "{folder}");
        }
    }
}

/// Their manifests say that there is nothing to compile for tests in them.
#[test]
fn programs_hold_no_tests() {
    let files = rust_files(&repository());
    let programs = files.iter().filter(|file| file.components().any(|part| part.as_os_str() == "bin"));
    let mut checked = 0;
    for file in programs {
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        assert!(!text.contains("#[test]"), "{}: cargo does not run its tests", file.display());
        checked += 1;
    }
    assert!(checked > 10, "{checked} programs");
}

/// What works for the images on a thread of its own is watched, or a hang of it is not named in the log.
#[test]
fn what_works_for_the_images_is_watched() {
    let registering = [
        ("runtime/mod.rs", "let_watchdog=Watchdog::start()"),
        ("runtime/shared.rs", "watchdog::watch(&activity);"),
        ("runtime/control_thread.rs", "Task::watched(\"answeringcalls\")"),
        ("outputs/compressed.rs", "Task::watched(format!(\"compressingapictureof{}\""),
        ("outputs/page.rs", "Task::watched(\"encodinganimageforthepage\")"),
        ("outputs/window.rs", "watchdog::watch(&worker);"),
    ];
    assert_eq!(missing("rust_core/camera_stream/src", &registering), [""; 0]);
}

// --- the tables of docs/contributing/architecture.md -----------------------------------------------------------------

const PAGE: &str = "docs/contributing/architecture.md";

/// The rows of the table with these headings, cell by cell.
fn table(heading: &str) -> Vec<Vec<String>> {
    let page = repository().join(PAGE);
    let page = fs::read_to_string(&page).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
    let mut lines = page.lines().skip_while(|line| *line != heading).skip(2);
    let mut rows = Vec::new();
    while let Some(row) = lines.next().and_then(|line| line.strip_prefix('|')?.strip_suffix('|')) {
        rows.push(row.split('|').map(|cell| cell.trim().to_owned()).collect());
    }
    assert!(!rows.is_empty(), "{PAGE} has no table {heading}");
    rows
}

/// The names in the first column of a table, each once and with an explanation.
fn explained(heading: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for row in table(heading) {
        assert!(row.iter().all(|cell| !cell.is_empty()), "{row:?} explains nothing");
        for name in row[0].split(", ").map(|name| name.trim_matches('`').to_owned()) {
            assert!(names.insert(name), "{} stands there twice", row[0]);
        }
    }
    names
}

#[test]
fn every_crate_is_explained() {
    let explained = explained("|folder|contents|");
    for folder in crates() {
        assert!(explained.contains(&folder), "{PAGE} has no row for {folder}");
    }
    for folder in explained {
        assert!(repository().join(&folder).exists(), "{PAGE}: there is no {folder}");
    }
}

/// Where a manifest gives a dependency's version, a comment above says what it is for.
#[test]
fn every_direct_dependency_is_justified() {
    let (mut checked, mut wrong) = (0, Vec::new());
    for folder in crates().into_iter().chain([".".to_owned()]) {
        let (mut is_dependency, mut above) = (false, "");
        let text = manifest(&folder);
        for line in text.lines() {
            if line.starts_with('[') {
                is_dependency = line.trim_end_matches(']').ends_with("dependencies");
            } else if is_dependency && (line.contains("= \"") || line.contains("{ version =")) {
                checked += 1;
                if !above.starts_with("# ") && !line.contains("path = ") {
                    wrong.push(format!("{folder}: {line}"));
                }
            }
            above = line;
        }
    }
    assert!(checked > 50, "only {checked} dependencies were found");
    assert!(wrong.is_empty(), "nothing says what these are for:\n{}", wrong.join("\n"));
}

#[test]
fn the_workspace_lists_no_dependency_that_nobody_uses() {
    let text = manifest(".");
    let section = text.split("[workspace.dependencies]").nth(1).expect("Cargo.toml has workspace.dependencies");
    let section = section.split("\n[").next().unwrap_or_default();
    let used: Vec<String> = crates().iter().map(|folder| manifest(folder)).collect();
    for line in section.lines().filter(|line| !line.starts_with('#') && line.contains('=')) {
        let name = line.split([' ', '=']).next().unwrap_or_default();
        let is_named = |text: &String| {
            text.lines().any(|line| line.strip_prefix(name).is_some_and(|rest| rest.starts_with(['.', ' ', '='])))
        };
        assert!(used.iter().any(is_named), "Cargo.toml lists {name}, which no crate uses");
    }
}
