//! The tables of arguments give the defaults that the programs have: those of the README, those of docs/calibration.md,
//! which have every argument of `projector_calibrate`, and those of docs/samples.md.
#![allow(clippy::unwrap_used, reason = "a test whose set-up fails has failed")]

use std::fs;
use std::process::Command;

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
    let mut lines = help[start..].lines();
    let first = lines.next()?.to_owned();
    let paragraph = lines.take_while(|line| option_of(line).is_none()).fold(first, |text, line| text + " " + line);
    let default = paragraph.split("[default: ").nth(1)?;
    Some(default.split(']').next()?.to_owned())
}

/// The option that a line of a program's help begins to explain.
fn option_of(line: &str) -> Option<&str> {
    let text = line.trim_start();
    let is_option = line.len() - text.len() <= 6 && text.starts_with('-');
    is_option.then(|| text.split([' ', ',', '=']).find(|word| word.starts_with("--")))?
}

/// Whether a program's help has a switch.
fn has_switch(help: &str, option: &str) -> bool {
    help.lines().any(|line| option_of(line) == Some(option) && line.trim_end().ends_with(option))
}

#[test]
fn defaults_are_those_of_the_programs() {
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    for (node, section) in [
        ("camera_stream", "### `camera_stream"),
        ("projector", "### `projector FILE"),
        ("projector_blend", "### `projector_blend"),
        ("projector_window", "### `projector_window`"),
        ("publish_cloud", "### `publish_cloud"),
    ] {
        let help = String::from_utf8(Command::new(program(node)).arg("--help").output().unwrap().stdout).unwrap();
        let rows = rows(&readme, section);
        assert!(rows.len() > 2, "{node}: {rows:?}");
        for row in rows {
            let [names, _, written, ..] = &*row else { panic!("{node}: {row:?}") };
            for option in values(names).into_iter().filter(|name| name.starts_with("--")) {
                match default_in_help(&help, option) {
                    Some(default) => {
                        let words: Vec<&str> = default.split([' ', ',']).collect();
                        let is_it = |value: &&str| *value == default || words.contains(value);
                        assert!(values(written).iter().all(is_it), "{node} {option}: \"{default}\", not {written}");
                    }
                    None if ["required", "none"].contains(&&**written) => {
                        assert!(help.contains(&format!("{option} <")), "{node} has no {option}:\n{help}");
                    }
                    None if option == "--identify" => assert!(help.contains("--identify [<SECS>]"), "{help}"),
                    // Help has the one of two switches that is not the default.
                    None => {
                        let switch =
                            if written == "on" { option.replacen("--", "--no-", 1) } else { option.to_owned() };
                        assert!(has_switch(&help, &switch), "{node} has no {switch}:\n{help}");
                    }
                }
            }
        }
    }
}

/// The options that a program's help explains, without --help; what follows are examples.
fn options_of(help: &str) -> impl Iterator<Item = &str> {
    let explained = help.lines().skip_while(|line| *line != "Options:").skip(1);
    let explained = explained.take_while(|line| line.is_empty() || line.starts_with(' '));
    explained.filter_map(option_of).filter(|option| *option != "--help")
}

/// The arguments without a name that a program's help explains, without brackets.
fn places_of(help: &str) -> Vec<&str> {
    let explained =
        help.lines().skip_while(|line| *line != "Arguments:").skip(1).take_while(|line| *line != "Options:");
    explained.filter_map(|line| line.strip_prefix("  ")?.strip_prefix(['<', '['])?.split(['>', ']']).next()).collect()
}

/// What a table must say of an argument's default.
fn expected_default(help: &str, argument: &str) -> String {
    let usage = help.lines().find(|line| line.starts_with("Usage:")).unwrap();
    let words: Vec<&str> = usage.split_whitespace().collect();
    let is_required = words.windows(2).any(|words| {
        let is_value = words[0].starts_with('-');
        words[0] == argument || (!is_value && words[1].trim_end_matches("...") == format!("<{argument}>"))
    });
    if is_required {
        return "required".to_owned();
    }
    let is_flag = help.lines().any(|line| line.trim_end().ends_with(argument) && option_of(line) == Some(argument));
    default_in_help(help, argument).unwrap_or_else(|| if is_flag { "off" } else { "none" }.to_owned())
}

#[test]
fn every_argument_of_the_samples_is_in_a_table_with_its_default() {
    let page = fs::read_to_string(repository().join("docs/samples.md")).unwrap();
    for node in ["nav_path_markers", "turret_aim", "line_of_sight"] {
        let help = String::from_utf8(Command::new(program(node)).arg("--help").output().unwrap().stdout).unwrap();
        let mut found = Vec::new();
        let rows = rows(&page, &format!("### `{node}`"));
        for row in &rows {
            let [names, _, written, ..] = &**row else { panic!("{node}: {row:?}") };
            let name = *values(names).last().unwrap();
            let default = expected_default(&help, name);
            let default: Vec<&str> = default.split_whitespace().collect();
            assert_eq!(written.replace('`', ""), default.join(" "), "{node} {name}, in docs/samples.md");
            found.push(name);
        }
        let mut expected: Vec<&str> = options_of(&help).filter(|option| *option != "--version").collect();
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, expected, "{node}: the table of docs/samples.md and --help have different arguments");
    }
}

#[test]
fn every_argument_of_projector_calibrate_is_in_a_table_with_its_default() {
    let page = fs::read_to_string(repository().join("docs/calibration.md")).unwrap();
    let program = program("projector_calibrate");
    let help = |arguments: &[&str]| {
        String::from_utf8(Command::new(&program).args(arguments).output().unwrap().stdout).unwrap()
    };
    let all = help(&["--help"]);
    let commands = all.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let commands: Vec<&str> = commands.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.contains(&"verify") && commands.len() >= 8, "{commands:?}");
    for command in commands.into_iter().filter(|command| *command != "help") {
        let help = help(&[command, "--help"]);
        let mut expected: Vec<&str> = places_of(&help).into_iter().chain(options_of(&help)).collect();
        let section = format!("### `projector_calibrate {command}");
        assert!(page.contains(&section), "docs/calibration.md has no section {section}`");
        let rows = rows(&page, &section);
        let mut found = Vec::new();
        for row in &rows {
            let [names, _, written, ..] = &**row else { panic!("{command}: {row:?}") };
            let name = *values(names).last().unwrap();
            let default = expected_default(&help, name);
            assert_eq!(written.replace('`', ""), default, "{command} {name}, in docs/calibration.md");
            found.push(name);
        }
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, expected, "{command}: the table of docs/calibration.md and --help have different arguments");
    }
}
