//! The window on real display servers: the screen shows the image, pixel by pixel, over the whole monitor.
//!
//! Each test starts its own server on a free display (and openbox where a window manager is asked for), runs the
//! example `window_pattern` there, reads the screen's pixels and presses keys through the XTEST extension. The servers
//! are Debian's packages `xvfb`, `xserver-xorg-core` with `xserver-xorg-video-dummy` (two monitors), and `weston`.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod dead_man;
mod screen;
mod two_monitors;
mod wayland;
mod x11;
