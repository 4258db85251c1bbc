//! Statuses of stale displays and dark cameras.

use rcs_confirm::Shares;
use rcs_displays::Level;
use rcs_light::{DarkCause, DarkReason};

use crate::control::{Control, OperatorSettings};
use crate::safety::{Safety, STALE};
use crate::scene::status_tree::{EntryKind, StatusEntry};

/// Name of the status of confirmed light; the operator's page shows it by this name.
const SURFACE: &str = "Surface";

/// Adds a warning to stale displays, and an error to the scene if rules name cameras that do not exist. `is_paused` is
/// `true` for topics that are not received while nobody watches: their displays are stale for no other reason.
pub(crate) fn add(entries: &mut [StatusEntry<'_>], safety: &Safety, is_paused: impl Fn(&str) -> bool) {
    for entry in entries {
        if let (EntryKind::Global, Some(why)) = (entry.kind, safety.unmatched()) {
            entry.statuses.to_mut().set(Level::Error, "Cameras", format!("all cameras are dark: {why}"));
        }
        if is_paused(&entry.topic) {
            entry.values.push(("received", "not while nobody watches".to_owned()));
            continue;
        }
        let hidden = entry.display.zip(safety.assessment());
        if let Some(why) = hidden.and_then(|(id, assessment)| assessment.why_hidden(id, &entry.path)) {
            entry.statuses.to_mut().set(Level::Warn, STALE, format!("not drawn: {why}"));
        }
    }
}

/// Adds what the operator has set for all cameras.
pub(crate) fn add_operator(entries: &mut [StatusEntry<'_>], control: &Control) {
    let (control, share) = (control.state(), control.brightness().fade.target());
    for entry in entries.iter_mut().filter(|entry| entry.kind == EntryKind::Global) {
        let mut set = |name: &str, text: String| entry.statuses.to_mut().set(Level::Warn, name, text);
        control.blackout.iter().for_each(|caller| set("Blackout", format!("all cameras, by {caller}")));
        control.paused.iter().for_each(|caller| set("Pause", format!("all cameras, by {caller}")));
        control.test_image.iter().for_each(|test| set("Test picture", format!("{test}, in all cameras")));
        if share < 1.0 {
            set("Brightness", format!("{:.0} %, in all cameras", 100.0 * share));
        }
    }
}

/// Adds to a camera that it shows something else than the scene as it is.
pub(crate) fn add_substitute(entry: &mut StatusEntry<'_>, operator: &OperatorSettings) {
    let mut set = |name: &str, text: String| entry.statuses.to_mut().set(Level::Warn, name, text);
    operator.paused.iter().for_each(|caller| set("Pause", format!("paused by {caller}")));
    operator.test_image.iter().for_each(|test| set("Test picture", test.name().to_owned()));
    operator.pattern.iter().for_each(|_| set("Pattern", "a calibration shows patterns".to_owned()));
}

/// Adds which of a camera's light the measured surface confirms.
pub(crate) fn add_shares(entry: &mut StatusEntry<'_>, shares: &Shares) {
    let Shares { confirmed, blocked, gone, unseen } = *shares;
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    entry.values.extend([
        ("light confirmed %", percent(confirmed)),
        ("light blocked %", percent(blocked)),
        ("light of objects gone %", percent(gone)),
        ("light unseen %", percent(unseen)),
    ]);
    let whole = |share: f64| format!("{:.0} %", 100.0 * share);
    let text = match confirmed + blocked + gone + unseen > 0.0 {
        true => {
            let [confirmed, blocked, gone, unseen] = [confirmed, blocked, gone, unseen].map(whole);
            format!("{confirmed} of the light confirmed; blocked {blocked}, object gone {gone}, not seen {unseen}")
        }
        false => "no light to confirm".to_owned(),
    };
    entry.statuses.to_mut().set(Level::Ok, SURFACE, text);
}

/// Adds a camera's reason for a blackout.
pub(crate) fn add_dark(entry: &mut StatusEntry<'_>, dark: Option<&DarkReason>) {
    if let Some(dark) = dark {
        let level = if dark.cause.is_error() { Level::Error } else { Level::Warn };
        let name = match dark.cause {
            DarkCause::CameraData | DarkCause::Displays => STALE,
            _ => "Dark",
        };
        entry.statuses.to_mut().set(level, name, format!("the picture is black: {dark}"));
    }
}
