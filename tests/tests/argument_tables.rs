//! The README's tables of arguments give the defaults that the programs have.
#![allow(clippy::unwrap_used, reason = "a test whose set-up fails has failed")]

use std::fs;
use std::process::Command;

use rcs_app::camera_stream::camera_pose::Projection;
use rcs_render::RendererChoice;
use rcs_tests::programs::{program, repository};

/// The rows of a node's table of arguments in the README, cell by cell.
fn rows(readme: &str, section: &str) -> Vec<Vec<String>> {
    let body = readme.split(section).nth(1).unwrap().split("\n### ").next().unwrap();
    let lines = body.lines().skip_while(|line| !line.starts_with("| argument")).skip(2);
    let rows = lines.map_while(|line| line.strip_prefix('|')?.strip_suffix('|'));
    rows.map(|row| row.split('|').map(|cell| cell.trim().to_owned()).collect()).collect()
}

/// The words in backticks, or the whole cell if there are none.
fn values(cell: &str) -> Vec<&str> {
    let quoted: Vec<&str> = cell.split('`').skip(1).step_by(2).collect();
    if quoted.is_empty() {
        vec![cell]
    } else {
        quoted
    }
}

/// What a program's help prints as an option's default.
fn default_in_help(help: &str, option: &str) -> Option<String> {
    let start = help.find(&format!("{option} <"))?;
    let paragraph = help[start..].split("\n      --").next()?;
    let default = paragraph.split("[default: ").nth(1)?;
    Some(default.split(']').next()?.to_owned())
}

#[test]
fn defaults_are_those_of_the_programs_help() {
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    let mut compared = Vec::new();
    for (node, section) in [
        ("projector", "### `projector FILE"),
        ("projector_window", "### `projector_window`"),
        ("publish_cloud", "### `publish_cloud"),
    ] {
        let help = String::from_utf8(Command::new(program(node)).arg("--help").output().unwrap().stdout).unwrap();
        for row in rows(&readme, section) {
            for option in values(&row[0]).into_iter().filter(|name| name.starts_with("--")) {
                let Some(default) = default_in_help(&help, option) else { continue };
                for value in values(&row[2]).into_iter().filter(|value| !value.contains(' ')) {
                    let words: Vec<&str> = default.split([' ', ',']).collect();
                    assert!(words.contains(&value), "{node} {option}: \"{default}\", in the README {}", row[2]);
                    compared.push(option.to_owned());
                }
            }
        }
    }
    for option in ["--camera-info-topic", "--frame-id", "--topic", "--frame", "--rate"] {
        assert!(compared.iter().any(|name| name == option), "{option} was not compared: {compared:?}");
    }
}

#[test]
fn defaults_of_the_node_are_those_of_its_settings() {
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    let rows = rows(&readme, "### `camera_stream");
    let default = |option: &str| {
        let row = rows.iter().find(|row| values(&row[0]).contains(&option)).unwrap();
        values(&row[2])[0].to_owned()
    };
    assert_eq!(default("--renderer").parse(), Ok(RendererChoice::default()));
    assert_eq!(default("--projection"), format!("{:?}", Projection::default()).to_lowercase());
}
