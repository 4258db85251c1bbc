//! The golden cases: a bag with a config and messages, rviz's image, and a line of `cases.yaml` that says what they
//! show.
//!
//! `tests/golden/README.md` describes the files and fields. A field that is not known is an error, so that a misspelt
//! one is not silently without effect.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{bail, ensure, Context as _};
use saphyr_parser::{Event, Parser};

/// A scene and the image that rviz drew of it.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    /// Begins with the subject.
    pub(crate) name: String,
    /// The config, then TF, CameraInfo and the messages.
    pub(crate) bag: PathBuf,
    /// What rviz drew.
    pub(crate) image: PathBuf,
    /// What the case shows.
    pub(crate) about: String,
    /// The lowest *close* score that passes, 0 to 1.
    pub(crate) min_close: f64,
    /// The camera to draw, where the config has several.
    pub(crate) camera: Option<String>,
    /// ROS parameters as `NAME=FILE`.
    pub(crate) params: Vec<String>,
}

/// The lowest *close* score that passes if the case says nothing. Single pixels of rasterisation may lie farther than
/// one away. A lower one needs a reason.
const USUAL_MIN_CLOSE: f64 = 0.98;

/// The fields that describe how rviz's image was recorded. They are not needed to draw it.
const RECORDING: [&str; 5] = ["at", "freezes", "note", "unsubscribed_ok", "varies"];

/// The repository's root.
pub(crate) fn repository() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().unwrap_or(tests).to_owned()
}

/// The folder with the cases, and with the packages `conformance_assets` and `conformance_robots`.
pub(crate) fn golden() -> PathBuf {
    repository().join("tests/golden")
}

/// All cases by name.
///
/// # Errors
/// When there are none, the list cannot be read, or does not name just the files that there are.
pub(crate) fn all() -> anyhow::Result<Vec<Case>> {
    let (list, folder) = (golden().join("cases.yaml"), golden().join("cases"));
    let text = std::fs::read_to_string(&list).with_context(|| list.display().to_string())?;
    let cases = parse(&text, &folder).with_context(|| list.display().to_string())?;
    ensure!(!cases.is_empty(), "there are no cases in {}", list.display());
    let mut unnamed = BTreeSet::new();
    for entry in std::fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
        unnamed.insert(entry?.path());
    }
    for file in cases.iter().flat_map(|case| [&case.bag, &case.image]) {
        ensure!(unnamed.remove(file), "there is no {}", file.display());
    }
    ensure!(unnamed.is_empty(), "{} does not name {unnamed:?}", list.display());
    Ok(cases)
}

/// Checks a case's name and description.
///
/// # Errors
/// When the name is not in lower_snake_case or begins with a single letter, which would say nothing about the subject,
/// or when `about` is empty.
pub(crate) fn check_description(case: &Case) -> anyhow::Result<()> {
    let parts: Vec<&str> = case.name.split('_').collect();
    let is_word = |part: &&str| !part.is_empty() && part.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
    ensure!(parts.iter().all(is_word), "{}: the name is not in lower_snake_case", case.name);
    ensure!(parts[0].len() > 1, "{}: the name does not begin with its subject", case.name);
    ensure!(case.name.len() <= 50, "{}: the name is longer than 50 characters", case.name);
    ensure!(!case.about.trim().is_empty(), "{}: `about` is empty", case.name);
    Ok(())
}

/// The cases that the text of the list describes, with their files in `folder`.
///
/// # Errors
/// When it is no map of maps of plain values, a field is not known, or a low tolerance is without its reason.
pub(crate) fn parse(text: &str, folder: &Path) -> anyhow::Result<Vec<Case>> {
    let mut cases: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    for (path, value) in fields(text)? {
        let (name, field) = path.split_once('/').with_context(|| format!("`{path}` is no map"))?;
        cases.entry(name.to_owned()).or_default().insert(field.to_owned(), value);
    }
    cases.into_iter().map(|(name, fields)| case(&name, fields, folder).context(name)).collect()
}

fn case(name: &str, mut fields: BTreeMap<String, String>, folder: &Path) -> anyhow::Result<Case> {
    let min_close = match fields.remove("min_close") {
        Some(text) => text.parse().with_context(|| format!("min_close: {text}"))?,
        None => USUAL_MIN_CLOSE,
    };
    ensure!((0.0..=1.0).contains(&min_close), "min_close: {min_close} is not within 0 and 1");
    let has_reason = fields.remove("why").is_some_and(|why| !why.trim().is_empty());
    ensure!(has_reason || min_close >= USUAL_MIN_CLOSE, "min_close: {min_close} without a reason in `why`");
    let (about, camera) = (fields.remove("about").unwrap_or_default(), fields.remove("camera"));
    let mut params = Vec::new();
    for (field, value) in fields {
        if let Some(parameter) = field.strip_prefix("params/") {
            params.push(format!("{parameter}={value}"));
        } else {
            ensure!(RECORDING.contains(&field.as_str()), "unknown field `{field}`");
        }
    }
    let file = |extension| folder.join(format!("{name}.{extension}"));
    Ok(Case { name: name.to_owned(), bag: file("bag"), image: file("png"), about, min_close, camera, params })
}

/// The values of a YAML map; those of a map within it are named `OUTER/INNER`.
fn fields(text: &str) -> anyhow::Result<BTreeMap<String, String>> {
    let mut fields = BTreeMap::new();
    // The keys that lead to the next value, the innermost last.
    let mut keys: Vec<String> = Vec::new();
    let mut depth = 0;
    for event in Parser::new_from_str(text) {
        let (event, span) = event?;
        match event {
            Event::MappingStart(..) if depth == keys.len() => depth += 1,
            Event::MappingEnd => {
                depth -= 1;
                keys.pop();
            }
            Event::Scalar(text, ..) if keys.len() < depth => keys.push(text.into_owned()),
            Event::Scalar(text, ..) if depth > 0 => {
                let name = keys.join("/");
                ensure!(fields.insert(name.clone(), text.into_owned()).is_none(), "`{name}` is given twice");
                keys.pop();
            }
            Event::Nothing | Event::StreamStart | Event::StreamEnd | Event::DocumentStart(_) | Event::DocumentEnd => {}
            _ => bail!("line {}: only maps of plain values are expected", span.start.line()),
        }
    }
    Ok(fields)
}
