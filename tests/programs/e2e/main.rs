//! The programs as users run them, against a real ROS: its master, rosbag, rostopic, rosservice, a projector's window.
//!
//! Each test starts a master on a free port, a Python node and `camera_stream` (see [`rcs_tests::ros_fixture`]). The
//! programs have to be built first:
//!
//! ```text
//! cargo build --release -p rcs_app --bins
//! cargo test --release -p rcs_tests --test e2e -- --test-threads=2                      all tests
//! cargo test --release -p rcs_tests --test e2e -- diagnostics::                         the tests of one file
//! cargo test --release -p rcs_tests --test e2e -- --exact transforms::a_cloud_waits_for_its_frame   one test
//! ```
//!
//! `--nocapture` prints figures: gaps between images, rates, memory. No test asserts one that depends on the machine.
//!
//! A failing test prints the node's log. Events are waited for with a deadline ([`rcs_tests::ros::PATIENCE`]); a test
//! sleeps only where nothing may happen meanwhile.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod bags;
mod blend;
mod camera_info;
mod check;
mod check_live;
mod command_line;
mod compressed;
mod confirmed_light;
mod dead_man;
mod depth;
mod diagnostics;
mod doctor;
mod eye_safety;
mod floods;
mod frame_rate;
mod hanging_master;
mod heavy;
mod latency;
mod lazy_streams;
mod lifecycle;
mod live_equals_offline;
mod load;
mod meshes;
mod never_false;
mod node_log;
mod node_window;
mod nudge;
mod operator;
mod orientation;
mod projector_board;
mod projector_calibrate;
mod projector_refine;
mod projector_scan;
mod projector_verify;
mod recorded;
mod reference_names;
mod render;
mod rviz_services;
mod samples;
mod settings;
mod setup;
mod simulated_time;
mod soak;
mod thread_names;
mod transforms;
mod viewers;
mod web;
mod wrong_messages;
