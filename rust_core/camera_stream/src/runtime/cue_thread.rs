//! Shows, saves and removes cues: named sets of visible displays with a brightness.
//!
//! A cue is checked as a whole before anything changes: one that names an unknown camera or display, or none for a
//! camera of the config, is an error.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result};
use rcs_files::cue_file::{cue_file, read_cues, write_cues, Cue};

use super::shared::NodeState;
use super::watchdog::Task;
use crate::camera::output::CameraPublisher;

/// Time between two looks at the file for pages, and at whether the current cue is still shown.
const PERIOD: Duration = Duration::from_secs(1);

/// Starts the thread that answers requests.
///
/// # Errors
/// One line: the topic `~set_cue`, or the thread.
pub(super) fn start(shared: &Arc<NodeState>) -> Result<()> {
    let cues = Arc::clone(&shared.cues);
    let ask = move |name: &str, caller: &str| cues.ask(Some(name), caller, Box::new(|_| ()));
    shared.ros.follow_texts("~set_cue", ask)?;
    let shared = Arc::clone(shared);
    let running = move || {
        let task = Task::watched("reading the cues");
        while !shared.is_ending() {
            let requests = shared.cues.requests.wait(PERIOD);
            task.begin();
            for request in requests {
                let shown = show(&shared, request.name.as_deref(), &request.caller);
                (request.done)(shown);
            }
            if shared.page.pages().is_any_open() {
                let _working = shared.cues.lock_file();
                // An error is on the page.
                let _ = read(&shared);
            }
            follow(&shared);
            task.wait_for_work();
        }
    };
    std::thread::Builder::new()
        .name("cues".to_owned())
        .spawn(running)
        .context("cannot start the thread of the cues")?;
    Ok(())
}

/// Shows a cue, or the one after the current one, after the last one the first. Returns its name.
///
/// # Errors
/// Why nothing has changed.
pub(crate) fn show(shared: &NodeState, name: Option<&str>, caller: &str) -> Result<String, String> {
    let _working = shared.cues.lock_file();
    let shown = read(shared).and_then(|cues| {
        let cue = pick(&cues, name, shared.cues.current().as_ref())?;
        apply(shared, cue, caller).map(|()| cue.name.clone())
    });
    match &shown {
        Ok(name) => log::info!("all cameras: cue {name} by {caller}"),
        Err(error) => log::error!("no cue is shown, and nothing changed: {error}; asked for by {caller}"),
    }
    shown
}

/// Saves what is shown now under a name, in place of a cue of that name.
///
/// # Errors
/// The file is damaged or cannot be written.
pub(crate) fn save(shared: &NodeState, name: &str, caller: &str) -> Result<(), String> {
    let brightness = shared.control.brightness().fade.target();
    let cue = Cue { name: name.to_owned(), brightness, cameras: shown(shared) };
    change(shared, |cues| match cues.iter_mut().find(|known| known.name == name) {
        Some(known) => *known = cue.clone(),
        None => cues.push(cue.clone()),
    })?;
    log::info!("cue {name} saved by {caller}");
    set_current(shared, Some(cue));
    Ok(())
}

/// Removes a cue from the file.
///
/// # Errors
/// As [`save`].
pub(crate) fn remove(shared: &NodeState, name: &str, caller: &str) -> Result<(), String> {
    change(shared, |cues| cues.retain(|cue| cue.name != name))?;
    log::info!("cue {name} removed by {caller}");
    follow(shared);
    Ok(())
}

/// Forgets the current cue once something else is shown or its cue is gone.
pub(crate) fn follow(shared: &NodeState) {
    if shared.cues.current().is_some_and(|cue| !is_shown(shared, &cue)) {
        set_current(shared, None);
    }
}

/// Reads the file, for pages too. Whoever calls it holds the file.
fn read(shared: &NodeState) -> Result<Vec<Cue>, String> {
    let read = read_cues(&cue_file(&shared.config_file())).map_err(|error| error.to_string());
    if shared.cues.set_known(read.clone()) {
        shared.page.pages().state_changed();
    }
    read
}

fn change(shared: &NodeState, change: impl FnOnce(&mut Vec<Cue>)) -> Result<(), String> {
    let _working = shared.cues.lock_file();
    let mut cues = read(shared)?;
    change(&mut cues);
    write_cues(&cue_file(&shared.config_file()), cues).map_err(|error| error.to_string())?;
    read(shared).map(|_| ())
}

/// The cue of a name, or the one after the current one.
fn pick<'c>(cues: &'c [Cue], name: Option<&str>, current: Option<&Cue>) -> Result<&'c Cue, String> {
    let index = |name: &str| cues.iter().position(|cue| cue.name == name);
    let found = match name {
        Some(name) => index(name),
        None => Some(current.and_then(|current| index(&current.name)).map_or(0, |index| (index + 1) % cues.len())),
    };
    let names = || cues.iter().map(|cue| cue.name.as_str()).collect::<Vec<_>>().join(", ");
    found.and_then(|index| cues.get(index)).ok_or_else(|| match name {
        Some(name) if !cues.is_empty() => format!("there is no cue '{name}'; cues: {}", names()),
        _ => "there are no cues; save some on the page, or write the file".to_owned(),
    })
}

/// Shows a cue: checks all of it first.
fn apply(shared: &NodeState, cue: &Cue, caller: &str) -> Result<(), String> {
    let wrong = |why: String| format!("cue {}: {why}", cue.name);
    let mut cameras = shared.cameras();
    let is_known = |name: &&String| cameras.iter().any(|camera| camera.view().name == **name);
    if let Some(unknown) = cue.cameras.keys().find(|name| !is_known(name)) {
        return Err(wrong(format!("the config has no camera {unknown}")));
    }
    let values = |camera: &CameraPublisher| {
        let name = &camera.view().name;
        let shown = cue.cameras.get(name).ok_or_else(|| format!("it says nothing about camera {name}"))?;
        camera.values_showing(shown).map_err(|why| format!("camera {name}: {why}"))
    };
    let values: Vec<_> = cameras.iter().map(values).collect::<Result<_, _>>().map_err(wrong)?;
    let dark = shared.settings().set_brightness(&shared.ros, &shared.control, cue.brightness, caller);
    dark.map_err(wrong)?;
    for (camera, (server, values)) in cameras.iter_mut().zip(values) {
        camera.reconfigure(&server, &values, caller);
    }
    drop(cameras);
    set_current(shared, Some(cue.clone()));
    shared.ros.events().wake();
    Ok(())
}

/// Keeps which cue is shown, and tells it on the topic, on dynamic_reconfigure and on pages.
fn set_current(shared: &NodeState, cue: Option<Cue>) {
    let name = cue.as_ref().map(|cue| cue.name.clone()).unwrap_or_default();
    shared.settings().set_cue(&shared.ros, &shared.control, name);
    shared.cues.set_current(cue);
    shared.page.pages().state_changed();
}

/// The displays that each camera shows.
fn shown(shared: &NodeState) -> BTreeMap<String, Vec<String>> {
    shared.cameras().iter().map(|camera| (camera.view().name.clone(), camera.shown_displays())).collect()
}

fn is_shown(shared: &NodeState, cue: &Cue) -> bool {
    let sets = |cameras: &BTreeMap<String, Vec<String>>| -> Vec<(String, BTreeSet<String>)> {
        cameras.iter().map(|(camera, displays)| (camera.clone(), displays.iter().cloned().collect())).collect()
    };
    let is_known = !matches!(shared.cues.known(), Ok(cues) if !cues.iter().any(|known| known.name == cue.name));
    let share = shared.control.brightness().fade.target();
    is_known && share == cue.brightness && sets(&shown(shared)) == sets(&cue.cameras)
}
