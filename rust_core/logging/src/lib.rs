//! The log of programs and nodes: standard error, a file and `/rosout`, in roscpp's format.
//!
//! A node's line is `[ WARN] [1795339227.153895123]: text`, or what `ROSCONSOLE_FORMAT` says; other programs leave out
//! the time. `__log:=FILE` names a file that gets all lines. Where standard output is a file, as with roslaunch's
//! `output="log"`, information goes there, like roscpp's.
//!
//! A node's threads never wait for its log: each stream has a bounded queue and a writer thread ([`lines`]). Each cause
//! is logged once a second at most ([`throttle`]), panics included.
//!
//! This project's crates log information and worse, all others only errors. `RUST_LOG` overrides that in env_logger's
//! syntax (`RUST_LOG=rcs_ros=debug`), and the node's service `~set_logger_level` overrides both.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod format;
mod lines;
mod panics;
mod recent;
mod throttle;

use std::fs::{File, OpenOptions};
use std::io::{self, IsTerminal as _, Write};
use std::os::fd::AsFd;
use std::panic::Location;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant, SystemTime};

use log::{Level, LevelFilter, Log, Metadata, Record};
use rcs_process::lock;
use rcs_ros::{log_line, node_time, LogLine, Loggers};

use format::{Format, LogFields};
use lines::LineQueue;
use panics::while_logging;
pub use recent::RecentLine;
use recent::RecentLines;
pub use throttle::without_numbers;
use throttle::{Suppressed, Throttle};

/// Prefix of this project's crates.
const OWN_CRATES: &str = "rcs_";
/// The loggers, as rqt_logger_level shows them: everything, and this package.
const ROOT_LOGGER: &str = "ros";
const OWN_LOGGER: &str = "ros.rviz_camera_stream";
const LOG_ARGUMENT: &str = "__log:=";
const PLAIN_FORMAT: &str = "[${severity}] ${message}";
/// Time that a node's last lines may take at its end.
const FLUSH_TIMEOUT: Duration = Duration::from_millis(500);
const LEVELS: [(&str, LevelFilter); 5] = [
    ("debug", LevelFilter::Debug),
    ("info", LevelFilter::Info),
    ("warn", LevelFilter::Warn),
    ("error", LevelFilter::Error),
    // A fatal error ends the program.
    ("fatal", LevelFilter::Off),
];

/// Target of [`log_status`].
const STATUS_TARGET: &str = "rcs_camera_stream::status";

/// Level set by the service `~set_logger_level`, if any.
#[derive(Debug)]
struct LevelOverride(AtomicUsize);

impl LevelOverride {
    const NONE: usize = usize::MAX;

    const fn new() -> Self {
        Self(AtomicUsize::new(Self::NONE))
    }

    fn get(&self) -> Option<LevelFilter> {
        let set = self.0.load(Ordering::Relaxed);
        LevelFilter::iter().find(|level| *level as usize == set)
    }

    fn set(&self, level: LevelFilter) {
        self.0.store(level as usize, Ordering::Relaxed);
    }
}

/// Filters, formats and streams of the log.
struct Console {
    /// Filter of targets without an override.
    filter: env_logger::Logger,
    own_level: LevelOverride,
    root_level: LevelOverride,
    format: Format,
    is_node: bool,
    is_coloured: bool,
    /// A node's standard error; other programs write to it directly.
    errors: Option<LineQueue>,
    /// A node's standard output, if it is a file.
    output: Option<LineQueue>,
    file: Option<LineQueue>,
    /// Limits a node's warnings and errors.
    throttle: Mutex<Throttle<LogLineRecord>>,
}

/// A log record that owns its text.
struct LogLineRecord {
    level: Level,
    target: String,
    text: String,
    module: String,
    file: String,
    line: u32,
}

/// Starts logging for a program that is no node; with `debug` also this project's debug messages.
pub fn start(debug: bool) {
    install(Console::new(debug, Format::parse(PLAIN_FORMAT), false));
}

/// Starts logging for a node; with `debug` also this project's debug messages. Dropping the result writes the last
/// lines.
pub fn start_node(debug: bool) -> Flush {
    let format = std::env::var("ROSCONSOLE_FORMAT").unwrap_or_else(|_| format::DEFAULT.to_owned());
    let mut console = Console::new(debug, Format::parse(&format), true);
    let path = std::env::args_os().skip(1).find_map(|argument| {
        Some(argument.to_str()?.strip_prefix(LOG_ARGUMENT)?.to_owned()).filter(|path| !path.is_empty())
    });
    let opened = path.map(|path| (OpenOptions::new().create(true).append(true).open(&path), path));
    let mut failure = None;
    match opened {
        Some((Ok(file), _)) => console.file = Some(console.queue("log-file", file)),
        Some((Err(error), path)) => failure = Some(format!("no log file {path}: {error}")),
        None => {}
    }
    install(console);
    panics::log_all();
    if let Some(failure) = failure {
        log::warn!("{failure}");
    }
    Flush(())
}

/// Writes a node's last lines when it is dropped, at the end of the program.
#[must_use = "the last lines are written when it is dropped"]
#[derive(Debug)]
pub struct Flush(());

impl Drop for Flush {
    fn drop(&mut self) {
        log::logger().flush();
    }
}

/// Prints why the program fails, after what was logged.
pub fn print_error(text: &str) {
    print_privately(text);
}

/// Prints a line on standard error only: not to the log's file, nor to `/rosout`.
pub fn print_privately(text: &str) {
    match CONSOLE.get() {
        Some(console) => while_logging(|| console.print_to_errors(text.to_owned())),
        None => eprintln!("{text}"),
    }
}

static CONSOLE: OnceLock<Console> = OnceLock::new();
static RECENT: RecentLines = RecentLines::new();

fn install(console: Console) {
    // A second call changes nothing.
    let console = CONSOLE.get_or_init(|| console);
    if log::set_logger(console).is_ok() {
        log::set_max_level(console.filter.filter());
    }
}

/// The node's last log lines after the one with this number, oldest first: at most 200, debug messages left out.
pub fn recent_lines(after: u64) -> Vec<RecentLine> {
    RECENT.after(after)
}

/// Has `on_new` called after each new line that [`recent_lines`] returns; the first call counts. It must neither wait
/// nor log.
pub fn watch_recent_lines(on_new: impl Fn() + Send + Sync + 'static) {
    RECENT.watch(on_new);
}

/// The loggers of a node's logger services.
pub fn loggers() -> Arc<dyn Loggers> {
    Arc::new(NodeLoggers)
}

struct NodeLoggers;

impl Loggers for NodeLoggers {
    fn levels(&self) -> Vec<(String, String)> {
        let Some(console) = CONSOLE.get() else { return Vec::new() };
        let name = |level: LevelFilter| {
            let known = LEVELS.iter().find(|(_, known)| *known == level);
            known.map_or("debug", |(name, _)| *name).to_owned()
        };
        [(ROOT_LOGGER, console.level_of("other")), (OWN_LOGGER, console.level_of(OWN_CRATES))]
            .map(|(logger, level)| (logger.to_owned(), name(level)))
            .to_vec()
    }

    fn set_level(&self, logger: &str, level: &str) -> bool {
        let level = LEVELS.iter().find(|(name, _)| name.eq_ignore_ascii_case(level));
        let (Some(console), Some((_, level))) = (CONSOLE.get(), level) else { return false };
        match logger {
            ROOT_LOGGER => console.root_level.set(*level),
            OWN_LOGGER => console.own_level.set(*level),
            _ => return false,
        }
        log::set_max_level(console.filter.filter().max(console.level_of("other")).max(console.level_of(OWN_CRATES)));
        true
    }
}

impl Console {
    fn new(debug: bool, format: Format, is_node: bool) -> Self {
        let own_level = if debug { LevelFilter::Debug } else { LevelFilter::Info };
        let mut builder = env_logger::Builder::new();
        builder.filter_level(LevelFilter::Error).filter_module(OWN_CRATES, own_level).parse_default_env();
        let mut console = Self {
            filter: builder.build(),
            own_level: LevelOverride::new(),
            root_level: LevelOverride::new(),
            format,
            is_node,
            is_coloured: is_node && io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none(),
            errors: None,
            output: None,
            file: None,
            throttle: Mutex::new(Throttle::new()),
        };
        if is_node {
            // Duplicates, because the standard library's streams hold a lock while they block.
            console.errors = duplicate(&io::stderr()).map(|stream| console.queue("log-stderr", stream));
            let output = duplicate(&io::stdout()).filter(is_file);
            console.output = output.map(|stream| console.queue("log-stdout", stream));
        }
        console
    }

    /// A queue for a stream.
    fn queue(&self, name: &'static str, stream: File) -> LineQueue {
        let format = self.format.clone();
        LineQueue::new(name, stream, move |count| {
            let name = node_time().map(|now| now.name).unwrap_or_default();
            format.apply(&LogFields {
                level: Level::Warn,
                text: &format!("dropped {count} log lines: this stream was not read in time"),
                wall: SystemTime::now(),
                simulated: None,
                logger: OWN_LOGGER,
                file: file!(),
                line: line!(),
                function: module_path!(),
                node: &name,
            })
        })
    }

    /// Level set for a target; the root logger's applies where the own logger has none.
    fn override_of(&self, target: &str) -> Option<LevelFilter> {
        let own = target.starts_with(OWN_CRATES).then(|| self.own_level.get()).flatten();
        own.or_else(|| self.root_level.get())
    }

    /// Most verbose level that a target logs.
    fn level_of(&self, target: &str) -> LevelFilter {
        self.override_of(target).unwrap_or_else(|| {
            let is_logged =
                |level: &Level| self.filter.enabled(&Metadata::builder().level(*level).target(target).build());
            Level::iter().filter(is_logged).last().map_or(LevelFilter::Off, |level| level.to_level_filter())
        })
    }

    /// Prints a line, and sends it to `/rosout`.
    fn print(&self, owned: &LogLineRecord) {
        let now = if self.is_node { node_time() } else { None };
        let simulated = now.as_ref().filter(|now| now.is_simulated);
        let line = LogFields {
            level: owned.level,
            text: &owned.text,
            wall: SystemTime::now(),
            simulated: simulated.map(|now| Duration::new(now.stamp.sec.into(), now.stamp.nsec)),
            logger: if owned.target.starts_with(OWN_CRATES) { OWN_LOGGER } else { ROOT_LOGGER },
            file: &owned.file,
            line: owned.line,
            function: &owned.module,
            node: now.as_ref().map(|now| now.name.as_str()).unwrap_or_default(),
        };
        self.write(owned.level, &self.format.apply(&line));
        if self.is_node {
            RECENT.push(owned.level, &owned.text);
            log_line(LogLine {
                level: owned.level,
                module: owned.module.clone(),
                file: owned.file.clone(),
                line: owned.line,
                stamp: now.as_ref().map(|now| now.stamp).unwrap_or_default(),
                text: owned.text.clone(),
            });
        }
    }

    fn write(&self, level: Level, text: &str) {
        if let Some(file) = &self.file {
            file.push(text.to_owned());
        }
        if let Some(output) = self.output.as_ref().filter(|_| level >= Level::Info) {
            return output.push(text.to_owned());
        }
        let colour = match level {
            _ if !self.is_coloured => None,
            Level::Error => Some("\x1b[31m"),
            Level::Warn => Some("\x1b[33m"),
            Level::Info => None,
            Level::Debug | Level::Trace => Some("\x1b[32m"),
        };
        self.print_to_errors(match colour {
            Some(colour) => format!("{colour}{text}\x1b[0m"),
            None => text.to_owned(),
        });
    }

    fn print_to_errors(&self, text: String) {
        match &self.errors {
            Some(errors) => errors.push(text),
            // Ignored: nobody reads a closed stream.
            None => drop(writeln!(io::stderr(), "{text}")),
        }
    }
}

/// Duplicates a stream's descriptor.
fn duplicate(stream: &impl AsFd) -> Option<File> {
    stream.as_fd().try_clone_to_owned().ok().map(File::from)
}

/// `true` for a regular file.
fn is_file(stream: &File) -> bool {
    stream.metadata().is_ok_and(|metadata| metadata.is_file())
}

/// Logs the number of suppressed lines of each cause. To be called regularly.
pub fn report_suppressed() {
    let Some(console) = CONSOLE.get() else { return };
    // Without the lock, because printing may log.
    while_logging(|| {
        let suppressed = lock(&console.throttle).take_suppressed(Instant::now());
        for Suppressed { last, count } in suppressed {
            let text = match count {
                1 => last.text,
                _ => format!("{} ({} more like this before)", last.text, count - 1),
            };
            console.print(&LogLineRecord { text, ..last });
        }
    });
}

/// Logs a status. Lines of the same `cause` share one rate limit, although their texts have different names in them.
#[track_caller]
pub fn log_status(level: Level, cause: &str, text: &str) {
    let caller = Location::caller();
    let log = |record: &Record<'_>| match CONSOLE.get() {
        Some(console) => while_logging(|| console.log_record(record, Some(cause))),
        None => log::logger().log(record),
    };
    log(&Record::builder()
        .level(level)
        .target(STATUS_TARGET)
        .module_path_static(Some(STATUS_TARGET))
        .file_static(Some(caller.file()))
        .line(Some(caller.line()))
        .args(format_args!("{text}"))
        .build());
}

impl Log for Console {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        match self.override_of(metadata.target()) {
            Some(level) => metadata.level() <= level,
            None => self.filter.enabled(metadata),
        }
    }

    fn log(&self, record: &Record<'_>) {
        while_logging(|| self.log_record(record, None));
    }

    /// Waits a limited time for the last lines.
    fn flush(&self) {
        let until = Instant::now() + FLUSH_TIMEOUT;
        for queue in [&self.file, &self.output, &self.errors].into_iter().flatten() {
            queue.flush(until);
        }
    }
}

impl Console {
    /// Logs a record unless the rate limit of its cause suppresses it. The default cause is its text without digits.
    fn log_record(&self, record: &Record<'_>, cause: Option<&str>) {
        let is_overridden = self.override_of(record.target()).is_some();
        if !self.enabled(record.metadata()) || (!is_overridden && !self.filter.matches(record)) {
            return;
        }
        let text = format::printable(record.args().to_string());
        let owned = || LogLineRecord {
            level: record.level(),
            target: record.target().to_owned(),
            text: text.clone(),
            module: record.module_path().unwrap_or_default().to_owned(),
            file: record.file().unwrap_or_default().to_owned(),
            line: record.line().unwrap_or_default(),
        };
        if !self.is_node || record.level() > Level::Info {
            return self.print(&owned());
        }
        let place = (record.file().unwrap_or_default(), record.line().unwrap_or_default());
        let cause = cause.map_or_else(|| without_numbers(&text), str::to_owned);
        let admitted = lock(&self.throttle).admit(place, &cause, Instant::now(), owned);
        match admitted {
            Some(0) => self.print(&owned()),
            Some(count) => {
                self.print(&LogLineRecord { text: format!("{text} ({count} more like this before)"), ..owned() });
            }
            None => {}
        }
    }
}

/// Logs the error that ends the program, whatever the level and the rate limit.
#[track_caller]
pub fn log_last(text: &str) {
    let Some(console) = CONSOLE.get() else { return };
    let place = std::panic::Location::caller();
    while_logging(|| {
        console.print(&LogLineRecord {
            level: Level::Error,
            target: module_path!().to_owned(),
            text: format::printable(text.to_owned()),
            module: module_path!().to_owned(),
            file: place.file().to_owned(),
            line: place.line(),
        });
    });
}

/// Joins a text's lines and escapes its control characters.
pub fn flat(text: &str) -> String {
    let lines: Vec<&str> = text.split(['\n', '\r']).map(str::trim).filter(|line| !line.is_empty()).collect();
    format::printable(lines.join(" "))
}

/// An error with its causes in one line, without causes that the text before already contains.
pub fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain() {
        let text = flat(&cause.to_string());
        if line.is_empty() {
            line = text;
        } else if !line.contains(&text) {
            line = format!("{line}: {text}");
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use anyhow::{anyhow, Context};

    use super::*;

    #[test]
    fn a_cause_is_named_once() {
        let error = anyhow!("no such file").context("a.bag: no such file").context("cannot render");
        assert_eq!(one_line(&error), "cannot render: a.bag: no such file");
        let error = anyhow!("line 1\r\n  line 2\n\x1b[2J");
        assert_eq!(one_line(&error), "line 1 line 2 \\u{1b}[2J");
        let parsed = "x".parse::<u8>().context("rate");
        assert_eq!(one_line(&parsed.unwrap_err()), "rate: invalid digit found in string");
    }
}
