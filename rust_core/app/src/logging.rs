//! What is said on standard error, in the form of ROS nodes: `[ WARN] …`.

use log::{LevelFilter, Log, Metadata, Record};

struct StandardError;

/// The programs' own crates, whose names are their messages' targets.
const PROGRAMS: [&str; 4] = ["camera_stream", "projector", "projector_window", "publish_cloud"];

impl Log for StandardError {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        // Libraries speak only where something is wrong.
        let target = metadata.target();
        let own = target.starts_with("rcs_") || PROGRAMS.contains(&target);
        own || metadata.level() <= log::Level::Error
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            eprintln!("[{:>5}] {}", record.level(), record.args());
        }
    }

    fn flush(&self) {}
}

/// Starts logging: information and worse, or all.
pub fn start(debug: bool) {
    log::set_max_level(if debug { LevelFilter::Debug } else { LevelFilter::Info });
    // A second call keeps the first logger, which is the same one.
    let _ = log::set_logger(&StandardError);
}

/// An error with its causes in one line; a cause that the text before it tells already is left out.
pub fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain() {
        let text = cause.to_string().replace('\n', " ");
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
    fn a_cause_is_told_once() {
        let error = anyhow!("no such file").context("a.bag: no such file").context("cannot render");
        assert_eq!(one_line(&error), "cannot render: a.bag: no such file");
        let parsed = "x".parse::<u8>().context("rate");
        assert_eq!(one_line(&parsed.unwrap_err()), "rate: invalid digit found in string");
    }
}
