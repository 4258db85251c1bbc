//! `launch-files.md`: what each launch file starts, and its arguments.

use std::fs;

use roxmltree::{Document, Node};

use crate::markdown::{code, generated, head, row, text};
use crate::repository;

const INTRODUCTION: &str = "# Launch files

Start one with `roslaunch rviz_camera_stream FILE [ARGUMENT:=VALUE …]`; `roslaunch --ros-args rviz_camera_stream FILE` lists the
arguments. Give files as absolute paths or with `$(find PACKAGE)/…`: nodes start in `~/.ros`. Defaults without a slash in front are
in this package. [Nodes](nodes.md) explains what is behind an argument.
";

/// Files in the order of the page.
const FILES: [&str; 7] = ["projection", "fetch", "two_projectors", "arm", "paper", "rehearsal", "demo"];

/// An argument of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Argument {
    name: String,
    default: String,
    doc: String,
}

/// A launch file.
struct LaunchFile {
    name: &'static str,
    /// Paragraphs of its first comment: a text, and often commands.
    comment: Vec<String>,
    arguments: Vec<Argument>,
}

/// The page.
pub(crate) fn page() -> String {
    let files = FILES.map(read);
    let mut known: Vec<String> = fs::read_dir(repository().join("launch"))
        .expect("the launch files are there")
        .filter_map(|entry| entry.expect("an entry").file_name().into_string().ok())
        .filter_map(|name| name.strip_suffix(".launch").map(str::to_owned))
        .collect();
    known.sort_unstable();
    let mut listed = FILES.map(str::to_owned).to_vec();
    listed.sort_unstable();
    assert_eq!(known, listed, "the launch files of the page");
    let mut text = generated() + INTRODUCTION + &shared_table(&files);
    for file in &files {
        text += &section(file, &files);
    }
    text
}

fn read(name: &'static str) -> LaunchFile {
    let path = repository().join("launch").join(name).with_extension("launch");
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let document = Document::parse(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let comment = document.root().children().find(Node::is_comment).and_then(|node| node.text()).unwrap_or_default();
    let comment = comment.trim_start_matches('\n').split("\n\n").map(str::to_owned).collect();
    let arguments = document.root_element().children().filter(|node| node.has_tag_name("arg"));
    let arguments = arguments
        .map(|node| {
            let of = |key: &str| node.attribute(key).unwrap_or_default().to_owned();
            let default = of("default").replace("$(find rviz_camera_stream)/", "");
            let default = default.replace("find('rviz_camera_stream') + '/", "'");
            Argument { name: of("name"), default, doc: of("doc") }
        })
        .collect();
    LaunchFile { name, comment, arguments }
}

/// The files that have an argument with this explanation.
fn files_with<'a>(files: &'a [LaunchFile], argument: &Argument) -> Vec<&'a LaunchFile> {
    let has = |file: &&LaunchFile| {
        file.arguments.iter().any(|other| other.name == argument.name && other.doc == argument.doc)
    };
    files.iter().filter(has).collect()
}

/// The arguments that several files have, once.
fn shared_table(files: &[LaunchFile]) -> String {
    let mut table = "\n## Arguments of several files\n\n".to_owned() + &head(&["argument", "default", "", "files"]);
    let mut written: Vec<(&str, &str)> = Vec::new();
    for argument in files.iter().flat_map(|file| &file.arguments) {
        let having = files_with(files, argument);
        if having.len() < 2 || written.contains(&(&argument.name, &argument.doc)) {
            continue;
        }
        written.push((&argument.name, &argument.doc));
        let of = |file: &LaunchFile| {
            let own = file.arguments.iter().find(|other| other.name == argument.name);
            own.map(|own| own.default.clone()).unwrap_or_default()
        };
        let is_same = having.iter().all(|file| of(file) == argument.default);
        let default = if is_same { value(&argument.default) } else { "see the file".to_owned() };
        let names: Vec<&str> = having.iter().map(|file| file.name).collect();
        let names = if names.len() == files.len() { "all".to_owned() } else { names.join(", ") };
        table += &row(&[code(&argument.name), default, text(&argument.doc), names]);
    }
    table
}

/// A default.
fn value(default: &str) -> String {
    if default.is_empty() {
        "empty".to_owned()
    } else {
        code(default)
    }
}

/// Section of a launch file: its nodes, its call, and the arguments that it alone has or with another default.
fn section(file: &LaunchFile, files: &[LaunchFile]) -> String {
    let mut section = format!("\n## `{}.launch`\n", file.name);
    let mut paragraphs = file.comment.iter();
    section += &format!("\n{}\n", text(paragraphs.next().map_or("", String::as_str)));
    // Commands are indented deeper than text.
    if let Some(commands) = paragraphs.next().filter(|paragraph| paragraph.starts_with("    ")) {
        section += &format!("\n{}\n", commands.trim_end());
    }
    let mut rows = String::new();
    for argument in &file.arguments {
        let shared = files_with(files, argument);
        let differs = |other: &&LaunchFile| {
            !other.arguments.iter().any(|it| it.name == argument.name && it.default == argument.default)
        };
        if shared.len() < 2 {
            rows += &row(&[code(&argument.name), value(&argument.default), text(&argument.doc)]);
        } else if shared.iter().any(differs) {
            rows += &row(&[code(&argument.name), value(&argument.default), "see above".to_owned()]);
        }
    }
    if !rows.is_empty() {
        section += &format!("\n{}{rows}", head(&["argument", "default", ""]));
    }
    section
}
