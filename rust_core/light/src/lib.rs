//! Whether, until when and where a projector may be lit.
//!
//! ```text
//!  a condition for each cause ─► Evidence ── decide(content, operator, now) ─┬─► DarkReason ─► black
//!  masks, keep-out frames ──────────┘                                        └─► Grant ─► Lit image ─► outputs
//! ```
//!
//! Light is granted, never assumed. Whoever shows something asks [`Evidence`], which holds a [`Condition`] for each
//! [`DarkCause`]; one that nobody has set is dark. The answer is a [`Grant`], which ends, or the reason for black. Only
//! [`Evidence::decide`] makes grants, and only a grant makes [`Lit`] content, which outputs take.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod blackout_file;
mod cause;
mod evidence;
mod grant;
mod measured;
mod pulse;

pub use blackout_file::{BlackoutFile, Blackouts};
pub use cause::{Content, DarkCause, DarkReason};
pub use evidence::{Condition, Evidence, LightRules};
pub use grant::{Generation, Grant, Lit};
pub use measured::{Measured, Now};
pub use pulse::Pulse;
