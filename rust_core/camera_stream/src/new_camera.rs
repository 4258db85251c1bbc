//! `camera_stream new-camera`: a CameraPub display, printed or added to a config.

use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use anyhow::{anyhow, Context, Result};
use rcs_files::atomic_file::write_atomically;
use rcs_rviz_config::{insert_camera, NewCamera, MAX_FILE_BYTES};
use rcs_user_files::read_text;

use crate::cli::NewCameraArgs;

/// Indentation of displays in a file that rviz saved.
const INDENTATION: usize = 4;

/// Prints the display, or adds it to the config that is named.
///
/// # Errors
/// One line with the config and the problem; the config is unchanged then.
pub(crate) fn run(args: &NewCameraArgs) -> Result<ExitCode> {
    let camera = NewCamera {
        name: args.name.clone(),
        camera_info_topic: args.camera_info.clone(),
        image_topic: args.image_topic.clone(),
        display_namespace: args.display_namespace.clone().unwrap_or_else(|| namespace_of(&args.image_topic)),
        near_clip_m: 0.01,
    };
    match &args.display_config {
        Some(file) => add(file, &camera)?,
        None => print(&camera.block(INDENTATION, "\n"))?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints a text. A closed pipe, as of `head`, is no error.
fn print(text: &str) -> Result<()> {
    match io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(anyhow!("standard output: {error}")),
        _ => Ok(()),
    }
}

/// Namespace of a topic; without one, the topic's own name.
fn namespace_of(topic: &str) -> String {
    let name = topic.trim_matches('/');
    name.rsplit_once('/').map_or(name, |(namespace, _)| namespace).to_owned()
}

fn add(file: &Path, camera: &NewCamera) -> Result<()> {
    let source = file.display().to_string();
    // A link keeps leading to the file.
    let path = fs::canonicalize(file).with_context(|| source.clone())?;
    let text = read_text(&path, MAX_FILE_BYTES).with_context(|| source.clone())?;
    let extended = insert_camera(&text, &source, camera)?;
    let permissions = fs::metadata(&path).with_context(|| source.clone())?.permissions();
    let written = write_atomically(
        &path,
        |out| out.write_all(extended.as_bytes()).and_then(|()| out.get_ref().set_permissions(permissions.clone())),
        |error| error,
    );
    written.with_context(|| format!("{source}: cannot write"))?;
    let line = extended.lines().zip(text.lines()).take_while(|(after, before)| after == before).count() + 1;
    let NewCamera { name, camera_info_topic, image_topic, .. } = camera;
    print(&format!("{source}: added camera {name} in line {line}: {camera_info_topic} to {image_topic}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_namespace_is_that_of_the_image_topic() {
        let topics = ["/proj_view/image", "a/b/image", "/image", "image"];
        assert_eq!(topics.map(namespace_of), ["proj_view", "a/b", "image", "image"]);
    }
}
