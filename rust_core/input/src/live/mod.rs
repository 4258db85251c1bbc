//! Live topics.
