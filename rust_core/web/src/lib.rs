//! The operator's page: a small HTTP server with one WebSocket for each page that is open.
//!
//! ```text
//!   camera's thread ── offer ──► Images ── job ──► encoder's thread
//!                                   │ encoded once for all pages
//!   browser ◄── WebSocket: images, state, log ── server's thread ◄── Operator::state, log_after
//!   browser ─── POST ──► server's thread ──► Operator::post: blackout at once, all else on a worker
//!   browser ─── Black, over the WebSocket, too ──► Operator::post
//! ```
//!
//! One thread serves everything with tokio; it sleeps while no page is open. A page gets an image only after it has
//! shown the one before (`ready`), so that a slow page skips images and delays nobody. Writes are POSTs of their own
//! connections, so that a blackout never queues behind a stream. Black has the open WebSocket as a second road, which
//! is read also while images are sent. What may light answers a state ([`answered_number`]).
//!
//! Access ([`Access`]): the page's files are for everybody who may connect, the API needs a token. Names in `Host` are
//! checked against DNS rebinding, and `Origin` against other sites. Sizes, times and the number of connections are
//! limited ([`Limits`]); half of these are kept for those with the token.
//!
//! This crate knows neither ROS nor cameras: an [`Operator`] carries out what the pages ask for, and tells the state.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod access;
mod answering;
mod connections;
mod images;
mod limits;
mod operator;
mod page_socket;
mod pages;
mod requests;
mod server;
mod token;

pub use access::Access;
pub use answering::{answered_number, clock_ms};
pub use images::{EncodingJob, ImageFile, ImageFormat, Images};
pub use limits::Limits;
pub use operator::{LogLine, Operator, Refusal};
pub use pages::Pages;
pub use server::Server;
pub use token::{Token, TokenError};
