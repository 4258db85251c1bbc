//! The plan: everything that the written files depend on.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use crate::answers::Answers;
use crate::display_type::DisplayType;
use crate::found::Rate;

/// Shortest age limit, seconds: that of the package's launch files.
pub(crate) const LIMIT_SECS: f64 = 1.0;
/// Messages of a topic that may be missing before it is stale.
const INTERVALS: f64 = 3.0;

/// From when a topic's data are too old to be projected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Limit {
    /// As long as there is a publisher.
    Held,
    /// Age in seconds.
    Secs(f64),
}

/// A topic to project.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Projected {
    pub(crate) topic: String,
    pub(crate) display: &'static DisplayType,
    pub(crate) limit: Limit,
}

/// The answers with what follows from them.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// Absolute path of the folder.
    pub(crate) folder: PathBuf,
    pub(crate) answers: Answers,
    pub(crate) projected: Vec<Projected>,
    /// Whether a grid and the frames' names are projected.
    pub(crate) is_try: bool,
}

impl Plan {
    /// The plan for a folder; `rates` are those that could be measured.
    pub(crate) fn new(folder: PathBuf, answers: Answers, rates: &BTreeMap<String, Rate>, is_try: bool) -> Self {
        let limited = |(topic, display): &(String, &'static DisplayType)| Projected {
            topic: topic.clone(),
            display,
            limit: limit(rates.get(topic).copied(), display),
        };
        let projected: Vec<Projected> = answers.topics.iter().map(limited).collect();
        let is_try = is_try || projected.is_empty();
        Self { folder, answers, projected, is_try }
    }

    /// Absolute path of a file.
    pub(crate) fn path(&self, file: &str) -> String {
        self.folder.join(file).display().to_string()
    }
}

/// The limit that fits a topic's rate, else its type.
fn limit(rate: Option<Rate>, display: &DisplayType) -> Limit {
    match rate {
        Some(Rate::Latched) => Limit::Held,
        Some(Rate::Every(interval)) => Limit::Secs(fitting_secs(interval)),
        None if display.is_event => Limit::Held,
        None => Limit::Secs(LIMIT_SECS),
    }
}

/// Several intervals, rounded up to tenths.
fn fitting_secs(interval: Duration) -> f64 {
    ((INTERVALS * interval.as_secs_f64() * 10.0).ceil() / 10.0).max(LIMIT_SECS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display_type::find;

    #[test]
    fn a_limit_fits_the_rate_and_without_one_the_type() {
        let of = |rate, name| limit(rate, find(name).unwrap());
        let every = |secs| Some(Rate::Every(Duration::from_secs_f64(secs)));
        assert_eq!(of(Some(Rate::Latched), "PointCloud2"), Limit::Held);
        assert_eq!(of(every(0.03), "PointCloud2"), Limit::Secs(1.0));
        assert_eq!(of(every(2.01), "MarkerArray"), Limit::Secs(6.1));
        assert_eq!(of(None, "PointCloud2"), Limit::Secs(1.0));
        assert_eq!(of(None, "MarkerArray"), Limit::Held);
    }
}
