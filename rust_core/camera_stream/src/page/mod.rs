//! The operator's page: what it shows and what it may do.
//!
//! ```text
//!   scene's thread ── statuses, once a second ──► Board ── state ──► pages
//!   outputs ── images ──────────────────────────► Images ──────────► pages
//!   pages ── POST ──► PageOperator ──► cameras, services
//! ```
//!
//! Nothing here works while no page is open. The server and its rules are [`rcs_web`]'s.

pub(crate) mod board;
mod nudging;
pub(crate) mod operator;
mod parameters;
mod start;
mod state;

pub(crate) use board::Board;
pub(crate) use start::start;
