//! The node's report on a config, for the plugin's Headless Twin.

use std::ffi::c_char;

use rcs_rviz_config::{headless, parse_bytes};

use crate::fault::{Fault, RcsResult};
use crate::guard;
use crate::pointers::{self, required};
use crate::text::write_text;

/// Largest config, in bytes.
const MAX_BYTES: usize = 64 << 20;

/// A buffer of the caller for a text, filled as in `rcs_last_error`.
#[repr(C)]
#[derive(Debug)]
pub struct RcsText {
    /// The buffer; may be NULL if `length` is 0.
    pub buffer: *mut c_char,
    /// Bytes of the buffer.
    pub length: usize,
    /// Set by the call: length of the whole text without its NUL.
    pub needed: usize,
}

impl RcsText {
    fn check(&self, name: &str) -> Result<(), Fault> {
        if self.buffer.is_null() && self.length > 0 {
            return Err(Fault::null(name));
        }
        Ok(())
    }

    /// # Safety
    /// The buffer has `length` bytes.
    unsafe fn write(&mut self, text: &str) -> Result<(), Fault> {
        // SAFETY: as the caller promises.
        self.needed = unsafe { write_text(text, self.buffer, self.length) }?;
        Ok(())
    }
}

/// Reports what the node cannot draw of a config, and the command that starts the node.
///
/// `yaml`, `yaml_length`: the text of a `.rviz` file in UTF-8 (64 MiB at most, else `RCS_RESULT_BAD_LENGTH`), without a
/// NUL. `path`: the file's path; ends with a NUL. `report`: one line for each display or setting that the node does not
/// draw as rviz does, in the words of `camera_stream check`, separated by newlines; empty if it draws all.
/// `launch_line`: the roslaunch command that draws the config without rviz. `RCS_RESULT_BAD_CONFIG` if the text is no
/// `.rviz` file.
///
/// # Safety
/// `yaml` has `yaml_length` bytes, `path` ends with a NUL, and `report` and `launch_line` are different, with buffers
/// as long as they say.
#[no_mangle]
pub unsafe extern "C" fn rcs_config_report(
    yaml: *const c_char,
    yaml_length: usize,
    path: *const c_char,
    report: Option<&mut RcsText>,
    launch_line: Option<&mut RcsText>,
) -> RcsResult {
    guard::result(|| {
        if yaml_length > MAX_BYTES {
            let text = format!("yaml_length is {yaml_length}, more than {MAX_BYTES}");
            return Err(Fault::new(RcsResult::BadLength, text));
        }
        if yaml.is_null() {
            return Err(Fault::null("yaml"));
        }
        // SAFETY: as the caller promises.
        let yaml = unsafe { pointers::slice(yaml.cast::<u8>(), yaml_length, "yaml") }?;
        // SAFETY: as the caller promises.
        let path = unsafe { pointers::text(path, "path") }?;
        let (report, launch_line) = (required(report, "report")?, required(launch_line, "launch_line")?);
        report.check("report.buffer")?;
        launch_line.check("launch_line.buffer")?;
        let config = parse_bytes(yaml, &path).map_err(|error| Fault::new(RcsResult::BadConfig, error))?;
        // SAFETY: as the caller promises.
        unsafe { report.write(&headless::report(&config).join("\n")) }?;
        // SAFETY: as the caller promises.
        unsafe { launch_line.write(&headless::launch_line(&config)) }
    })
}
