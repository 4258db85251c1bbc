//! The gallery `docs/reference/displays.md`: its images are what the CPU renderer draws, and each display has its
//! section.
//!
//! An image `docs/images/displays/NAME.png` is that of the case NAME. `UPDATE_GALLERY=1` writes the images again.

use std::path::PathBuf;

use libtest_mimic::{Failed, Trial};

use crate::cases::{self, Case};
use crate::{load, render, score, SharedRenderer};

/// Classes of other packages have a section of their own.
const OTHER_PLUGINS: &str = "other plugins";

/// The lowest *close* score that passes between an image of the gallery and the one drawn now. Both are of the same
/// renderer, but floating point may be rounded differently on another processor.
const MIN_CLOSE: f64 = 0.999;

fn page() -> String {
    std::fs::read_to_string(cases::repository().join("docs/reference/displays.md")).unwrap_or_default()
}

fn image(name: &str) -> PathBuf {
    cases::repository().join("docs/images/displays").join(format!("{name}.png"))
}

/// The names of the cases whose images the page shows.
fn shown(page: &str) -> Vec<&str> {
    let mut names: Vec<&str> =
        page.split("images/displays/").skip(1).filter_map(|rest| Some(rest.split_once(".png")?.0)).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// One test for each image, and one for the sections.
pub(crate) fn trials(all: &[Case], cpu: &SharedRenderer) -> Vec<Trial> {
    let page = page();
    let mut trials = Vec::new();
    for name in shown(&page) {
        let (case, cpu) = (all.iter().find(|case| case.name == name).cloned(), cpu.clone());
        let name = name.to_owned();
        trials.push(Trial::test(format!("gallery::{name}"), move || {
            test(&case.ok_or_else(|| format!("there is no case {name}"))?, &cpu)
        }));
    }
    trials.push(Trial::test("gallery::sections", move || sections(&page)));
    trials
}

fn sections(page: &str) -> Result<(), Failed> {
    let classes = rcs_rviz_config::classes().iter().map(|class| class.name);
    for class in classes.chain([OTHER_PLUGINS]) {
        let heading = format!("\n## {class}\n");
        let (_, section) = page.split_once(&heading).ok_or_else(|| format!("no section {class}"))?;
        let section = section.split("\n## ").next().unwrap_or_default();
        if !section.contains("images/displays/") && !section.contains("No picture") {
            return Err(format!("the section {class} has no picture").into());
        }
    }
    Ok(())
}

fn test(case: &Case, cpu: &SharedRenderer) -> Result<(), Failed> {
    let file = image(&case.name);
    if std::env::var_os("UPDATE_GALLERY").is_some() {
        return render(case, &file, cpu).map_err(|error| format!("{error:#}").into());
    }
    let folder = tempfile::tempdir()?;
    let drawn = folder.path().join("drawn.png");
    render(case, &drawn, cpu).map_err(|error| format!("{error:#}"))?;
    let score = score::score(&load(&file)?, &load(&drawn)?).ok_or("another size")?;
    if score.close < MIN_CLOSE {
        return Err(format!("close {:.4}: draw it again with UPDATE_GALLERY=1", score.close).into());
    }
    Ok(())
}
