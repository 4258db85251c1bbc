//! Arguments of rviz's command line that clap does not take as rviz does.
//!
//! `QApplication` first takes Qt's arguments away, each with one dash or two. Boost.program_options then takes the
//! beginning of an option for the option if only one begins so. Source: rviz's `visualizer_app.cpp`, the page
//! *QGuiApplication* of Qt 5 and its xcb plugin.

use std::collections::HashSet;
use std::ffi::OsString;

use clap::CommandFactory;

use crate::cli::Cli;

/// rviz's options.
const RVIZ: [&str; 13] = [
    "help",
    "splash-screen",
    "help-file",
    "display-config",
    "fullscreen",
    "fixed-frame",
    "ogre-log",
    "in-mc-wrapper",
    "opengl",
    "disable-anti-aliasing",
    "no-stereo",
    "verbose",
    "log-level-debug",
];

/// Qt's arguments with a value, which is the next word or behind `=`.
const QT_WITH_VALUE: [&str; 15] = [
    "platform",
    "platformpluginpath",
    "platformtheme",
    "plugin",
    "qwindowgeometry",
    "geometry",
    "qwindowtitle",
    "title",
    "qwindowicon",
    "icon",
    "display",
    "name",
    "session",
    "style",
    "stylesheet",
];

/// Qt's arguments without a value.
const QT_ALONE: [&str; 6] = ["reverse", "nograb", "dograb", "sync", "widgetcount", "qmljsdebugger"];

/// The program's words with rviz's options in full and without Qt's arguments, and the latter.
pub(crate) fn understood(words: Vec<OsString>) -> (Vec<OsString>, Vec<String>) {
    let command = Cli::command();
    let all = std::iter::once(&command).chain(command.get_subcommands());
    let own: HashSet<&str> = all.flat_map(clap::Command::get_arguments).filter_map(clap::Arg::get_long).collect();
    let (mut kept, mut of_qt, mut words) = (Vec::new(), Vec::new(), words.into_iter());
    kept.extend(words.next());
    while let Some(word) = words.next() {
        let text = word.to_string_lossy().into_owned();
        match Word::of(&text, &own) {
            Word::Other => kept.push(word),
            Word::Rviz(in_full) => kept.push(in_full.into()),
            Word::Qt { takes_next: false } => of_qt.push(text),
            Word::Qt { takes_next: true } => {
                let value = words.next().unwrap_or_default();
                of_qt.push(format!("{text} {}", value.to_string_lossy()));
            }
        }
    }
    (kept, of_qt)
}

/// A word of the command line.
enum Word {
    /// An option of rviz in full.
    Rviz(String),
    /// An argument of Qt.
    Qt { takes_next: bool },
    /// Any other.
    Other,
}

impl Word {
    /// `own` are the options of this program, rviz's among them.
    fn of(text: &str, own: &HashSet<&str>) -> Self {
        let Some(short) = text.strip_prefix('-') else { return Self::Other };
        let long = short.strip_prefix('-');
        let (name, value) = match long.unwrap_or(short).split_once('=') {
            Some((name, value)) => (name, Some(value)),
            None => (long.unwrap_or(short), None),
        };
        if name.is_empty() || long.is_some() && own.contains(name) {
            return Self::Other;
        }
        let has_value = QT_WITH_VALUE.contains(&name);
        if has_value || QT_ALONE.contains(&name) {
            return Self::Qt { takes_next: has_value && value.is_none() };
        }
        let mut known = RVIZ.iter().filter(|known| long.is_some() && known.starts_with(name));
        match (known.next(), known.next()) {
            (Some(only), None) => Self::Rviz(value.map_or(format!("--{only}"), |value| format!("--{only}={value}"))),
            _ => Self::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    fn read(line: &str) -> (String, String) {
        let words = std::iter::once("camera_stream").chain(line.split_whitespace());
        let (kept, of_qt) = understood(words.map(OsString::from).collect());
        let kept: Vec<_> = kept.iter().skip(1).map(|word| word.to_string_lossy()).collect();
        (kept.join(" "), of_qt.join(", "))
    }

    #[test]
    fn the_beginning_of_one_of_rvizs_options_is_the_option() {
        for (given, in_full) in [
            ("--disp x.rviz", "--display-config x.rviz"),
            ("--display-c=x.rviz", "--display-config=x.rviz"),
            ("--fixed=map --full", "--fixed-frame=map --fullscreen"),
            ("--s splash.png --no", "--splash-screen splash.png --no-stereo"),
            ("--log -d x.rviz", "--log-level-debug -d x.rviz"),
            // As they are: in full, another's, of two, of none, no option.
            ("--fixed-frame map", "--fixed-frame map"),
            ("--no-watch --window auto --mask-t /m", "--no-watch --window auto --mask-t /m"),
            ("--f map --d x.rviz --o", "--f map --d x.rviz --o"),
            ("--nope -dx.rviz -", "--nope -dx.rviz -"),
            ("new-camera --name x --at -5", "new-camera --name x --at -5"),
        ] {
            assert_eq!(read(given), (in_full.to_owned(), String::new()), "{given}");
        }
        let cli = Cli::try_parse_from(["camera_stream", "-dx.rviz", "--fixed-frame=map"]).unwrap();
        assert_eq!(cli.node.display_config.as_deref(), Some(std::path::Path::new("x.rviz")));
    }

    #[test]
    fn every_option_of_rviz_is_one_here() {
        let command = Cli::command();
        let longs: Vec<_> = command.get_arguments().filter_map(clap::Arg::get_long).chain(["help"]).collect();
        assert!(RVIZ.iter().all(|option| longs.contains(option)), "{longs:?}");
    }

    #[test]
    fn qts_arguments_are_left_out_and_told() {
        let line =
            "-platform offscreen --display :0 -d x.rviz -style=x -geometry 10x10+0+0 --qwindowtitle t -reverse -f map";
        let of_qt = "-platform offscreen, --display :0, -style=x, -geometry 10x10+0+0, --qwindowtitle t, -reverse";
        assert_eq!(read(line), ("-d x.rviz -f map".to_owned(), of_qt.to_owned()));
        assert_eq!(read("-d x.rviz -title").1, "-title ");
    }
}
