//! `camera_stream` as a ROS node.
//!
//! ```text
//!   topics, /tf ──► events ──► scene thread: displays, frames ──► outputs ──► windows' threads
//!                                  ▲    │                            ▲
//!                        settings, │    │ its present step           │ the last frames again
//!                          config  │    ▼                            │ while one takes long
//!   signals, services ─ calls ──► control thread ────────────────────┘
//! ```
//!
//! The scene's thread owns the scene: it takes messages, updates the displays, draws frames and hands them to the
//! outputs. Nothing is drawn that nobody subscribes to, and a scene that did not change is not drawn again: its last
//! image is published with a new stamp. The control thread answers calls that must not wait for a frame.

mod activity;
mod config_control;
mod config_reader;
mod config_reply;
mod control_thread;
pub(crate) mod cue_thread;
mod diagnostics;
mod frame_renderer;
mod node_settings;
mod scene_thread;
pub(crate) mod shared;
pub(crate) mod watchdog;
mod windows;

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use rcs_rviz_config::Config;

use crate::options::Options;
use crate::{config_names, log_findings, page, NODE_NAME};
use control_thread::ControlThread;
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::node_options;
use scene_thread::SceneThread;
use shared::NodeState;
use watchdog::Watchdog;

/// Runs the node until it is asked to end, with the command line's words and the config in a file. After an error,
/// [`lifecycle::finish`] is to end it.
///
/// # Errors
/// One line that names what failed: the master's address, a topic, the renderer.
pub(crate) fn run(words: &[OsString], file: &Path, config: &Config) -> Result<()> {
    log_findings(config, &[]);
    let end = EndRequest::watch_signals().context("cannot handle signals")?;
    rcs_process::name_threads();
    let Some(ros) = lifecycle::connect(NODE_NAME, &end)? else { return Ok(()) };
    let given = node_options::merge(words, ros.parameters())?;
    log::info!("options: {}", given.command_line);
    let options = Options::of(&given, &config_names(config))?;
    rcs_process::trim_regularly().context("cannot start the thread that gives memory back")?;
    let shared = Arc::new(NodeState::new(ros, file, &options.node.light)?);
    let scene = SceneThread::start(&options, config, &shared)?;
    cue_thread::start(&shared)?;
    let control = ControlThread::start(&options, file, config, &shared)?;
    let _page = options.web.as_ref().map(|web| page::start(web, &shared)).transpose()?;
    run_threads(scene, control, &end)?;
    shared.ros.shutdown();
    Ok(())
}

fn run_threads(scene: SceneThread, control: ControlThread, end: &EndRequest) -> Result<()> {
    let _watchdog = Watchdog::start().context("cannot start the watchdog's thread")?;
    let thread = std::thread::Builder::new().name("scene".to_owned()).spawn(move || scene.run());
    control.run(thread.context("cannot start the scene's thread")?, end)
}
