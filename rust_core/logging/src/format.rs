//! Text of a log line by the environment variable `ROSCONSOLE_FORMAT`, like roscpp's.
//!
//! Source: the ROS wiki's page *rosconsole*, section *Console Output Formatting*.

use std::fmt::Write as _;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use log::Level;

/// roscpp's default format.
pub(crate) const DEFAULT: &str = "[${severity}] [${time}]: ${message}";

/// A `${name}` of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Token {
    Severity,
    Message,
    Time,
    WallTime,
    Thread,
    Logger,
    ShortName,
    File,
    Line,
    Function,
    Node,
}

const TOKENS: [(&str, Token); 11] = [
    ("severity", Token::Severity),
    ("message", Token::Message),
    ("time", Token::Time),
    ("walltime", Token::WallTime),
    ("thread", Token::Thread),
    ("logger", Token::Logger),
    ("shortname", Token::ShortName),
    ("file", Token::File),
    ("line", Token::Line),
    ("function", Token::Function),
    ("node", Token::Node),
];

#[derive(Clone, Debug, PartialEq, Eq)]
enum FormatPiece {
    Text(String),
    Token(Token),
}

/// A parsed format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Format(Vec<FormatPiece>);

/// Fields of a log line.
pub(crate) struct LogFields<'a> {
    pub(crate) level: Level,
    pub(crate) text: &'a str,
    pub(crate) wall: SystemTime,
    /// Simulated time, if the node uses it.
    pub(crate) simulated: Option<Duration>,
    pub(crate) logger: &'a str,
    pub(crate) file: &'a str,
    pub(crate) line: u32,
    pub(crate) function: &'a str,
    pub(crate) node: &'a str,
}

impl Format {
    /// Parses a format. Unknown names stay as they are, like in roscpp.
    pub(crate) fn parse(mut text: &str) -> Self {
        let mut pieces = Vec::new();
        while let Some(start) = text.find("${") {
            let Some(len) = text[start..].find('}') else { break };
            let name = &text[start + 2..start + len];
            // `${time:FORMAT}` gives the time in another form, which is left to tools.
            let known = TOKENS.iter().find(|(token, _)| name.split(':').next() == Some(*token));
            let end = start + len + 1;
            match known {
                Some((_, token)) => {
                    pieces.push(FormatPiece::Text(text[..start].to_owned()));
                    pieces.push(FormatPiece::Token(*token));
                }
                None => pieces.push(FormatPiece::Text(text[..end].to_owned())),
            }
            text = &text[end..];
        }
        pieces.push(FormatPiece::Text(text.to_owned()));
        Self(pieces)
    }

    /// Text of a line, without a line break at its end.
    pub(crate) fn apply(&self, line: &LogFields<'_>) -> String {
        let mut out = String::new();
        for piece in &self.0 {
            // Writing to a string does not fail.
            let _ = match piece {
                FormatPiece::Text(text) => write!(out, "{text}"),
                FormatPiece::Token(token) => put(&mut out, *token, line),
            };
        }
        out
    }
}

/// Escapes control characters, with which names in messages could forge lines or break a terminal.
pub(crate) fn printable(text: String) -> String {
    if !text.contains(char::is_control) {
        return text;
    }
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        if character.is_control() {
            out.extend(character.escape_default());
        } else {
            out.push(character);
        }
    }
    out
}

fn put(out: &mut String, token: Token, line: &LogFields<'_>) -> std::fmt::Result {
    match token {
        Token::Severity => write!(out, "{:>5}", line.level.as_str()),
        Token::Message => write!(out, "{}", line.text),
        Token::Time => {
            put_time(out, since_epoch(line.wall))?;
            if let Some(simulated) = line.simulated {
                write!(out, ", ")?;
                put_time(out, simulated)?;
            }
            Ok(())
        }
        Token::WallTime => put_time(out, since_epoch(line.wall)),
        Token::Thread => write!(out, "{}", std::thread::current().name().unwrap_or("?")),
        Token::Logger => write!(out, "{}", line.logger),
        Token::ShortName => write!(out, "{}", line.logger.trim_start_matches("ros.")),
        Token::File => write!(out, "{}", line.file),
        Token::Line => write!(out, "{}", line.line),
        Token::Function => write!(out, "{}", line.function),
        Token::Node => write!(out, "{}", line.node),
    }
}

fn since_epoch(time: SystemTime) -> Duration {
    time.duration_since(UNIX_EPOCH).unwrap_or_default()
}

fn put_time(out: &mut String, time: Duration) -> std::fmt::Result {
    write!(out, "{}.{:09}", time.as_secs(), time.subsec_nanos())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(simulated: Option<Duration>) -> LogFields<'static> {
        LogFields {
            level: Level::Warn,
            text: "no frame",
            wall: UNIX_EPOCH + Duration::new(12, 34),
            simulated,
            logger: "ros.rviz_camera_stream",
            file: "a.rs",
            line: 7,
            function: "rcs_ros::x",
            node: "/eyes",
        }
    }

    #[test]
    fn the_default_is_roscpps() {
        let format = Format::parse(DEFAULT);
        assert_eq!(format.apply(&line(None)), "[ WARN] [12.000000034]: no frame");
        let simulated = line(Some(Duration::from_millis(1500)));
        assert_eq!(format.apply(&simulated), "[ WARN] [12.000000034, 1.500000000]: no frame");
    }

    #[test]
    fn a_frames_name_with_control_characters_stays_on_its_line() {
        let printed = |text: &str| printable(text.to_owned());
        assert_eq!(printed("frame [a\n[ERROR] forged\x1b[2J\0]"), "frame [a\\n[ERROR] forged\\u{1b}[2J\\u{0}]");
        assert_eq!(printed("[/grün] \\n"), "[/grün] \\n");
    }

    #[test]
    fn each_name_is_replaced_and_others_stay() {
        let format = Format::parse("${node} ${logger} ${shortname} ${file}:${line} ${function} ${walltime} $x ${y} ${");
        let expected = "/eyes ros.rviz_camera_stream rviz_camera_stream a.rs:7 rcs_ros::x 12.000000034 $x ${y} ${";
        assert_eq!(format.apply(&line(None)), expected);
    }
}
