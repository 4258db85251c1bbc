//! Measures scenes of very many small solids, from a message's bytes to its image: how long each step takes, the
//! most memory, and what is left of it when everything is deleted.
//!
//! `cargo run --release -p rcs_tests --example many_solids [-- FILTER]` prints a table; `RCS_RENDERER` chooses the
//! renderer. Each row is measured in a process of its own. The *first image* includes decoding the message, the
//! display and the scene, the *next one* shows the same scene again, and the *changed one* a new message with all of
//! it moved; both are the fastest of five. Memory is what the process uses beyond that of the messages' bytes.

use std::error::Error;
use std::io::Write;
use std::process::Command;
use std::time::{Duration, Instant};

use rcs_messages::visualization_msgs::Marker;
use rcs_tests::scenes::display_pipeline::DisplayPipeline;
use rcs_tests::scenes::many_solids::{many_solids_camera, Content, ManySolids};
use rcs_tests::scenes::rendering::{renderer, Rendering};

/// Tells a process which row it measures.
const ROW: &str = "--row";

fn rows() -> Vec<(&'static str, ManySolids)> {
    let of = |content, count| ManySolids { content, count };
    let markers = |marker_type, count| of(Content::Markers(marker_type), count);
    vec![
        ("3,000 sphere markers", markers(Marker::SPHERE, 3_000)),
        ("3,000 cube markers", markers(Marker::CUBE, 3_000)),
        ("3,000 arrow markers", markers(Marker::ARROW, 3_000)),
        ("100,000 sphere markers", markers(Marker::SPHERE, 100_000)),
        ("100,000 cube markers", markers(Marker::CUBE, 100_000)),
        ("100,000 arrow markers", markers(Marker::ARROW, 100_000)),
        ("100,000 text markers", markers(Marker::TEXT_VIEW_FACING, 100_000)),
        ("50,000 spheres with labels", of(Content::LabelledSpheres, 100_000)),
        ("path of 10,000 poses as axes", of(Content::PathAxes, 10_000)),
        ("path of 10,000 poses as arrows", of(Content::PathArrows, 10_000)),
        ("path of 100,000 poses as axes", of(Content::PathAxes, 100_000)),
        ("path of 100,000 poses as arrows", of(Content::PathArrows, 100_000)),
        ("array of 10,000 poses as arrows", of(Content::PoseArrows, 10_000)),
        ("path of 1,000,000 poses as a line", of(Content::PathLine, 1_000_000)),
        ("array of 1,000,000 poses as flat arrows", of(Content::FlatArrows, 1_000_000)),
        ("text of 1,000,000 characters", of(Content::Text, 1_000_000)),
    ]
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, name] = arguments.as_slice() {
        if flag == ROW {
            let row = rows().into_iter().find(|(known, _)| known == name).ok_or("there is no such row")?;
            return measure(row.0, row.1);
        }
    }
    let filter = arguments.first().map_or("", String::as_str);
    println!(
        "| scene | first picture ms: decode + display + draw | next ms | changed: display + draw ms | peak MB | deleted MB |"
    );
    println!("|---|---|---|---|---|---|");
    std::io::stdout().flush()?;
    for (name, _) in rows().iter().filter(|(name, _)| name.contains(filter)) {
        let status = Command::new(std::env::current_exe()?).args([ROW, name]).status()?;
        if !status.success() {
            return Err(format!("{name}: {status}").into());
        }
    }
    Ok(())
}

/// A field of this process's status in MB, such as `VmRSS`.
fn memory_mb(field: &str) -> Result<f64, Box<dyn Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|line| line.starts_with(field)).ok_or("no such field")?;
    Ok(line.split_whitespace().nth(1).ok_or("no number")?.parse::<f64>()? / 1024.0)
}

fn millis(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

fn measure(name: &str, solids: ManySolids) -> Result<(), Box<dyn Error>> {
    let bytes = solids.bytes(0.0);
    let changed_bytes: Vec<_> = (1..=5).map(|number| solids.bytes(f64::from(number) * 1e-3)).collect();
    let mut rendering = Rendering::new(Vec::new(), many_solids_camera()?, renderer()?);
    let mut pipeline = DisplayPipeline::new(&solids.config());
    rendering.draw()?;
    // From now on the peak is that of the measurement.
    std::fs::write("/proc/self/clear_refs", "5")?;
    let before_mb = memory_mb("VmRSS")?;

    let start = Instant::now();
    let message = solids.kind().decode(&bytes)?;
    let decoded = start.elapsed();
    pipeline.receive("/many", &message);
    let shown = start.elapsed();
    rendering.draw_of(&pipeline.scene)?;
    let first = start.elapsed();
    let covered = rendering.covered();
    let next = (0..5).map(|_| {
        let start = Instant::now();
        rendering.draw_of(&pipeline.scene).map(|_| start.elapsed())
    });
    let next = next.collect::<Result<Vec<_>, _>>()?.into_iter().min().unwrap_or_default();
    drop(message);
    let mut changed: Option<(Duration, Duration)> = None;
    for bytes in &changed_bytes {
        let message = solids.kind().decode(bytes)?;
        let start = Instant::now();
        pipeline.receive("/many", &message);
        let shown = start.elapsed();
        rendering.draw_of(&pipeline.scene)?;
        let this = (start.elapsed(), shown);
        changed = changed.into_iter().chain([this]).min();
    }
    let (changed, updated) = changed.unwrap_or_default();
    let peak_mb = memory_mb("VmHWM")? - before_mb;
    pipeline.receive("/many", &solids.removal());
    rendering.draw_of(&pipeline.scene)?;
    let left_mb = memory_mb("VmRSS")? - before_mb;
    println!(
        "| {name} | {:.0}: {:.0} + {:.0} + {:.0} | {:.0} | {:.0}: {:.0} + {:.0} | {peak_mb:.0} | {left_mb:.0} |",
        millis(first),
        millis(decoded),
        millis(shown - decoded),
        millis(first - shown),
        millis(next),
        millis(changed),
        millis(updated),
        millis(changed - updated),
    );
    if covered < 1e-3 {
        return Err(format!("{name}: nothing is seen").into());
    }
    Ok(())
}
