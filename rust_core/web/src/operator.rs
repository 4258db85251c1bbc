//! The contents and the requests of pages, as the server sees them.

use serde_json::Value;

/// Carries out what the pages ask for, and tells the state that they show.
pub trait Operator: Send + Sync + 'static {
    /// Returns `true` if [`post`](Self::post) never waits for this request. It is then carried out at once, on the
    /// server's thread; all others are carried out on a worker.
    fn is_immediate(&self, request: &str) -> bool;

    /// Carries out the request `POST /api/REQUEST`, and returns a sentence for the operator. `caller` names the page
    /// for logs: `the page at ADDRESS`.
    ///
    /// # Errors
    /// [`Refusal`].
    fn post(&self, request: &str, body: &Value, caller: &str) -> Result<String, Refusal>;

    /// The state that all pages show, as a JSON object of type `state`. Never waits.
    fn state(&self) -> String;

    /// The newest lines of the log after the one with this number, oldest first. Never waits.
    fn log_after(&self, id: u64) -> Vec<LogLine>;

    /// Called when the number of open pages or the cameras that they watch have changed.
    fn watchers_changed(&self);
}

/// A line of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct LogLine {
    /// Counts up from 1.
    pub id: u64,
    /// Seconds since 1970.
    pub time_secs: f64,
    /// `info`, `warn` or `error`.
    pub level: &'static str,
    /// Without control characters.
    pub text: String,
}

/// Why a request was not carried out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// There is no such request.
    #[error("there is no request '{0}'")]
    Unknown(String),
    /// The request's values cannot be used.
    #[error("{0}")]
    Invalid(String),
    /// It failed, or is not possible at present.
    #[error("{0}")]
    Failed(String),
}
