//! The log on standard error, in the format of ROS nodes: `[ WARN] text`.
//!
//! This project's crates log information and worse, all other crates only errors. The environment variable `RUST_LOG`
//! overrides that, in env_logger's syntax: `RUST_LOG=rcs_ros=debug`.

use std::io::Write;

use log::LevelFilter;

/// What the names of this project's crates begin with.
const OWN_CRATES: &str = "rcs_";

/// Starts logging; with `debug` also this project's debug messages.
pub fn start(debug: bool) {
    let own_level = if debug { LevelFilter::Debug } else { LevelFilter::Info };
    let mut builder = env_logger::Builder::new();
    builder.filter_level(LevelFilter::Error).filter_module(OWN_CRATES, own_level).parse_default_env();
    builder.format(|out, record| writeln!(out, "[{:>5}] {}", record.level(), record.args()));
    // A second call changes nothing.
    let _ = builder.try_init();
}

/// An error with its causes in one line; a cause that is part of the text before it is left out.
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
    fn a_cause_is_named_once() {
        let error = anyhow!("no such file").context("a.bag: no such file").context("cannot render");
        assert_eq!(one_line(&error), "cannot render: a.bag: no such file");
        let parsed = "x".parse::<u8>().context("rate");
        assert_eq!(one_line(&parsed.unwrap_err()), "rate: invalid digit found in string");
    }
}
