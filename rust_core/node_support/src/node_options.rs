//! Options of a node: its command line, and its private parameters for what that leaves open.
//!
//! An option `--some-name` of a program's clap definition is also the parameter `~some_name`. What a parameter holds
//! becomes words of the command line, so that one definition and one parser are for both:
//!
//! | parameter | words |
//! |---|---|
//! | `rate: 2.5` | `--rate=2.5` |
//! | `undistort: true`, `undistort: false` | `--undistort`, `--no-undistort` |
//! | `mesh_folder: [/a, /b]` | `--mesh-folder=/a --mesh-folder=/b`; of an option that is given once, `--pixel=1,2` |
//! | `keep_out: [{frame: head, radius: 0.2}]` | `--keep-out=head=0.2`, whose value is declared as `FRAME=RADIUS` |
//!
//! Hidden options and those under [`COMMAND_LINE_ONLY`] are no parameters.

use std::collections::HashSet;
use std::ffi::OsString;

use anyhow::anyhow;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command, Parser};
use rcs_ros::{ParameterValue, Parameters, RosNode};

use crate::lifecycle;

/// The heading in a program's help of options that are no parameters.
pub const COMMAND_LINE_ONLY: &str = "Only on the command line";

/// An option's value that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("invalid value '{value}' for {option}: {reason}")]
pub struct InvalidOption {
    option: String,
    value: String,
    reason: String,
}

impl InvalidOption {
    /// `option` is the option, or the parameter that gave it.
    pub fn new(option: &str, value: &str, reason: impl Into<String>) -> Self {
        Self { option: option.to_owned(), value: value.to_owned(), reason: reason.into() }
    }
}

/// A program's arguments, with the node's private parameters for the options that are not among them.
#[derive(Debug)]
pub struct NodeOptions<A> {
    /// The arguments.
    pub arguments: A,
    /// All of them as they would stand on the command line.
    pub command_line: String,
    /// Options, without dashes, whose value is a parameter's.
    from_parameters: HashSet<String>,
}

impl<A> NodeOptions<A> {
    /// Name of an option in errors: `--mask-topic`, or `~mask_topic` where the parameter has given it.
    pub fn name_of(&self, option: &str) -> String {
        if self.from_parameters.contains(option) {
            format!("~{}", option.replace('-', "_"))
        } else {
            format!("--{option}")
        }
    }
}

/// The process's arguments, with the parameters of its node. Parameters that look like misspelt ones are warned about.
///
/// # Errors
/// When a parameter has no valid value, or does not go with another option; names it.
pub fn with_parameters<A: Parser>(node: &RosNode) -> anyhow::Result<A> {
    Ok(merge(&lifecycle::own_arguments(), node.parameters())?.arguments)
}

/// `words`, the program's name first, with parameters behind them. `words` are valid by themselves.
///
/// # Errors
/// When a parameter has no valid value, or does not go with another option; names it.
pub fn merge<A: Parser>(words: &[OsString], parameters: &Parameters) -> anyhow::Result<NodeOptions<A>> {
    let mut root = A::command();
    root.build();
    let matches = root.clone().try_get_matches_from(words).map_err(|error| anyhow!(reason(&error)))?;
    let (command, matches) = innermost(&root, &matches);
    let options: Vec<NodeOption<'_>> = command.get_arguments().filter_map(NodeOption::of).collect();
    let (mut all, mut added) = (words.to_vec(), Vec::new());
    for (name, value) in parameters {
        let Some(option) = options.iter().find(|option| option.parameter == *name) else {
            if let Some(warning) = near_miss(name, value, &options) {
                log::warn!("{warning}");
            }
            continue;
        };
        if option.is_in(matches, command) {
            continue;
        }
        let given = option.words(value);
        all.extend(given.map_err(|reason| InvalidOption::new(&format!("~{name}"), &value.to_string(), reason))?);
        added.push(option);
    }
    let named = |error: clap::Error| {
        let in_parameters = |text: String, option: &&NodeOption<'_>| {
            text.replace(&format!("'{}'", option.arg), &format!("~{}", option.parameter))
        };
        anyhow!(added.iter().fold(reason(&error), in_parameters))
    };
    let arguments = A::try_parse_from(&all).map_err(named)?;
    let command_line: Vec<_> = all.iter().skip(1).map(|word| word.to_string_lossy()).collect();
    let from_parameters = added.iter().map(|option| option.long.to_owned()).collect();
    Ok(NodeOptions { arguments, command_line: command_line.join(" "), from_parameters })
}

/// The names of a program's parameters.
pub fn parameter_names<A: Parser>() -> Vec<String> {
    A::command().get_arguments().filter_map(parameter_of).collect()
}

/// Name of the private parameter that an option is too, without `~`.
pub fn parameter_of(arg: &Arg) -> Option<String> {
    NodeOption::of(arg).map(|option| option.parameter)
}

/// The subcommand that is given, else the command itself.
fn innermost<'c>(command: &'c Command, matches: &'c ArgMatches) -> (&'c Command, &'c ArgMatches) {
    match matches.subcommand() {
        Some((name, matches)) => {
            command.find_subcommand(name).map_or((command, matches), |found| innermost(found, matches))
        }
        None => (command, matches),
    }
}

/// A warning of a parameter that nobody reads and whose name is almost an option's. Structs are namespaces: of
/// dynamic_reconfigure's servers, and of what else launch files put below a node.
fn near_miss(name: &str, value: &ParameterValue, options: &[NodeOption<'_>]) -> Option<String> {
    let distance = |option: &NodeOption<'_>| strsim::osa_distance(&name.replace('-', "_"), &option.parameter);
    let nearest = options.iter().min_by_key(|option| distance(option))?;
    let is_near = distance(nearest) <= nearest.parameter.len() / 4 && !matches!(value, ParameterValue::Struct(_));
    is_near.then(|| format!("unknown parameter ~{name}; did you mean ~{}?", nearest.parameter))
}

fn is_switch(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::SetTrue | ArgAction::SetFalse)
}

/// An option that is also a parameter.
struct NodeOption<'c> {
    arg: &'c Arg,
    long: &'c str,
    /// The parameter's name; that of `--no-x` is `x`.
    parameter: String,
}

impl<'c> NodeOption<'c> {
    fn of(arg: &'c Arg) -> Option<Self> {
        let long = arg.get_long()?;
        let is_switch = is_switch(arg);
        let is_parameter = (is_switch || arg.get_action().takes_values())
            && !arg.is_hide_set()
            && arg.get_help_heading() != Some(COMMAND_LINE_ONLY);
        let name = if is_switch { long.strip_prefix("no-").unwrap_or(long) } else { long };
        is_parameter.then(|| Self { arg, long, parameter: name.replace('-', "_") })
    }

    /// Whether the command line gives the option, its opposite, or in its place an argument `FILE` for `--file`.
    fn is_in(&self, matches: &ArgMatches, command: &Command) -> bool {
        let is_same = |other: &Arg| match other.get_long() {
            Some(long) => long.strip_prefix("no-").unwrap_or(long) == self.parameter.replace('_', "-"),
            None => other.get_value_names().is_some_and(|names| *names == [self.parameter.to_ascii_uppercase()]),
        };
        let is_given = |arg: &Arg| matches.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine);
        command.get_arguments().any(|arg| (arg == self.arg || is_same(arg)) && is_given(arg))
    }

    /// A parameter's value as words of the command line.
    fn words(&self, value: &ParameterValue) -> Result<Vec<OsString>, String> {
        if is_switch(self.arg) {
            let is_on = yes_or_no(&value.to_string())?;
            let option = self.parameter.replace('_', "-");
            return Ok(vec![format!("--{}{option}", if is_on { "" } else { "no-" }).into()]);
        }
        let elements = match value {
            ParameterValue::Array(elements) if matches!(self.arg.get_action(), ArgAction::Append) => {
                elements.as_slice()
            }
            value => std::slice::from_ref(value),
        };
        elements.iter().map(|element| Ok(format!("--{}={}", self.long, self.text(element)?).into())).collect()
    }

    /// The text of one element.
    fn text(&self, element: &ParameterValue) -> Result<String, String> {
        let Some([key, value]) = self.fields() else {
            return element.text().ok_or_else(|| "not a text, number or list".to_owned());
        };
        let ParameterValue::Struct(members) = element else {
            return element.text().ok_or_else(|| format!("not a list of {{{key}, {value}}}"));
        };
        let text = |name: &str| members.get(name).and_then(ParameterValue::text);
        let has_others = members.keys().any(|name| *name != key && *name != value);
        match (text(&key).unwrap_or_default(), text(&value)) {
            (key, Some(value)) if key.is_empty() && !has_others => Ok(value),
            (key, Some(value)) if !has_others => Ok(format!("{key}={value}")),
            _ => Err(format!("not {{{key}: …, {value}: …}}")),
        }
    }

    /// The fields of a parameter's struct, where the value is declared as `FRAME=RADIUS` or `[CAMERA=]FILE.png`.
    fn fields(&self) -> Option<[String; 2]> {
        let (key, value) = self.arg.get_value_names()?.first()?.split_once('=')?;
        let value = value.split('.').next().unwrap_or_default();
        Some([key, value].map(|name| name.trim_matches(['[', ']']).to_ascii_lowercase()))
    }
}

/// Reads a parameter's true or false, which YAML has other words and capitals for.
fn yes_or_no(text: &str) -> Result<bool, String> {
    match text.to_ascii_lowercase().as_str() {
        "true" | "yes" | "on" | "1" => Ok(true),
        "false" | "no" | "off" | "0" => Ok(false),
        _ => Err("neither true nor false".to_owned()),
    }
}

/// An error of clap in one line.
fn reason(error: &clap::Error) -> String {
    let text = error.to_string();
    let lines: Vec<&str> = text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect();
    let text = lines.join(" ");
    text.strip_prefix("error: ").unwrap_or(&text).to_owned()
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
    use clap::CommandFactory;

    use super::*;

    #[derive(Parser, Debug, PartialEq)]
    struct Options {
        #[arg(long, default_value_t = 1.0, value_parser = within(0.0, 5.0))]
        rate_hz: f64,
        #[arg(long, conflicts_with = "rate_hz")]
        once: bool,
        #[arg(long, hide = true, overrides_with = "once")]
        no_once: bool,
        #[arg(long)]
        topic: Option<String>,
        #[arg(long, value_name = "[CAMERA=]FILE.png")]
        mask: Vec<String>,
        #[arg(long = "no-lazy", action = ArgAction::SetFalse)]
        is_lazy: bool,
        #[arg(long, hide = true, overrides_with = "is_lazy")]
        lazy: bool,
        #[arg(long, help_heading = COMMAND_LINE_ONLY)]
        debug: bool,
    }

    fn text(text: &str) -> ParameterValue {
        text.into()
    }

    fn merged(given: &[&str], parameters: &[(&str, ParameterValue)]) -> Result<NodeOptions<Options>, String> {
        let given: Vec<OsString> = std::iter::once("node").chain(given.iter().copied()).map(OsString::from).collect();
        let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        merge(&given, &parameters).map_err(|error| error.to_string())
    }

    fn options(given: &[&str], parameters: &[(&str, ParameterValue)]) -> Result<Options, String> {
        Ok(merged(given, parameters)?.arguments)
    }

    #[test]
    fn the_command_line_wins_and_parameters_fill_what_it_leaves() {
        let parameters = [("topic", text("/b")), ("rate_hz", ParameterValue::Double(2.5))];
        let read = merged(&["--topic", "/a"], &parameters).unwrap();
        assert_eq!((read.arguments.rate_hz, read.arguments.topic.as_deref()), (2.5, Some("/a")));
        assert_eq!(read.command_line, "--topic /a --rate-hz=2.5");
        assert_eq!([read.name_of("topic"), read.name_of("rate-hz")], ["--topic", "~rate_hz"]);
        assert!(options(&[], &[("once", ParameterValue::Bool(true))]).unwrap().once);
        assert!(!options(&["--no-once"], &[("once", text("True"))]).unwrap().once);
        assert!(!options(&["--rate-hz", "2"], &[("once", text("False"))]).unwrap().once);
        assert!(!options(&[], &[("lazy", ParameterValue::Bool(false))]).unwrap().is_lazy);
        assert!(options(&[], &[("lazy", ParameterValue::Bool(true))]).unwrap().is_lazy);
        assert!(!options(&["--no-lazy"], &[("lazy", ParameterValue::Bool(true))]).unwrap().is_lazy);
        assert!(!options(&[], &[("debug", ParameterValue::Bool(true))]).unwrap().debug);
    }

    #[test]
    fn an_element_of_a_list_is_a_value_or_a_struct() {
        let fields = |pairs: &[(&str, &str)]| {
            ParameterValue::Struct(pairs.iter().map(|(name, value)| ((*name).to_owned(), text(value))).collect())
        };
        let mask =
            |elements: Vec<ParameterValue>| options(&[], &[("mask", ParameterValue::Array(elements))]).map(|o| o.mask);
        let left = fields(&[("camera", "a=b"), ("file", "/l.png")]);
        assert_eq!(mask(vec![left, text("/all.png")]).unwrap(), ["a=b=/l.png", "/all.png"]);
        assert_eq!(mask(vec![fields(&[("file", "/all.png")])]).unwrap(), ["/all.png"]);
        assert_eq!(mask(Vec::new()), Ok(Vec::new()));
        let error = mask(vec![fields(&[("camera", "a"), ("path", "/l.png")])]).unwrap_err();
        assert_eq!(error, "invalid value '[{camera: a, path: /l.png}]' for ~mask: not {camera: …, file: …}");
    }

    #[test]
    fn colours_are_those_of_rviz_configs() {
        assert_eq!(color("255; 0; 10"), Ok([255, 0, 10]));
        assert_eq!(color("#3399ff"), Ok([0x33, 0x99, 0xff]));
        assert!(color("300; 0; 0").is_err() && color("reddish").is_err());
    }

    #[test]
    fn a_wrong_parameter_is_named() {
        let error = options(&[], &[("rate_hz", ParameterValue::Int(9))]).unwrap_err();
        assert_eq!(error, "invalid value '9' for ~rate_hz: not from 0 to 5");
        let error = options(&[], &[("once", text("often"))]).unwrap_err();
        assert_eq!(error, "invalid value 'often' for ~once: neither true nor false");
        let error = options(&["--rate-hz", "2"], &[("once", ParameterValue::Int(1))]).unwrap_err();
        assert!(error.contains("~once") && error.contains("cannot be used with"), "{error}");
    }

    #[test]
    fn names_that_are_almost_an_options_are_warned_about_and_no_others() {
        let command = Options::command();
        let own: Vec<_> = command.get_arguments().filter_map(NodeOption::of).collect();
        let warning = |name: &str| near_miss(name, &text("x"), &own);
        assert_eq!(warning("rate_hs").as_deref(), Some("unknown parameter ~rate_hs; did you mean ~rate_hz?"));
        assert!(warning("topci").is_some() && warning("rate-hz").is_some());
        // What MoveIt's launch files, tf and roslaunch put below rviz.
        for foreign in
            ["manipulator", "kinematics_solver", "tf_prefix", "robot_description", "target", "enable_statistics"]
        {
            assert_eq!(warning(foreign), None, "{foreign}");
        }
        assert_eq!(near_miss("masks", &ParameterValue::Struct(Parameters::new()), &own), None, "a camera's namespace");
    }
}
