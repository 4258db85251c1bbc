//! `projector_blend`: blending weights of several projectors on one surface, as files for `camera_stream --blend`.

mod surface;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{anyhow, bail, Context, Result};
use clap::{Command, CommandFactory, Parser};
use nalgebra::Isometry3;
use rcs_calibration::{blend_weights, BlendProblem, BlendWeights, PlacedProjector};
use rcs_files::blend_file::BlendFile;
use rcs_files::image_file;
use rcs_files::projector::ProjectorFile;
use rcs_scene::{Encoding, Image};

use rcs_node_support::lifecycle;
use rcs_node_support::ros_names::{subscribes, RosName};
use surface::SharedSurface;

/// Topics of the program.
pub const ROS_NAMES: &[RosName] = &[
    subscribes("TOPIC", "sensor_msgs/PointCloud2", "with `--topic`: the surface, one message"),
    subscribes("/tf, /tf_static", "tf2_msgs/TFMessage", "with `--topic`: frames that no file places"),
];
/// Highest black level, as a share of full light.
const MOST_BLACK: f64 = 0.1;
/// Share of a projector's image with cloud points below which there is a warning.
const LITTLE_SEEN: f64 = 0.5;
/// Width of each projector in the preview, pixels, and the gap between two.
const PREVIEW_PX: usize = 480;
const GAP_PX: usize = 8;

/// Computes blending weights, so that the image is as bright where projectors overlap as elsewhere.
///
/// For each projector's file NAME.yaml it writes NAME.blend.png, for camera_stream's --blend on the machine of that
/// projector. The surface is a PCD file or the next cloud on a topic; frames that the files do not place are asked for
/// on /tf.
#[derive(Parser)]
#[command(
    name = "projector_blend",
    display_name = "rviz_camera_stream",
    version,
    before_help = "\
Examples:
  projector_blend left.yaml right.yaml --cloud wall.pcd --frame map -o \\
      blend",
    after_help = "\
Exit codes: 0 the files are written; 1 they are not; 2 invalid arguments"
)]
struct BlendArguments {
    /// The projectors' files, two or more, each with a frame that places it
    #[arg(value_name = "PROJECTOR.yaml", required = true, num_args = 2..)]
    files: Vec<PathBuf>,
    /// The surface, as a PCD file
    #[arg(long, value_name = "FILE.pcd", required_unless_present = "topic", conflicts_with = "topic")]
    cloud: Option<PathBuf>,
    /// The frame of the PCD file's points [default: the one in which the first file places its projector]
    #[arg(long, value_name = "FRAME", requires = "cloud")]
    frame: Option<String>,
    /// The surface, as the next cloud on this topic (sensor_msgs/PointCloud2)
    #[arg(long, value_name = "TOPIC")]
    topic: Option<String>,
    /// The folder to write to
    #[arg(short = 'o', long, value_name = "DIR", default_value = ".")]
    output: PathBuf,
    /// Light of a black pixel as a share of full light, 0 to 0.1; black is lifted where fewer projectors overlap
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = black_level)]
    black_level: f64,
    /// Write all weights side by side to this image
    #[arg(long, value_name = "FILE.png")]
    preview: Option<PathBuf>,
}

fn black_level(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| (0.0..=MOST_BLACK).contains(share));
    share.ok_or_else(|| format!("a share from 0 to {MOST_BLACK}"))
}

/// The command line.
pub fn command() -> Command {
    BlendArguments::command()
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    lifecycle::run_main(|arguments: BlendArguments| run(&arguments))
}

fn run(arguments: &BlendArguments) -> Result<()> {
    let files: Vec<(&Path, ProjectorFile)> =
        arguments.files.iter().map(|path| Ok((path.as_path(), ProjectorFile::read(path)?))).collect::<Result<_>>()?;
    let outputs = output_names(&arguments.files, &arguments.output)?;
    let surface = match (&arguments.cloud, &arguments.topic) {
        (Some(path), _) => SharedSurface::from_file(path, arguments.frame.as_deref(), &files)?,
        (None, Some(topic)) => SharedSurface::from_topic(topic, &files)?,
        (None, None) => bail!("no surface: give --cloud FILE.pcd or --topic TOPIC"),
    };
    rcs_process::name_threads();
    let placed = files.iter().map(|(path, file)| place(path, file, &surface)).collect::<Result<Vec<_>>>()?;
    let weights = blend_weights(&placed, &surface.points).map_err(|problem| match &problem {
        BlendProblem::Dark { number } => {
            let file = arguments.files.get(number - 1).map_or_else(String::new, |file| file.display().to_string());
            anyhow!("{file}: {problem}")
        }
        BlendProblem::TooFew => anyhow!(problem),
    })?;
    std::fs::create_dir_all(&arguments.output).with_context(|| arguments.output.display().to_string())?;
    for ((path, output), weights) in arguments.files.iter().zip(&outputs).zip(&weights) {
        write(weights, arguments.black_level, output)?;
        report(path, output, weights);
    }
    if let Some(path) = &arguments.preview {
        image_file::write(path, &preview(&weights))?;
    }
    Ok(())
}

/// Output path of each file: NAME.blend.png in the folder.
fn output_names(files: &[PathBuf], folder: &Path) -> Result<Vec<PathBuf>> {
    let mut known = BTreeSet::new();
    let name = |file: &PathBuf| {
        let stem = file.file_stem().with_context(|| format!("{}: not a file's name", file.display()))?;
        let name = format!("{}.blend.png", stem.to_string_lossy());
        if !known.insert(name.clone()) {
            bail!(
                "{}: another file has the same name, and both would be written to {name}: rename one",
                file.display()
            );
        }
        Ok(folder.join(name))
    };
    files.iter().map(name).collect()
}

/// A projector's lens and its pose in the surface's frame.
fn place(path: &Path, file: &ProjectorFile, surface: &SharedSurface) -> Result<PlacedProjector> {
    let lens = file.lens().with_context(|| path.display().to_string())?;
    let cloud_from_projector: Isometry3<f64> =
        surface.pose_of(&file.camera_info.header.frame_id).with_context(|| path.display().to_string())?;
    Ok(PlacedProjector { lens, projector_from_cloud: cloud_from_projector.inverse() })
}

fn write(weights: &BlendWeights, black_level: f64, path: &Path) -> Result<()> {
    let lifts: Vec<f32> = weights.lifts.iter().map(|lift| lift * black_level as f32).collect();
    Ok(BlendFile::new(weights.size_px, &weights.weights, &lifts).write(path)?)
}

fn report(file: &Path, output: &Path, weights: &BlendWeights) {
    let [overlap, seen] = [weights.overlap, weights.seen].map(|share| 100.0 * share);
    println!(
        "{}: {overlap:.0} % of its pixels overlap with others; the cloud has points in {seen:.0} % of its picture",
        output.display()
    );
    if weights.seen < LITTLE_SEEN {
        log::warn!(
            "{}: most of its image has no cloud points and is extrapolated; use a cloud of all that it lights",
            file.display()
        );
    }
    if weights.overlap == 0.0 {
        log::warn!("{}: overlaps no other projector; check poses and frames", file.display());
    }
}

/// The weights side by side, as grey levels.
fn preview(all: &[BlendWeights]) -> Image {
    let scaled: Vec<(usize, Vec<u8>)> = all.iter().map(scaled).collect();
    let height = scaled.iter().map(|(height, _)| *height).max().unwrap_or(1);
    let width = all.len() * (PREVIEW_PX + GAP_PX) - GAP_PX;
    let mut image = Image::default();
    image.reset(width as u32, height as u32, Encoding::Mono8);
    image.data.fill(u8::MAX);
    for (index, (_, levels)) in scaled.iter().enumerate() {
        let left = index * (PREVIEW_PX + GAP_PX);
        for (row, levels) in levels.chunks(PREVIEW_PX).enumerate() {
            if let Some(to) = image.data.get_mut(row * width + left..row * width + left + levels.len()) {
                to.copy_from_slice(levels);
            }
        }
    }
    image
}

/// A projector's weights scaled to the preview's width: height and grey levels.
fn scaled(weights: &BlendWeights) -> (usize, Vec<u8>) {
    let [width, height] = weights.size_px.map(|side| side as usize);
    let rows = (height * PREVIEW_PX / width.max(1)).max(1);
    let at = |x: usize, y: usize| {
        let (column, row) = (x * width / PREVIEW_PX, y * height / rows);
        weights.weights.get(row * width + column).copied().unwrap_or(0.0)
    };
    let levels =
        (0..rows).flat_map(|y| (0..PREVIEW_PX).map(move |x| (x, y))).map(|(x, y)| (at(x, y) * 255.0).round() as u8);
    (rows, levels.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_has_an_output_of_its_own_name() {
        let names =
            |files: &[&str]| output_names(&files.iter().map(PathBuf::from).collect::<Vec<_>>(), Path::new("out"));
        assert_eq!(
            names(&["a/left.yaml", "right.yml"]).unwrap(),
            [Path::new("out/left.blend.png"), Path::new("out/right.blend.png")]
        );
        assert!(names(&["a/left.yaml", "b/left.yaml"]).unwrap_err().to_string().contains("rename one"));
    }

    #[test]
    fn black_levels_are_small_shares() {
        assert_eq!(black_level("0.005"), Ok(0.005));
        assert!(["-0.1", "0.2", "nan", "1 %"].iter().all(|text| black_level(text).is_err()));
    }
}
