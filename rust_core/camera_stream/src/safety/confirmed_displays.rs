//! The displays whose light a measured surface must confirm: all, none, or those of some names.

use rcs_displays::SceneState;
use rcs_node_support::near::near;
use rcs_scene::DisplayMask;

use super::names::{ConfigNames, NONE};

/// The value for all displays.
const ALL: &str = "all";

/// Displays whose light must be confirmed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ConfirmedDisplays {
    /// No display: nothing is confirmed.
    None,
    /// Every display. What is lit without a depth to compare stays dark.
    All,
    /// Displays of these names, and those in groups of these names.
    Named(Vec<String>),
}

impl ConfirmedDisplays {
    /// Reads the values of the option; without one all displays are confirmed.
    ///
    /// # Errors
    /// The value and what is wrong with it.
    pub(crate) fn read(texts: &[String], names: &ConfigNames) -> Result<Self, (String, String)> {
        match texts.iter().map(|text| text.trim()).collect::<Vec<_>>().as_slice() {
            [] | [ALL] => Ok(Self::All),
            [NONE] => Ok(Self::None),
            several if several.contains(&ALL) || several.contains(&NONE) => {
                Err((several.join(", "), format!("{ALL} and {NONE} stand alone")))
            }
            listed => match listed.iter().find_map(|name| Some((*name, problem(name, names)?))) {
                Some((name, problem)) => Err((name.to_owned(), problem)),
                None => Ok(Self::Named(listed.iter().map(|name| (*name).to_owned()).collect())),
            },
        }
    }

    /// The listed names that a config does not have, each with what it has; `None` if it has all.
    pub(super) fn unmatched(&self, names: &ConfigNames) -> Option<String> {
        let Self::Named(listed) = self else { return None };
        let problems: Vec<_> = listed.iter().filter_map(|name| problem(name, names)).collect();
        (!problems.is_empty()).then(|| problems.join("; "))
    }

    /// These displays of a set.
    pub(super) fn mask(&self, displays: &SceneState) -> DisplayMask {
        let mut mask = DisplayMask::all();
        if let Self::Named(listed) = self {
            for age in displays.ages() {
                mask.set(age.id, age.path.iter().any(|name| listed.contains(name)));
            }
        }
        mask
    }
}

/// Why a name cannot be listed; `None` if a display or group has it.
fn problem(name: &str, names: &ConfigNames) -> Option<String> {
    if names.displays.iter().any(|display| display == name) {
        return None;
    }
    let near = near(name, names.displays.iter().map(String::as_str));
    let hint = near.first().map(|near| format!(" did you mean '{near}'?")).unwrap_or_default();
    let all = match names.displays.as_slice() {
        [] => "it has none".to_owned(),
        displays => format!("displays: {}", displays.join(", ")),
    };
    Some(format!("the config has no display '{name}';{hint} {all}"))
}

#[cfg(test)]
mod tests {
    use rcs_resources::{MeshStore, PackageIndex};

    use super::*;

    #[test]
    fn a_group_stands_for_the_displays_in_it() {
        let config = "
Visualization Manager:
  Global Options: {Fixed Frame: map}
  Displays:
  - {Class: rviz/Grid, Name: floor, Enabled: true}
  - {Class: rviz/Group, Name: objects, Enabled: true, Displays: [{Class: rviz/Axes, Name: cup, Enabled: true}]}
";
        let config = rcs_rviz_config::parse(config, "test").unwrap();
        let set = SceneState::new(&config, None, MeshStore::new(PackageIndex::new([])));
        let shown = |listed: ConfirmedDisplays| {
            let mask = listed.mask(&set);
            set.ages().filter(|age| mask.shows(age.id)).map(|age| age.path.join("/")).collect::<Vec<_>>()
        };
        let named = |name: &str| ConfirmedDisplays::Named(vec![name.to_owned()]);
        assert_eq!(shown(named("objects")), ["objects/cup"]);
        assert_eq!(shown(named("floor")), ["floor"]);
        assert_eq!(shown(ConfirmedDisplays::All), ["floor", "objects/cup"]);
    }
}
