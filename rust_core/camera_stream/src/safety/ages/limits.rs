//! Limits of the age of data: `~stale_timeout` for all topics, `~stale_timeouts` for single ones.

use std::collections::HashMap;
use std::str::FromStr;
use std::time::Duration;

use rcs_node_support::key_value;

/// The topic by whose name the age of transforms is limited.
const TRANSFORMS: &str = "/tf";

/// The age up to which the data of a topic are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AgeLimit {
    /// This time after their stamp, and after they were received.
    After(Duration),
    /// While a publisher is connected: for data that are sent when they change.
    Held,
    /// Any age.
    Never,
}

/// A limit of all topics, `SECS`, or of one: `TOPIC=SECS`, `TOPIC=held` or `TOPIC=never`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct StaleTimeout {
    /// The topic as it was given; `None` for all topics.
    pub(crate) topic: Option<String>,
    /// The limit.
    pub(crate) limit: AgeLimit,
}

impl FromStr for AgeLimit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "held" => Ok(Self::Held),
            "never" => Ok(Self::Never),
            _ => Self::of_secs(text),
        }
    }
}

impl AgeLimit {
    /// A limit in seconds; 0 is none.
    ///
    /// # Errors
    /// One line that names the text.
    pub(crate) fn of_secs(text: &str) -> Result<Self, String> {
        let secs = text.parse::<f64>().ok().filter(|secs| (0.0..=86_400.0).contains(secs));
        let secs = secs.ok_or_else(|| format!("{text} is not seconds from 0 (off) to 86400, held or never"))?;
        Ok(if secs > 0.0 { Self::After(Duration::from_secs_f64(secs)) } else { Self::Never })
    }
}

impl FromStr for StaleTimeout {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (topic, limit) =
            key_value::split(text).map_or((None, text), |(topic, limit)| (Some(topic.to_owned()), limit));
        match (&topic, limit.parse()?) {
            (Some(topic), _) if topic.trim_matches('/').is_empty() => Err(format!("{text}: no topic before the =")),
            (None, AgeLimit::Held) => Err("held is for single topics: TOPIC=held".to_owned()),
            (_, limit) => Ok(Self { topic, limit }),
        }
    }
}

/// The limits of all topics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct AgeLimits {
    general: AgeLimit,
    /// By whole name.
    by_topic: HashMap<String, AgeLimit>,
    /// `true` if a black image says why it is black.
    pub(crate) has_note: bool,
}

impl AgeLimits {
    /// No limits.
    pub(crate) fn off() -> Self {
        Self { general: AgeLimit::Never, by_topic: HashMap::new(), has_note: false }
    }

    /// Sets a limit. `whole_name` gives a topic's.
    ///
    /// # Errors
    /// Fails as `whole_name` does.
    pub(crate) fn set<E>(
        &mut self,
        timeout: StaleTimeout,
        whole_name: impl Fn(&str) -> Result<String, E>,
    ) -> Result<(), E> {
        match timeout.topic {
            None => self.general = timeout.limit,
            Some(topic) => {
                self.by_topic.insert(whole_name(&topic)?, timeout.limit);
            }
        }
        Ok(())
    }

    /// Limit of topics that have none of their own.
    pub(crate) fn for_all_topics(&self) -> Option<Duration> {
        match self.general {
            AgeLimit::After(limit) => Some(limit),
            AgeLimit::Held | AgeLimit::Never => None,
        }
    }

    /// `true` if nothing becomes stale.
    pub(crate) fn is_off(&self) -> bool {
        self.general == AgeLimit::Never && self.by_topic.values().all(|limit| *limit == AgeLimit::Never)
    }

    /// The strictest limit of these topics, by whole names, and whether one of them has a limit of its own.
    pub(crate) fn of<'t>(&self, topics: impl IntoIterator<Item = &'t str>) -> (AgeLimit, bool) {
        let rank = |limit: &AgeLimit| match limit {
            AgeLimit::After(duration) => *duration,
            AgeLimit::Held => Duration::MAX - Duration::from_nanos(1),
            AgeLimit::Never => Duration::MAX,
        };
        let own = topics.into_iter().filter_map(|topic| self.by_topic.get(topic)).min_by_key(|limit| rank(limit));
        own.map_or((self.general, false), |limit| (*limit, true))
    }

    /// Limit of frames that are not static.
    pub(crate) fn of_transforms(&self) -> Option<Duration> {
        match self.of([TRANSFORMS]).0 {
            AgeLimit::After(limit) => Some(limit),
            AgeLimit::Held | AgeLimit::Never => None,
        }
    }

    /// Limit of a measurement: the topic's own, else `general`. Measurements always age, so `held` and `never` do not
    /// count.
    pub(crate) fn of_measurement(&self, topic: &str, general: Duration) -> Duration {
        match self.by_topic.get(topic) {
            Some(AgeLimit::After(limit)) => *limit,
            Some(AgeLimit::Held | AgeLimit::Never) | None => general,
        }
    }

    /// `true` if a topic's own limit is none, so that its data never age by time.
    pub(crate) fn is_endless(&self, topic: &str) -> bool {
        matches!(self.by_topic.get(topic), Some(AgeLimit::Held | AgeLimit::Never))
    }

    /// Limit of moving frames that a measurement follows: that of `/tf`, else that of all topics, else `general`.
    pub(crate) fn of_measured_frames(&self, general: Duration) -> Duration {
        self.of_measurement(TRANSFORMS, self.for_all_topics().unwrap_or(general))
    }

    /// One limit for all topics; the notes are on.
    pub(in crate::safety) fn general(limit: Duration) -> Self {
        Self { general: AgeLimit::After(limit), by_topic: HashMap::new(), has_note: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timeout_is_for_all_topics_or_for_one() {
        let parse = |text: &str| text.parse::<StaleTimeout>();
        let after = |secs: f64| AgeLimit::After(Duration::from_secs_f64(secs));
        let of = |topic: &str, limit| Ok(StaleTimeout { topic: Some(topic.to_owned()), limit });
        assert_eq!(parse("1"), Ok(StaleTimeout { topic: None, limit: after(1.0) }));
        assert_eq!(parse("0"), Ok(StaleTimeout { topic: None, limit: AgeLimit::Never }));
        assert_eq!(parse("/cloud=0.25"), of("/cloud", after(0.25)));
        assert_eq!(parse("plan=held"), of("plan", AgeLimit::Held));
        assert_eq!(parse("/map=never"), of("/map", AgeLimit::Never));
        assert_eq!(parse("/map=0"), of("/map", AgeLimit::Never));
        for wrong in ["", "-1", "nan", "soon", "held", "=1", "/=1", "/map=", "/map=-1", "1e9"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_topics_own_limit_counts_and_the_strictest_of_a_displays_topics() {
        let mut limits = AgeLimits::general(Duration::from_secs(1));
        for text in ["/map=never", "/map_updates=3", "/plan=held", "/tf=0.5"] {
            limits.set(text.parse().unwrap(), |topic| Ok::<_, String>(topic.to_owned())).unwrap();
        }
        let after = |secs: f64| AgeLimit::After(Duration::from_secs_f64(secs));
        assert_eq!(limits.of(["/cloud"]), (after(1.0), false));
        assert_eq!(limits.of(["/map"]), (AgeLimit::Never, true));
        assert_eq!(limits.of(["/map", "/map_updates"]), (after(3.0), true));
        assert_eq!(limits.of(["/map", "/plan"]), (AgeLimit::Held, true));
        assert_eq!(limits.of_transforms(), Some(Duration::from_millis(500)));
        assert!(!limits.is_off());
        let off = AgeLimits { general: AgeLimit::Never, by_topic: HashMap::new(), has_note: true };
        assert!(off.is_off() && off.of_transforms().is_none());
    }
}
