//! Options of a node that are also its private parameters; the command line wins.
//!
//! Option `--some-name` is parameter `~some_name`, parsed like the option. Elements of a list are separated by commas.

use std::ffi::OsString;

use anyhow::anyhow;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, Parser};
use rcs_ros::RosNode;

use crate::lifecycle;

/// The program's arguments, completed by the node's private parameters.
///
/// # Errors
/// The parameter whose value is invalid or conflicts with another option.
pub fn with_parameters<A: Parser>(node: &RosNode) -> anyhow::Result<A> {
    merged(&lifecycle::own_arguments(), &|name| Ok(node.text_param(name)?))
}

/// `given` must be valid by itself; `parameter` returns the text of a parameter that is set.
fn merged<A: Parser>(
    given: &[OsString],
    parameter: &dyn Fn(&str) -> anyhow::Result<Option<String>>,
) -> anyhow::Result<A> {
    let command = A::command();
    let matches = command.clone().try_get_matches_from(given).map_err(|error| anyhow!(reason(&error)))?;
    let mut all = given.to_vec();
    for argument in command.get_arguments() {
        let Some(option) = argument.get_long() else { continue };
        if matches.value_source(argument.get_id().as_str()) == Some(ValueSource::CommandLine) {
            continue;
        }
        let name = format!("~{}", option.replace('-', "_"));
        let Some(text) = parameter(&name)? else { continue };
        let Some(word) = as_option(argument, option, &text).map_err(|reason| anyhow!("parameter {name}: {reason}"))?
        else {
            continue;
        };
        // One by one, so that the error names the parameter.
        let checked = A::try_parse_from(given.iter().chain([&word]));
        checked.map_err(|error| anyhow!("parameter {name}: {}", reason(&error)))?;
        all.push(word);
    }
    A::try_parse_from(all).map_err(|error| anyhow!("parameters: {}", reason(&error)))
}

/// A parameter as a command-line argument; `None` for a flag that is false.
fn as_option(argument: &Arg, option: &str, text: &str) -> anyhow::Result<Option<OsString>> {
    if !matches!(argument.get_action(), ArgAction::SetTrue) {
        return Ok(Some(format!("--{option}={text}").into()));
    }
    Ok(yes_or_no(text).map_err(|error| anyhow!(error))?.then(|| format!("--{option}").into()))
}

/// Parses a boolean parameter in any case.
pub fn yes_or_no(text: &str) -> Result<bool, String> {
    match text.to_ascii_lowercase().as_str() {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => Err(format!("{text} is not true or false")),
    }
}

/// First line of an error, without `error: `.
fn reason(error: &clap::Error) -> String {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default();
    first.strip_prefix("error: ").unwrap_or(first).to_owned()
}

/// A clap value parser of numbers within bounds.
pub fn within(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
        let is_within = (least..=most).contains(&number);
        is_within.then_some(number).ok_or_else(|| format!("not from {least} to {most}"))
    }
}

/// Parses a colour as rviz's configs write it, for clap.
pub fn color(text: &str) -> Result<[u8; 3], String> {
    rcs_rviz_config::color(text).ok_or_else(|| "not 'r; g; b' from 0 to 255, '#rrggbb' or a name".to_owned())
}

/// Colour and opacity of a marker.
pub fn rgba([r, g, b]: [u8; 3], alpha: f64) -> [f32; 4] {
    let channel = |value: u8| f32::from(value) / 255.0;
    [channel(r), channel(g), channel(b), alpha as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Parser, Debug, PartialEq)]
    struct Options {
        #[arg(long, default_value_t = 1.0, value_parser = within(0.0, 5.0))]
        rate_hz: f64,
        #[arg(long, conflicts_with = "rate_hz")]
        once: bool,
        #[arg(long)]
        topic: Option<String>,
    }

    fn options(given: &[&str], parameters: &[(&str, &str)]) -> Result<Options, String> {
        let given: Vec<OsString> = std::iter::once("node").chain(given.iter().copied()).map(OsString::from).collect();
        let text = |name: &str| parameters.iter().find(|(known, _)| *known == name).map(|(_, text)| (*text).to_owned());
        merged(&given, &|name| Ok(text(name))).map_err(|error| error.to_string())
    }

    #[test]
    fn the_command_line_wins_and_parameters_fill_what_it_leaves() {
        let read = options(&["--topic", "/a"], &[("~topic", "/b"), ("~rate_hz", "2.5")]).unwrap();
        assert_eq!(read, Options { rate_hz: 2.5, once: false, topic: Some("/a".to_owned()) });
        assert!(options(&[], &[("~once", "true")]).unwrap().once);
        assert!(!options(&["--rate-hz", "2"], &[("~once", "False")]).unwrap().once);
    }

    #[test]
    fn colours_are_those_of_rviz_configs() {
        assert_eq!(color("255; 0; 10"), Ok([255, 0, 10]));
        assert_eq!(color("#3399ff"), Ok([0x33, 0x99, 0xff]));
        assert!(color("300; 0; 0").is_err() && color("reddish").is_err());
    }

    #[test]
    fn a_wrong_parameter_is_named() {
        let error = options(&[], &[("~rate_hz", "9")]).unwrap_err();
        assert_eq!(error, "parameter ~rate_hz: invalid value '9' for '--rate-hz <RATE_HZ>': not from 0 to 5");
        assert_eq!(options(&[], &[("~once", "often")]).unwrap_err(), "parameter ~once: often is not true or false");
        let error = options(&["--rate-hz", "2"], &[("~once", "1")]).unwrap_err();
        assert!(error.starts_with("parameter ~once: the argument"), "{error}");
    }
}
