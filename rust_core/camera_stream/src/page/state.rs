//! The state that all pages show, as JSON.

use rcs_messages::stamp_nanos;
use rcs_window::test_images::TestImage;
use serde_json::{json, Map, Value};

use super::nudging::Nudging;
use super::parameters;
use crate::camera::output::CameraPublisher;
use crate::runtime::shared::NodeState;
use crate::scene::status_tree::path_text;

/// The whole state of a node.
pub(super) fn state(shared: &NodeState, nudging: &Nudging) -> Value {
    // Before the state is read, so that a change meanwhile makes an answer void.
    let (clock_ms, number, control) = (rcs_web::clock_ms(), shared.control.number(), shared.control.state());
    let brightness = shared.control.brightness();
    let statuses = shared.page.statuses();
    let mut displays = statuses.displays.clone();
    let (mut cameras, mut servers) = (Vec::new(), Vec::new());
    for camera in shared.cameras().iter() {
        let name = camera.view().name.as_str();
        add_switches(&mut displays, camera);
        let of_camera = statuses.cameras.get(&path_text(&camera.view().path));
        let rate_hz = statuses.rate_hz(name);
        let mut json = camera_json(camera, rate_hz, of_camera);
        json["nudge"] = nudging.of_camera(name);
        let settings = shared.control.of_camera(name);
        json["blackout"] = json!(settings.is_switched_off);
        json["black"] = json!(settings.light.is_err());
        cameras.push(json);
        servers.extend(camera.servers().map(|server| parameters::server(server, name)));
    }
    drop(statuses);
    json!({
        "type": "state",
        "number": number,
        "clock_ms": clock_ms,
        "node": shared.ros.name(),
        "config": shared.config_name(),
        "version": env!("CARGO_PKG_VERSION"),
        "time": stamp_nanos(shared.ros.now()) as f64 * 1e-9,
        "blackout": by(control.blackout),
        "paused": by(control.paused),
        "test_picture": control.test_image,
        "test_pictures": TestImage::ALL.map(TestImage::name),
        "brightness": {"share": brightness.fade.target(), "fade_seconds": brightness.fade_secs},
        "cues": cues(shared),
        "cameras": cameras,
        "displays": displays,
        "reconfigure": servers,
    })
}

/// The cues, the current one, and what is wrong with their file.
fn cues(shared: &NodeState) -> Value {
    let (names, problem) = match shared.cues.known() {
        Ok(cues) => (cues.into_iter().map(|cue| cue.name).collect::<Vec<_>>(), None),
        Err(problem) => (Vec::new(), Some(problem)),
    };
    json!({"names": names, "current": shared.cues.current().map(|cue| cue.name), "problem": problem})
}

/// Something that holds for all cameras, and who has set it.
fn by(caller: Option<String>) -> Value {
    json!({"on": caller.is_some(), "by": caller.unwrap_or_default()})
}

fn camera_json(camera: &CameraPublisher, rate_hz: Option<f64>, statuses: Option<&Value>) -> Value {
    let figures = camera.figures();
    let view = camera.view();
    json!({
        "name": view.name,
        "parameters": camera.servers().next().map(|server| &**server.name()),
        "topic": figures.topic,
        "frame": figures.frame,
        "size": figures.size_px,
        "encoding": view.settings.image_encoding.name(),
        "rate_hz": rate_hz,
        "latency_ms": figures.latency_ms,
        "age_ms": figures.age_ms,
        "dark": figures.dark,
        "statuses": statuses.unwrap_or(&json!([])),
    })
}

/// Adds a camera's switches to the displays that they are for.
fn add_switches(displays: &mut [Value], camera: &CameraPublisher) {
    for (path, name, is_on) in camera.switches() {
        let path = path_text(path);
        let of_path = displays.iter_mut().filter(|display| display["path"] == path.as_str());
        for display in of_path {
            if let Some(switches) = display["switches"].as_object_mut() {
                add_switch(switches, &camera.view().name, name, is_on);
            }
        }
    }
}

fn add_switch(switches: &mut Map<String, Value>, camera: &str, name: &str, is_on: bool) {
    switches.insert(camera.to_owned(), json!({"name": name, "on": is_on}));
}
