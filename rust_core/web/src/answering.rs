//! Whether a request that may light answers the present state.
//!
//! Each state has a number and the node's clock (`number`, `clock_ms`). Such a request carries the number of the state
//! that the operator saw, and the clock when they pressed (`sent_ms`), which the page reckons from the time at which
//! that state came: a state that was late makes the request older, never younger.

use rustix::time::{clock_gettime, ClockId};
use serde_json::Value;

use crate::operator::Refusal;

/// Age from which a request that may light is void.
const MOST_AGE_MS: f64 = 2000.0;
/// The page's clock may be this coarse.
const CLOCK_TOLERANCE_MS: f64 = 200.0;

/// The clock of the states in milliseconds: the time since the machine started, sleep included.
pub fn clock_ms() -> f64 {
    let now = clock_gettime(ClockId::Boottime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

/// The number of the state that a request answers.
///
/// # Errors
/// It has no number or no time, is older than two seconds, or is from the future.
pub fn answered_number(body: &Value) -> Result<u64, Refusal> {
    number_at(body, clock_ms())
}

fn number_at(body: &Value, now_ms: f64) -> Result<u64, Refusal> {
    let missing = |key: &str| Refusal::Invalid(format!("{key}: missing; the state has it"));
    let number = body["number"].as_u64().ok_or_else(|| missing("number"))?;
    let age_ms = now_ms - body["sent_ms"].as_f64().ok_or_else(|| missing("sent_ms"))?;
    if age_ms > MOST_AGE_MS {
        return Err(Refusal::Failed(format!("it is older than 2 s: {:.1} s; press again", age_ms * 1e-3)));
    }
    if age_ms < -CLOCK_TOLERANCE_MS {
        return Err(Refusal::Failed("it is from the future of the node's clock; load the page again".to_owned()));
    }
    Ok(number)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_request_that_may_light_is_void_after_two_seconds_and_never_from_the_future() {
        let at = |now_ms| number_at(&json!({"number": 7, "sent_ms": 10_000.5}), now_ms);
        assert_eq!([at(10_000.5), at(12_000.0), at(9_900.0)], [Ok(7), Ok(7), Ok(7)]);
        assert_eq!(at(12_001.0), Err(Refusal::Failed("it is older than 2 s: 2.0 s; press again".to_owned())));
        assert!(matches!(at(9_000.0), Err(Refusal::Failed(why)) if why.contains("future")));
    }

    #[test]
    fn a_request_without_number_or_time_is_invalid() {
        let whole = json!({"number": 7, "sent_ms": 1.0});
        assert_eq!(number_at(&whole, 1.0), Ok(7));
        for (key, value) in
            [("number", json!(null)), ("number", json!(-1)), ("sent_ms", json!(null)), ("sent_ms", json!("1"))]
        {
            let mut body = whole.clone();
            body[key] = value;
            assert!(matches!(number_at(&body, 1.0), Err(Refusal::Invalid(why)) if why.contains(key)), "{body}");
        }
    }
}
