//! Seeds of tests.

use std::ops::Range;

/// `true` if the environment variable `MANY_SEEDS` is set and not empty.
pub fn has_many_seeds() -> bool {
    std::env::var_os("MANY_SEEDS").is_some_and(|value| !value.is_empty())
}

/// Seeds from `first` on: a few, or many if [`has_many_seeds`].
pub fn seeds(first: u64, few: u64, many: u64) -> Range<u64> {
    first..first + if has_many_seeds() { many } else { few }
}
