//! Shared parts of the nodes: signals and shutdown, options that are also private parameters, files as a user types
//! them, a status on `/diagnostics`, transforms from `/tf`, questions on the terminal, and the arguments of programs
//! with a window.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod dialog;
pub mod frames;
pub mod key_value;
pub mod lifecycle;
pub mod monitor_arguments;
pub mod near;
pub mod node_options;
pub mod node_status;
pub mod nudge;
pub mod ros_names;
pub mod user_file;
pub mod window_watch;
