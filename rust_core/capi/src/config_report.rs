//! What the node would draw of a config: for the plugin's Headless Twin.

use std::ffi::c_char;

use rcs_rviz_config::{headless, parse_bytes};

use crate::fault::{Fault, RcsResult};
use crate::text::write_text;
use crate::{guard, pointers};

/// More bytes than any config has.
const MOST_BYTES: usize = 64 << 20;

/// Says what the node could not draw of a config, and how to start it.
///
/// `yaml`, `yaml_length`: the text of a `.rviz` file in UTF-8 (64 MiB at most, else `RCS_RESULT_BAD_LENGTH`), which
/// need not end with a NUL. `path`: where the file is or will be; ends with a NUL. `report`: one line for each
/// display or setting that the node does not draw as rviz does, in the words of `camera_stream check`, separated by
/// newlines; empty if it draws all. `launch_line`: the roslaunch command that draws the config without rviz. Buffers
/// are filled as that of `rcs_last_error`, and the whole texts' lengths without NUL are written to `report_needed`
/// and `launch_line_needed`; `displays_not_drawn` gets the number of enabled displays that the node cannot draw. Each
/// of these pointers may be NULL (a buffer with the length 0). `RCS_RESULT_BAD_CONFIG` if the text is no `.rviz`
/// file.
///
/// # Safety
/// There are as many bytes behind `yaml` and room for as many behind the buffers as their lengths say; `path` ends
/// with a NUL.
#[no_mangle]
pub unsafe extern "C" fn rcs_config_report(
    yaml: *const c_char,
    yaml_length: usize,
    path: *const c_char,
    report: *mut c_char,
    report_length: usize,
    report_needed: *mut usize,
    launch_line: *mut c_char,
    launch_line_length: usize,
    launch_line_needed: *mut usize,
    displays_not_drawn: *mut u32,
) -> RcsResult {
    guard::result(|| {
        if yaml_length > MOST_BYTES {
            let text = format!("yaml_length is {yaml_length}, more than {MOST_BYTES}");
            return Err(Fault::new(RcsResult::BadLength, text));
        }
        if yaml.is_null() {
            return Err(Fault::null("yaml"));
        }
        // SAFETY: as the caller promises.
        let yaml = unsafe { pointers::slice(yaml.cast::<u8>(), yaml_length, "yaml") }?;
        // SAFETY: as the caller promises.
        let path = unsafe { pointers::text(path, "path") }?;
        for (pointer, name) in [(report_needed, "report_needed"), (launch_line_needed, "launch_line_needed")] {
            optional(pointer, name)?;
        }
        optional(displays_not_drawn, "displays_not_drawn")?;
        for (buffer, length, name) in
            [(report, report_length, "report"), (launch_line, launch_line_length, "launch_line")]
        {
            if buffer.is_null() && length > 0 {
                return Err(Fault::null(name));
            }
        }
        let config = parse_bytes(yaml, &path).map_err(|error| Fault::new(RcsResult::BadConfig, error))?;
        // SAFETY: as the caller promises.
        let needed = unsafe { write_text(&headless::report(&config).join("\n"), report, report_length) }?;
        // SAFETY: as the caller promises.
        unsafe { pointers::write(report_needed, needed) };
        // SAFETY: as the caller promises.
        let needed = unsafe { write_text(&headless::launch_line(&config), launch_line, launch_line_length) }?;
        // SAFETY: as the caller promises.
        unsafe { pointers::write(launch_line_needed, needed) };
        // SAFETY: as the caller promises.
        unsafe { pointers::write(displays_not_drawn, headless::displays_not_drawn(&config)) };
        Ok(())
    })
}

/// Checks a pointer that may be NULL.
fn optional<T>(pointer: *mut T, name: &str) -> Result<(), Fault> {
    if pointer.is_null() {
        return Ok(());
    }
    pointers::writable(pointer, name)
}
