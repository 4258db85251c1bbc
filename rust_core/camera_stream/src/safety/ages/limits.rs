//! How old data may be: `~stale_timeout` and `~stale_timeouts`, the former for all topics, the latter for single ones.

use std::collections::HashMap;
use std::str::FromStr;
use std::time::Duration;

use rcs_node_support::key_value;

/// The topic by whose name the age of transforms is limited.
const TRANSFORMS: &str = "/tf";

/// How long the data of a topic may be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// So long after their stamp, and after they were received.
    After(Duration),
    /// While a publisher is connected, however old they are: for what is sent when it changes.
    Held,
    /// For ever.
    Never,
}

/// A value of `--stale-timeout`, or an element of `~stale_timeouts`: `SECS`, or `TOPIC=SECS`, `TOPIC=held` or
/// `TOPIC=never`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StaleTimeout {
    /// The topic as it was given; none for all topics.
    pub topic: Option<String>,
    /// Its limit.
    pub limit: Limit,
}

impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "held" => Ok(Self::Held),
            "never" => Ok(Self::Never),
            _ => {
                let secs = text.parse::<f64>().ok().filter(|secs| (0.0..=86_400.0).contains(secs));
                let secs = secs.ok_or_else(|| format!("{text} is not seconds from 0 (off) to 86400, held or never"))?;
                Ok(if secs > 0.0 { Self::After(Duration::from_secs_f64(secs)) } else { Self::Never })
            }
        }
    }
}

impl FromStr for StaleTimeout {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (topic, limit) =
            key_value::split(text).map_or((None, text), |(topic, limit)| (Some(topic.to_owned()), limit));
        match (&topic, limit.parse()?) {
            (Some(topic), _) if topic.trim_matches('/').is_empty() => Err(format!("{text}: no topic before the =")),
            (None, Limit::Held) => Err("held is for single topics: TOPIC=held".to_owned()),
            (_, limit) => Ok(Self { topic, limit }),
        }
    }
}

/// The limits of all topics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    general: Limit,
    /// By whole name.
    by_topic: HashMap<String, Limit>,
    /// Whether a black picture says why it is black.
    pub has_note: bool,
}

impl Limits {
    /// No limits.
    pub fn off() -> Self {
        Self { general: Limit::Never, by_topic: HashMap::new(), has_note: false }
    }

    /// Sets a limit. `whole_name` gives a topic's.
    ///
    /// # Errors
    /// Fails as `whole_name` does.
    pub fn set<E>(&mut self, timeout: StaleTimeout, whole_name: impl Fn(&str) -> Result<String, E>) -> Result<(), E> {
        match timeout.topic {
            None => self.general = timeout.limit,
            Some(topic) => {
                self.by_topic.insert(whole_name(&topic)?, timeout.limit);
            }
        }
        Ok(())
    }

    /// That of topics that have none of their own.
    pub(crate) fn for_all_topics(&self) -> Option<Duration> {
        match self.general {
            Limit::After(limit) => Some(limit),
            Limit::Held | Limit::Never => None,
        }
    }

    /// Whether nothing is ever too old.
    pub(super) fn is_off(&self) -> bool {
        self.general == Limit::Never && self.by_topic.values().all(|limit| *limit == Limit::Never)
    }

    /// That of data that come on these topics, by whole names; the strictest of those that were set for one of them.
    /// Also whether it was set for them.
    pub(super) fn of<'t>(&self, topics: impl IntoIterator<Item = &'t str>) -> (Limit, bool) {
        let rank = |limit: &Limit| match limit {
            Limit::After(duration) => *duration,
            Limit::Held => Duration::MAX - Duration::from_nanos(1),
            Limit::Never => Duration::MAX,
        };
        let own = topics.into_iter().filter_map(|topic| self.by_topic.get(topic)).min_by_key(|limit| rank(limit));
        own.map_or((self.general, false), |limit| (*limit, true))
    }

    /// That of frames that are not static.
    pub(super) fn of_transforms(&self) -> Option<Duration> {
        match self.of([TRANSFORMS]).0 {
            Limit::After(limit) => Some(limit),
            Limit::Held | Limit::Never => None,
        }
    }

    /// The same, with this limit for all topics that have none.
    pub(crate) fn or_after(self, limit: Duration) -> Self {
        let general = if self.general == Limit::Never { Limit::After(limit) } else { self.general };
        Self { general, ..self }
    }

    /// With one limit for all topics; the notes are on.
    #[cfg(test)]
    pub(super) fn general(limit: Duration) -> Self {
        Self { general: Limit::After(limit), by_topic: HashMap::new(), has_note: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timeout_is_for_all_topics_or_for_one() {
        let parse = |text: &str| text.parse::<StaleTimeout>();
        let after = |secs: f64| Limit::After(Duration::from_secs_f64(secs));
        let of = |topic: &str, limit| Ok(StaleTimeout { topic: Some(topic.to_owned()), limit });
        assert_eq!(parse("1"), Ok(StaleTimeout { topic: None, limit: after(1.0) }));
        assert_eq!(parse("0"), Ok(StaleTimeout { topic: None, limit: Limit::Never }));
        assert_eq!(parse("/cloud=0.25"), of("/cloud", after(0.25)));
        assert_eq!(parse("plan=held"), of("plan", Limit::Held));
        assert_eq!(parse("/map=never"), of("/map", Limit::Never));
        assert_eq!(parse("/map=0"), of("/map", Limit::Never));
        for wrong in ["", "-1", "nan", "soon", "held", "=1", "/=1", "/map=", "/map=-1", "1e9"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_topics_own_limit_counts_and_the_strictest_of_a_displays_topics() {
        let mut limits = Limits::general(Duration::from_secs(1));
        for text in ["/map=never", "/map_updates=3", "/plan=held", "/tf=0.5"] {
            limits.set(text.parse().unwrap(), |topic| Ok::<_, String>(topic.to_owned())).unwrap();
        }
        let after = |secs: f64| Limit::After(Duration::from_secs_f64(secs));
        assert_eq!(limits.of(["/cloud"]), (after(1.0), false));
        assert_eq!(limits.of(["/map"]), (Limit::Never, true));
        assert_eq!(limits.of(["/map", "/map_updates"]), (after(3.0), true));
        assert_eq!(limits.of(["/map", "/plan"]), (Limit::Held, true));
        assert_eq!(limits.of_transforms(), Some(Duration::from_millis(500)));
        assert!(!limits.is_off());
        let off = Limits { general: Limit::Never, by_topic: HashMap::new(), has_note: true };
        assert!(off.is_off() && off.of_transforms().is_none());
    }
}
