//! Checks of the limits of the data's age against the rates at which topics come.

use std::time::{Duration, Instant};

use super::finding::{secs, Finding};
use super::look::Look;
use crate::check::observed::Arrivals;
use crate::safety::ages::limits::AgeLimit;

/// Limit that is advised, as a multiple of the longest time between messages.
const ADVISED_GAPS: f64 = 3.0;

/// One finding for each topic of displays and cameras that has sent something or has a limit.
pub(super) fn all(look: &Look<'_>) -> Vec<Finding> {
    if look.limits.is_off() {
        return vec![Finding::good("limit", "none (stale_timeout): data are shown however old they are")];
    }
    let mut findings: Vec<Finding> = Vec::new();
    for request in look.scene.topics() {
        let Some(source) = look.subscriptions.source(&request.topic, request.kind) else { continue };
        let (limit, is_own) = look.limits.of([source.topic.as_str()]);
        let is_held = source.publishing.is_latched && !is_own;
        let topic = Topic { name: &source.topic, limit, is_held };
        let finding = topic.finding(look.observed.topics.get(source.topic.as_str()), look.listened, look.ended);
        if !findings.iter().any(|known| known.name == finding.name) {
            findings.push(finding);
        }
    }
    findings
}

/// A topic and its limit.
struct Topic<'a> {
    name: &'a str,
    limit: AgeLimit,
    /// A connected publisher latches and the topic has no limit of its own: its data do not age.
    is_held: bool,
}

impl Topic<'_> {
    /// The finding for what arrived in the time of listening that `ended` then.
    fn finding(&self, arrivals: Option<&Arrivals>, listened: Duration, ended: Instant) -> Finding {
        let name = format!("limit {}", self.name);
        let limit = match self.limit {
            AgeLimit::Never => return Finding::good(name, "never: its data do not age"),
            AgeLimit::Held => return Finding::good(name, "held: shown as long as it has a publisher"),
            AgeLimit::After(_) if self.is_held => {
                return Finding::good(name, "latched: shown as long as its publisher runs");
            }
            AgeLimit::After(limit) => limit,
        };
        let text = format!("the limit is {}", secs(limit.as_secs_f64()));
        let Some(arrivals) = arrivals else {
            let nothing = format!("no message in {}, {text}", secs(listened.as_secs_f64()));
            return Finding::unknown(name, nothing, "see whether its publisher sends (rostopic hz)");
        };
        let silence = ended.saturating_duration_since(arrivals.last);
        let longest = arrivals.longest_gap.max(silence);
        // Data are as old as this when the next come.
        let oldest = longest + arrivals.longest_delay;
        let comes = match arrivals.period() {
            Some(period) => format!("comes every {}", secs(period.as_secs_f64())),
            None => format!("came once in {} and is not latched", secs(listened.as_secs_f64())),
        };
        let comes = match arrivals.longest_delay {
            delay if delay > limit / 4 => format!("{comes}, up to {} old on arrival", secs(delay.as_secs_f64())),
            _ => comes,
        };
        if oldest > limit {
            let text = format!("{comes}, {text}: the light will flicker");
            return Finding::bad(name, text, self.advice(oldest));
        }
        if arrivals.count == 1 {
            return Finding::unknown(name, format!("{comes}, {text}"), "listen longer: --listen SECS");
        }
        Finding::good(name, format!("{comes}, {text}"))
    }

    /// Advice for data that are as old as this when the next come.
    fn advice(&self, oldest: Duration) -> String {
        let limit = (oldest.as_secs_f64() * ADVISED_GAPS).ceil().max(1.0);
        let topic = self.name;
        format!(
            "add {{topic: {topic}, limit: {limit}}} to stale_timeouts (--stale-timeouts {topic}={limit}), or limit: \
             held if it is sent only when it changes"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::observed::tests::arrivals;

    /// The line for messages at these seconds of five.
    fn line(limit: AgeLimit, is_held: bool, times_secs: &[f64], delay_secs: f64) -> String {
        let start = Instant::now();
        let seen = (!times_secs.is_empty()).then(|| arrivals(start, times_secs, delay_secs));
        let (listened, topic) = (Duration::from_secs(5), Topic { name: "/detections", limit, is_held });
        topic.finding(seen.as_ref(), listened, start + listened).to_string()
    }

    #[test]
    fn a_topic_that_comes_more_rarely_than_its_limit_flickers() {
        let second = AgeLimit::After(Duration::from_secs(1));
        let rare = line(second, false, &[0.5, 2.5, 4.5], 0.0);
        let expected = "✗ limit /detections: comes every 2 s, the limit is 1 s: the light will flicker; add {topic: \
                        /detections, limit: 6} to stale_timeouts (--stale-timeouts /detections=6), or limit: held if \
                        it is sent only when it changes";
        assert_eq!(rare, expected);
        let often: Vec<f64> = (0..50).map(|index| f64::from(index) * 0.1).collect();
        assert_eq!(line(second, false, &often, 0.05), "✓ limit /detections: comes every 0.1 s, the limit is 1 s");
        let late = line(second, false, &often, 1.5);
        assert!(
            late.starts_with("✗ limit /detections: comes every 0.1 s, up to 1.5 s old on arrival, the limit"),
            "{late}"
        );
        assert!(
            line(second, false, &[0.0], 0.0).starts_with("✗ limit /detections: came once in 5 s and is not latched")
        );
        assert!(line(second, false, &[4.9], 0.0).starts_with("? limit /detections: came once in 5 s"));
        assert!(line(second, false, &[], 0.0).starts_with("? limit /detections: no message in 5 s, the limit is 1 s"));
    }

    #[test]
    fn data_that_do_not_age_are_well_whenever_they_came() {
        let second = AgeLimit::After(Duration::from_secs(1));
        for (limit, is_held, text) in [
            (second, true, "latched: shown as long as its publisher runs"),
            (AgeLimit::Held, false, "held: shown as long as it has a publisher"),
            (AgeLimit::Never, false, "never: its data do not age"),
        ] {
            assert_eq!(line(limit, is_held, &[0.0], 0.0), format!("✓ limit /detections: {text}"));
        }
    }
}
