//! The README's tables of arguments give the defaults that the programs have.
#![allow(clippy::unwrap_used, reason = "a test whose set-up fails has failed")]

use std::fs;
use std::process::Command;

use rcs_app::camera_stream::camera_pose::{CameraModel, Projection};
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

/// Options whose defaults are compared with nothing, and why.
const NOT_COMPARED: [(&str, &str); 2] = [
    ("--fixed-frame", "its default is the config's own, and the help names none"),
    ("--no-watch", "a flag; timing/settings.rs runs the node with and without it"),
];

/// The default of an option of the node, which its help does not name because a parameter may give it as well.
fn default_in_settings(option: &str) -> Option<String> {
    match option {
        "--renderer" => Some(format!("{:?}", RendererChoice::default()).to_lowercase()),
        "--projection" => Some(format!("{:?}", Projection::default()).to_lowercase()),
        "--undistort" => Some(CameraModel::default().undistort.to_string()),
        _ => None,
    }
}

#[test]
fn defaults_are_those_of_the_programs() {
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    let mut not_compared = Vec::new();
    for (node, section) in [
        ("camera_stream", "### `camera_stream"),
        ("projector", "### `projector FILE"),
        ("projector_window", "### `projector_window`"),
        ("publish_cloud", "### `publish_cloud"),
    ] {
        let help = String::from_utf8(Command::new(program(node)).arg("--help").output().unwrap().stdout).unwrap();
        let rows = rows(&readme, section);
        assert!(rows.len() > 2, "{node}: {rows:?}");
        for row in rows {
            let [names, _, written, ..] = &*row else { panic!("{node}: {row:?}") };
            for option in values(names).into_iter().filter(|name| name.starts_with("--")) {
                let default = default_in_settings(option).or_else(|| default_in_help(&help, option));
                match default {
                    Some(default) => {
                        let words: Vec<&str> = default.split([' ', ',']).collect();
                        let is_it = |value: &&str| *value == default || words.contains(value);
                        assert!(values(written).iter().all(is_it), "{node} {option}: \"{default}\", not {written}");
                    }
                    None if ["required", "none"].contains(&&**written) => {
                        assert!(help.contains(&format!("{option} <")), "{node} has no {option}:\n{help}");
                    }
                    None => not_compared.push(option.to_owned()),
                }
            }
        }
    }
    assert_eq!(not_compared, NOT_COMPARED.map(|(option, _)| option));
}
