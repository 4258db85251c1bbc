//! `nodes.md`: topics and services of all programs, options and parameters of the nodes.

use clap::{Arg, ArgAction, Command};
use rcs_app::all_programs::{Program, PROGRAMS};
use rcs_node_support::node_options::parameter_of;

use crate::markdown::{code, generated, head, row, text};

const INTRODUCTION: &str = "# Nodes and programs

Start a program with `rosrun rviz_camera_stream PROGRAM`, or from a launch file. The options of commands are in their
`--help` and man pages (`man projector_calibrate-scan`).

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
    PROGRAMS.iter().fold(generated() + INTRODUCTION, |page, program| page + &section(program))
}

fn section(program: &Program) -> String {
    let mut command = (program.command)();
    command.build();
    let mut section = format!("\n## `{}`\n\n{}", program.name, about(&command));
    if !program.ros_names.is_empty() {
        section += "\n";
        section += &head(&["", "name", "type", ""]);
    }
    for name in program.ros_names {
        let with_words = |name: &str| if name.contains(' ') { name.to_owned() } else { code(name) };
        let names: Vec<String> = name.name.split(", ").map(with_words).collect();
        section += &row(&[name.usage.word().to_owned(), names.join(", "), text(name.kind), text(name.note)]);
    }
    if program.has_parameters {
        section += &options(&command);
    }
    let commands = command.get_subcommands().filter(|inner| inner.get_name() != "help");
    let commands: String =
        commands.map(|inner| row(&[code(inner.get_name()), about(inner).trim().to_owned()])).collect();
    if commands.is_empty() {
        return section;
    }
    section + "\n" + &head(&["command", ""]) + &commands
}

/// The table of a node's options.
fn options(command: &Command) -> String {
    let shown = command.get_arguments().filter(|arg| !arg.is_hide_set() && !is_clap_s_own(arg));
    let rows = shown.map(|arg| {
        let [option, default, help] = cells(arg);
        let parameter = parameter_of(arg).map_or_else(String::new, |name| format!("`~{name}`"));
        row(&[option, parameter, default, help])
    });
    format!("\n{}{}", head(&["option", "parameter", "default", ""]), rows.collect::<String>())
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
fn cells(arg: &Arg) -> [String; 3] {
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
    [names.join(", "), default, text(&(help + &rest.unwrap_or_default())) + &possible_values(arg)]
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
