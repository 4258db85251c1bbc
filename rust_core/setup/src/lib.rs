//! `camera_stream setup`: from a few answers to a folder that `roslaunch` starts.
//!
//! ```text
//!  flags ─┐
//!  terminal ─ answers ─ plan ─ files: projector.yaml, scene.rviz, projection.launch, README.md
//!  found ─┘   (master, TF, monitors)
//! ```
//!
//! Without a ROS master or a display, the flags alone are enough. Nothing is written until all answers are valid.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod answers;
mod arguments;
mod display_type;
mod error;
mod folder;
mod found;
mod launch;
mod plan;
mod profile;
mod projector_guess;
mod readme;
mod scene;
mod scene_names;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::io::{self, IsTerminal as _, Write as _};
use std::sync::Arc;

use anyhow::Context as _;
use rcs_node_support::dialog::{end_on_signals, Dialog};
use rcs_ros::RosNode;

use crate::answers::Answers;
use crate::found::{Found, Rate};
use crate::plan::Plan;

pub use arguments::{SetupArgs, Show};
pub use error::SetupError;
pub use profile::Profile;

/// Asks what the flags leave open, and writes the folder.
///
/// # Errors
/// [`SetupError`]; nothing is written then, unless the disk fails between two files.
pub fn run(args: &SetupArgs) -> Result<(), SetupError> {
    let folder = folder::absolute(&args.folder)?;
    folder::check_free(&folder, args.overwrite)?;
    let node = found::connect().map(Arc::new);
    let asking = node.clone();
    let clean_up = move || asking.iter().for_each(|node| node.shutdown());
    end_on_signals("camera_stream", clean_up).context("cannot handle signals").map_err(SetupError::Refused)?;
    let mut found = Found::look(node.as_deref());
    folder::calibrated(&folder)?.iter().for_each(|file| found.add_projector(file));
    let answers = ask(args, &found)?;
    answers::warnings(&answers, &found).iter().for_each(|warning| log::warn!("{warning}"));
    let rates = node.as_ref().map(|node| measure(node, &answers, &found)).unwrap_or_default();
    node.iter().for_each(|node| node.shutdown());
    let plan = Plan::new(folder, answers, &rates, args.is_try);
    let files = folder::files(&plan)?;
    let kept = folder::write(&plan.folder, &files)?;
    let line = |name: &str| {
        format!("{}{}\n", plan.path(name), if kept.contains(&name) { ": kept, it is calibrated" } else { "" })
    };
    let written: String = files.iter().map(|(name, _)| line(name)).collect();
    // The files are written: a closed pipe, as of `head`, is no error.
    let _ = writeln!(io::stdout(), "{written}next: {}", readme::launch_command(&plan));
    Ok(())
}

/// The answers, from a terminal if there is one.
#[expect(clippy::disallowed_methods, reason = "a signal ends the program while it waits for an answer")]
fn ask(args: &SetupArgs, found: &Found) -> Result<Answers, SetupError> {
    let input = io::stdin();
    if !input.is_terminal() {
        return answers::complete(args, found, None);
    }
    answers::complete(args, found, Some(&mut Dialog::new(&mut input.lock(), &mut io::stderr())))
}

/// How the chosen topics that have publishers are published.
fn measure(node: &RosNode, answers: &Answers, found: &Found) -> BTreeMap<String, Rate> {
    let published = answers.topics.iter().filter(|(topic, _)| found.topics.contains_key(topic));
    let topics: Vec<_> = published.map(|(topic, display)| (topic.as_str(), *display)).collect();
    if !topics.is_empty() {
        log::info!("measuring how often {} topics are published", topics.len());
    }
    found::measure(node, &topics)
}
