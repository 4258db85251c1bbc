//! `projector_calibrate scan`: the scan engine of [`rcs_scan`] on ROS topics and a window, or on a bag.

mod arguments;
mod live;
mod progress;
mod ros_camera;
mod screens;
mod topics;
mod verify_live;

use rcs_files::capture::CAPTURE_FILE;
use rcs_files::picture_file;
use rcs_scan::preview;
use rcs_scan::recorded::bag_footage::BagFootage;
use rcs_scan::recorded::footage::Footage;
use rcs_scan::recorded::{self, RecordedOptions};
use rcs_scan::Scanned;

use super::arguments::Size;
use super::Failure;
pub(super) use arguments::ScanArguments;
use progress::Progress;
pub(super) use topics::TopicArguments;
pub(super) use verify_live::{verify_live, LiveOptions};

/// Runs the command.
///
/// # Errors
/// [`Failure`]: the scan was refused, or a topic, a bag, a window or a file cannot be used.
pub(super) fn run(arguments: &ScanArguments) -> Result<(), Failure> {
    arguments.check_files()?;
    if arguments.bag.is_empty() {
        live::scan(arguments)
    } else {
        scan_bags(arguments)
    }
}

/// Scans what bags have recorded.
fn scan_bags(arguments: &ScanArguments) -> Result<(), Failure> {
    let Size(projector_px) = arguments.size;
    let options =
        RecordedOptions { projector_px, patterns: arguments.recorded_patterns()?, frames: arguments.frames.into() };
    let shown = arguments.show_on.as_deref();
    let footage = BagFootage::open(&arguments.bag, &arguments.topics(), shown, arguments.start)?;
    let mut progress = Progress::new("reading the bag", None, footage.lens().size_px, projector_px);
    let scanned = recorded::scan(&footage, &options, &mut |event| progress.show(&event));
    progress.finish();
    write(arguments, &scanned?)
}

/// Writes the capture and the preview.
fn write(arguments: &ScanArguments, scanned: &Scanned) -> Result<(), Failure> {
    let Scanned { capture, decoded, is_whole } = scanned;
    capture.write(&arguments.output).map_err(Failure::refused)?;
    if let Some(path) = &arguments.preview {
        let picture = preview::of_decoded(decoded, capture.projector_size_px);
        picture_file::write(path, &picture).map_err(Failure::refused)?;
    }
    let (count, lit) = (decoded.count(), decoded.lit.max(1));
    eprintln!(
        "written{}: {} pictures, {count} pixels decoded ({:.0} % of the lit ones), {}",
        if *is_whole { "" } else { " though interrupted" },
        capture.pictures.len(),
        100.0 * count as f64 / lit as f64,
        arguments.output.join(CAPTURE_FILE).display()
    );
    Ok(())
}
