//! XML-RPC, as far as ROS uses it: values, calls with a time limit, and the two sides' documents.
//!
//! ROS answers every call with the array `[code, text, value]`; [`call`] takes that apart.

mod value;

pub use value::{parse_call, parse_response, response_document, Value, XmlError};

use value::call_document;

/// Why a call brought no value.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// Nobody answered, or not in time.
    #[error("no answer from {uri} to {method}: {source}")]
    Transport {
        /// Whom it was sent to.
        uri: String,
        /// What was called.
        method: String,
        /// What the HTTP client says.
        source: minreq::Error,
    },
    /// The answer was not the one that ROS prescribes.
    #[error("bad answer from {uri} to {method}: {reason}")]
    Answer {
        /// Whom it was sent to.
        uri: String,
        /// What was called.
        method: String,
        /// What is wrong.
        reason: String,
    },
    /// The other side said no.
    #[error("{uri} refused {method}: {reason}")]
    Refused {
        /// Whom it was sent to.
        uri: String,
        /// What was called.
        method: String,
        /// Its words.
        reason: String,
    },
}

/// Calls `method` at `uri` and waits at most `timeout_secs`.
pub fn call(uri: &str, method: &str, params: &[Value], timeout_secs: u64) -> Result<Value, CallError> {
    let bad = |reason: String| CallError::Answer { uri: uri.to_owned(), method: method.to_owned(), reason };
    let response = minreq::post(uri)
        .with_header("Content-Type", "text/xml")
        .with_body(call_document(method, params))
        .with_timeout(timeout_secs)
        .send()
        .map_err(|source| CallError::Transport { uri: uri.to_owned(), method: method.to_owned(), source })?;
    if response.status_code != 200 {
        return Err(bad(format!("HTTP status {}", response.status_code)));
    }
    let text = String::from_utf8_lossy(response.as_bytes());
    let value = parse_response(&text).map_err(|error| bad(error.to_string()))?;
    let Value::Array(parts) = value else {
        return Err(bad("no array".to_owned()));
    };
    match <[Value; 3]>::try_from(parts) {
        Ok([Value::Int(1), _, value]) => Ok(value),
        Ok([Value::Int(_), Value::String(reason), _]) => {
            Err(CallError::Refused { uri: uri.to_owned(), method: method.to_owned(), reason })
        }
        _ => Err(bad("not [code, text, value]".to_owned())),
    }
}
