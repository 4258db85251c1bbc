//! The log: lines on standard error, in a node as roscpp prints them and on `/rosout`, too.
//!
//! A node's lines have severity and time, `[ WARN] [1795339227.153895123]: text`; `ROSCONSOLE_FORMAT` gives them
//! another form. `__log:=FILE`, which roslaunch gives, names a file that gets all of them. Where standard output is a
//! file, as with roslaunch's `output="log"`, information goes there, as roscpp's does. The programs that are no nodes
//! leave out the time.
//!
//! A node's threads never wait for whoever reads its log: [`lines`] has a bounded queue and a thread for each stream.
//! The other programs write their lines themselves, among their own output.
//!
//! A node logs each cause once a second at most, see [`throttle`], so that a stream of bad messages fills no disk.
//! Panics are among them: those of a decoder of images are caught, and each damaged image may cause one.
//!
//! This project's crates log information and worse, all other crates only errors. The environment variable `RUST_LOG`
//! overrides that, in env_logger's syntax: `RUST_LOG=rcs_ros=debug`; the node's service `~set_logger_level` overrides
//! both.
#![forbid(unsafe_code)]

mod format;
mod lines;
mod panics;
mod throttle;

use std::fs::{File, OpenOptions};
use std::io::{self, IsTerminal as _, Write};
use std::os::fd::AsFd;
use std::panic::Location;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use log::{Level, LevelFilter, Log, Metadata, Record};
use rcs_ros::{log_line, node_time, LogLine, Loggers};

use format::{Format, Line};
use lines::LineQueue;
use panics::while_logging;
use throttle::{cause_of, LeftOut, Throttle};

/// What the names of this project's crates begin with.
const OWN_CRATES: &str = "rcs_";
/// The loggers, as rqt_logger_level shows them: everything, and this package.
const ROOT_LOGGER: &str = "ros";
const OWN_LOGGER: &str = "ros.rviz_camera_stream";
const LOG_ARGUMENT: &str = "__log:=";
const PLAIN_FORMAT: &str = "[${severity}] ${message}";
/// How long a node's last lines may take at its end.
const FLUSH_PATIENCE: Duration = Duration::from_millis(500);
const LEVELS: [(&str, LevelFilter); 5] = [
    ("debug", LevelFilter::Debug),
    ("info", LevelFilter::Info),
    ("warn", LevelFilter::Warn),
    ("error", LevelFilter::Error),
    // Nothing here is fatal and goes on.
    ("fatal", LevelFilter::Off),
];

/// The target of the lines of [`log_status`].
const STATUS_TARGET: &str = "rcs_app::status";

/// A level that may have been chosen while the program runs.
#[derive(Debug)]
struct Chosen(AtomicUsize);

impl Chosen {
    const NONE: usize = usize::MAX;

    const fn new() -> Self {
        Self(AtomicUsize::new(Self::NONE))
    }

    fn get(&self) -> Option<LevelFilter> {
        let chosen = self.0.load(Ordering::Relaxed);
        LevelFilter::iter().find(|level| *level as usize == chosen)
    }

    fn set(&self, level: LevelFilter) {
        self.0.store(level as usize, Ordering::Relaxed);
    }
}

/// Where lines go and which.
struct Console {
    /// What counts while no level was chosen.
    filter: env_logger::Logger,
    own_level: Chosen,
    root_level: Chosen,
    format: Format,
    is_node: bool,
    is_coloured: bool,
    /// A node's standard error.
    errors: Option<LineQueue>,
    /// Its standard output, if information goes there.
    output: Option<LineQueue>,
    file: Option<LineQueue>,
    /// For a node.
    throttle: Mutex<Throttle<Kept>>,
}

/// What is kept of a line that is left out.
struct Kept {
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

/// Starts logging for a node; with `debug` also this project's debug messages. The program's last lines are written
/// when what is returned is dropped.
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

/// Has a node's last lines written when it is dropped, at the end of the program.
#[must_use = "the last lines are written when it is dropped"]
#[derive(Debug)]
pub struct Flush(());

impl Drop for Flush {
    fn drop(&mut self) {
        log::logger().flush();
    }
}

/// Prints why the program fails, behind what was logged.
pub fn print_error(text: &str) {
    match CONSOLE.get() {
        Some(console) => while_logging(|| console.print_to_errors(text.to_owned())),
        None => eprintln!("{text}"),
    }
}

static CONSOLE: OnceLock<Console> = OnceLock::new();

fn install(console: Console) {
    // A second call changes nothing.
    let console = CONSOLE.get_or_init(|| console);
    if log::set_logger(console).is_ok() {
        log::set_max_level(console.filter.filter());
    }
}

/// The loggers whose levels a node's services change.
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
            own_level: Chosen::new(),
            root_level: Chosen::new(),
            format,
            is_node,
            is_coloured: is_node && io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none(),
            errors: None,
            output: None,
            file: None,
            throttle: Mutex::new(Throttle::new()),
        };
        if is_node {
            // The streams' own descriptors: those of the standard library have a lock that is held while they block.
            console.errors = own(&io::stderr()).map(|stream| console.queue("log-stderr", stream));
            let output = own(&io::stdout()).filter(is_file);
            console.output = output.map(|stream| console.queue("log-stdout", stream));
        }
        console
    }

    /// The queue of a stream.
    fn queue(&self, name: &'static str, stream: File) -> LineQueue {
        let format = self.format.clone();
        LineQueue::new(name, stream, move |count| {
            let name = node_time().map(|now| now.name).unwrap_or_default();
            format.apply(&Line {
                level: Level::Warn,
                text: &format!("{count} log lines were dropped here, because nobody read them in time"),
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

    /// The level that was chosen for a target: a logger has the level of the one above it until it is given one.
    fn chosen(&self, target: &str) -> Option<LevelFilter> {
        let own = target.starts_with(OWN_CRATES).then(|| self.own_level.get()).flatten();
        own.or_else(|| self.root_level.get())
    }

    /// What a target logs.
    fn level_of(&self, target: &str) -> LevelFilter {
        self.chosen(target).unwrap_or_else(|| {
            let is_logged =
                |level: &Level| self.filter.enabled(&Metadata::builder().level(*level).target(target).build());
            Level::iter().filter(is_logged).last().map_or(LevelFilter::Off, |level| level.to_level_filter())
        })
    }

    /// Prints a line, and sends it to `/rosout`.
    fn print(&self, kept: &Kept) {
        let now = if self.is_node { node_time() } else { None };
        let simulated = now.as_ref().filter(|now| now.is_simulated);
        let line = Line {
            level: kept.level,
            text: &kept.text,
            wall: SystemTime::now(),
            simulated: simulated.map(|now| Duration::new(now.stamp.sec.into(), now.stamp.nsec)),
            logger: if kept.target.starts_with(OWN_CRATES) { OWN_LOGGER } else { ROOT_LOGGER },
            file: &kept.file,
            line: kept.line,
            function: &kept.module,
            node: now.as_ref().map(|now| now.name.as_str()).unwrap_or_default(),
        };
        self.write(kept.level, &self.format.apply(&line));
        if self.is_node {
            log_line(LogLine {
                level: kept.level,
                module: kept.module.clone(),
                file: kept.file.clone(),
                line: kept.line,
                stamp: now.as_ref().map(|now| now.stamp).unwrap_or_default(),
                text: kept.text.clone(),
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
            // A stream that is closed is nobody's to read.
            None => drop(writeln!(io::stderr(), "{text}")),
        }
    }
}

/// A stream with a descriptor of its own.
fn own(stream: &impl AsFd) -> Option<File> {
    stream.as_fd().try_clone_to_owned().ok().map(File::from)
}

/// Whether a stream is a file on a disk.
fn is_file(stream: &File) -> bool {
    stream.metadata().is_ok_and(|metadata| metadata.is_file())
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Logs how many lines were left out because there were others like them. To be called now and then.
pub fn report_left_out() {
    let Some(console) = CONSOLE.get() else { return };
    // Printed without the lock: whoever prints may log.
    while_logging(|| {
        let left_out = lock(&console.throttle).take_left_out(Instant::now());
        for LeftOut { last, count } in left_out {
            let text = match count {
                1 => last.text,
                _ => format!("{} ({} more like this before)", last.text, count - 1),
            };
            console.print(&Kept { text, ..last });
        }
    });
}

/// Logs a status. Lines with the same `cause` are limited together, whatever their texts, which have names in them.
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
        match self.chosen(metadata.target()) {
            Some(level) => metadata.level() <= level,
            None => self.filter.enabled(metadata),
        }
    }

    fn log(&self, record: &Record<'_>) {
        while_logging(|| self.log_record(record, None));
    }

    /// Waits for the last lines, for a limited time.
    fn flush(&self) {
        let until = Instant::now() + FLUSH_PATIENCE;
        for queue in [&self.file, &self.output, &self.errors].into_iter().flatten() {
            queue.flush(until);
        }
    }
}

impl Console {
    /// Logs a record unless it is one too many of its cause, which is by default its text without numbers.
    fn log_record(&self, record: &Record<'_>, cause: Option<&str>) {
        let is_chosen = self.chosen(record.target()).is_some();
        if !self.enabled(record.metadata()) || (!is_chosen && !self.filter.matches(record)) {
            return;
        }
        let text = format::printable(record.args().to_string());
        let kept = || Kept {
            level: record.level(),
            target: record.target().to_owned(),
            text: text.clone(),
            module: record.module_path().unwrap_or_default().to_owned(),
            file: record.file().unwrap_or_default().to_owned(),
            line: record.line().unwrap_or_default(),
        };
        if !self.is_node || record.level() > Level::Info {
            return self.print(&kept());
        }
        let place = (record.file().unwrap_or_default(), record.line().unwrap_or_default());
        let cause = cause.map_or_else(|| cause_of(&text), str::to_owned);
        let admitted = lock(&self.throttle).admit(place, &cause, Instant::now(), kept);
        match admitted {
            Some(0) => self.print(&kept()),
            Some(count) => self.print(&Kept { text: format!("{text} ({count} more like this before)"), ..kept() }),
            None => {}
        }
    }
}

/// Logs the error that ends the program, whatever the level and however often it was logged before.
#[track_caller]
pub fn log_last(text: &str) {
    let Some(console) = CONSOLE.get() else { return };
    let place = std::panic::Location::caller();
    while_logging(|| {
        console.print(&Kept {
            level: Level::Error,
            target: module_path!().to_owned(),
            text: format::printable(text.to_owned()),
            module: module_path!().to_owned(),
            file: place.file().to_owned(),
            line: place.line(),
        });
    });
}

/// A text that comes from outside as one line without control characters.
pub fn flat(text: &str) -> String {
    let lines: Vec<&str> = text.split(['\n', '\r']).map(str::trim).filter(|line| !line.is_empty()).collect();
    format::printable(lines.join(" "))
}

/// An error with its causes in one line; a cause that is part of the text before it is left out.
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
