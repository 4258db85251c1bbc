//! The operator's page: what it shows and what it may do.
//!
//! ```text
//!   scene's thread ── statuses, once a second ──► PageStatuses ── state ──► pages
//!   outputs ── images ──────────────────────────► Images ─────────────────► pages
//!   pages ── POST ──► PageOperator ──► cameras, services
//! ```
//!
//! Nothing here works while no page is open. The server and its rules are [`rcs_web`]'s.

mod nudging;
pub(crate) mod operator;
mod parameters;
mod records;
mod start;
mod state;
pub(crate) mod statuses;

pub(crate) use start::start;
pub(crate) use statuses::PageStatuses;
