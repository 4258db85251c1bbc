//! `nodes.md`: options, parameters, topics and services of all programs.

use std::collections::BTreeMap;

use clap::{Arg, ArgAction, Command};
use rcs_app::all_programs::{Program, PROGRAMS};
use rcs_node_support::node_options::parameter_of;

use crate::markdown::{code, generated, head, row, text};

const INTRODUCTION: &str = "# Nodes and programs

Start a program with `rosrun rviz_camera_stream PROGRAM`, or from a launch file. `--help` says more about each.

- **Parameters.** An option of a node is also a private parameter; the command line wins. `none` is no value. A switch `--x` is
  `~x: true`, `--no-x` is `~x: false`; each has its opposite. A repeatable option is a list: `--keep-out head=0.25` is
  `~keep_out: [{frame: head, radius: 0.25}]`. A node warns about a parameter whose name is almost an option's.
- **ROS arguments.** Nodes take `from:=to`, `_param:=value`, `__name:=`, `__ns:=` and `__log:=`. They wait for the master, log on
  `/rosout`, follow `/clock` with `/use_sim_time`, and offer `~set_logger_level` and `~get_loggers`.
- **Exit status.** 0: success; nodes also after SIGINT, SIGTERM or `rosnode kill`. 1: failure or refusal; for `check` and `doctor`
  a finding. 2: invalid arguments or an unreadable file; for `check --live` and `doctor` also no master.
- **Names** of topics are the defaults; options or remappings change them. Words in capitals stand for others: IMAGE, INFO and
  NAMESPACE are a CameraPub's *Image Topic*, *Camera Info Topic* and *Display namespace*.
";

/// The page.
pub(crate) fn page() -> String {
    let mut page = Page { text: generated() + INTRODUCTION, ..Page::default() };
    for program in &PROGRAMS {
        let mut command = (program.command)();
        command.build();
        page.program(program, &command);
    }
    page.text
}

/// The page as far as it is written.
#[derive(Default)]
struct Page {
    text: String,
    /// Rows that are in a table already, and the command that has it.
    written: BTreeMap<Vec<String>, String>,
}

impl Page {
    fn program(&mut self, program: &Program, command: &Command) {
        self.text += &format!("\n## `{}`\n\n{}", program.name, about(command));
        if !program.ros_names.is_empty() {
            self.text += "\n";
            self.text += &head(&["", "name", "type", ""]);
        }
        for name in program.ros_names {
            let with_words = |name: &str| if name.contains(' ') { name.to_owned() } else { code(name) };
            let names: Vec<String> = name.name.split(", ").map(with_words).collect();
            self.text += &row(&[name.usage.word().to_owned(), names.join(", "), text(name.kind), text(name.note)]);
        }
        self.options(program.name, command, program.has_parameters);
        for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
            let path = format!("{} {}", program.name, inner.get_name());
            self.text += &format!("\n### `{path}`\n\n{}", about(inner));
            self.options(&path, inner, false);
        }
    }

    /// The table of a command's options. Those that another command has in the same way are only named.
    fn options(&mut self, path: &str, command: &Command, has_parameters: bool) {
        let shown = command.get_arguments().filter(|arg| !arg.is_hide_set() && !is_clap_s_own(arg));
        let mut rows = String::new();
        let mut elsewhere: Vec<(String, Vec<String>)> = Vec::new();
        for arg in shown {
            let cells = cells(arg);
            if let Some(other) = self.written.get(&cells) {
                let name = code(&arg.get_long().map_or_else(|| value_names(arg), |long| format!("--{long}")));
                match elsewhere.iter_mut().find(|(of, _)| of == other) {
                    Some((_, names)) => names.push(name),
                    None => elsewhere.push((other.clone(), vec![name])),
                }
                continue;
            }
            self.written.insert(cells.clone(), path.to_owned());
            let [option, default, help] = cells.as_slice() else { continue };
            let parameter = parameter_of(arg).map_or_else(String::new, |name| format!("`~{name}`"));
            rows += &match has_parameters {
                true => row(&[option.clone(), parameter, default.clone(), help.clone()]),
                false => row(&cells),
            };
        }
        if !rows.is_empty() {
            let names: &[&str] = match has_parameters {
                true => &["option", "parameter", "default", ""],
                false => &["option", "default", ""],
            };
            self.text += &format!("\n{}{rows}", head(names));
        }
        for (other, names) in elsewhere {
            let link = format!("[`{other}`](#{})", other.replace(' ', "-"));
            let is_all = self.written.values().filter(|of| **of == other).count() == names.len();
            self.text += &match is_all {
                true => format!("\nAnd all options of {link}.\n"),
                false => format!("\nAs for {link}: {}.\n", names.join(", ")),
            };
        }
    }
}

/// Summary of a command, in a sentence.
fn about(command: &Command) -> String {
    let about = text(&command.get_about().map(ToString::to_string).unwrap_or_default());
    format!("{}.\n", about.trim_end_matches('.'))
}

fn is_clap_s_own(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Help | ArgAction::HelpShort | ArgAction::HelpLong | ArgAction::Version)
}

/// Names of an option's values as its help has them.
fn value_names(arg: &Arg) -> String {
    let names = arg.get_value_names().unwrap_or_default();
    let names: Vec<&str> = names.iter().map(clap::builder::Str::as_str).collect();
    let names = if names.is_empty() { arg.get_id().as_str().to_ascii_uppercase() } else { names.join(" ") };
    let values = arg.get_num_args().unwrap_or_default();
    let optional = if values.min_values() == 0 { format!("[{names}]") } else { names };
    if values.max_values() > 1 {
        optional + "…"
    } else {
        optional
    }
}

/// The option with its value, its default, and its help.
fn cells(arg: &Arg) -> Vec<String> {
    let takes_values = arg.get_action().takes_values();
    let mut names = Vec::new();
    names.extend(arg.get_short().map(|short| format!("`-{short}`")));
    names.extend(arg.get_long().map(|long| match takes_values {
        true => code(&format!("--{long} {}", value_names(arg))),
        false => format!("`--{long}`"),
    }));
    if names.is_empty() {
        names.push(code(&value_names(arg)));
    }
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    let (help, in_words) = match help.split_once(" [default: ") {
        Some((help, default)) => {
            (help.to_owned(), default.split_once(']').map(|(default, rest)| (default.to_owned(), rest.to_owned())))
        }
        None => (help, None),
    };
    let (in_words, rest) = in_words.unzip();
    let defaults: Vec<String> = arg.get_default_values().iter().map(|value| code(&value.to_string_lossy())).collect();
    let default = match (in_words, &*defaults) {
        (Some(words), _) => text(&words),
        (None, [_, ..]) if takes_values && !arg.is_hide_default_value_set() => defaults.join(", "),
        _ if arg.is_required_set() => "required".to_owned(),
        _ if takes_values => "none".to_owned(),
        _ => "off".to_owned(),
    };
    vec![names.join(", "), default, text(&(help + &rest.unwrap_or_default())) + &possible_values(arg)]
}

/// Values of a choice that the help does not name.
fn possible_values(arg: &Arg) -> String {
    let given = value_names(arg);
    let values = arg.get_possible_values();
    let values = values.iter().filter(|value| !value.is_hide_set() && !given.contains(value.get_name()));
    let values: Vec<String> = values.map(|value| code(value.get_name())).collect();
    if values.is_empty() || !arg.get_action().takes_values() {
        return String::new();
    }
    format!(" ({})", values.join(", "))
}
