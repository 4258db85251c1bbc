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
