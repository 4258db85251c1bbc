//! Numbers of the file, checked while they are read: ranges, finiteness, how many. The checks are made in serde's
//! visitors, because an error has a line only if a visitor returns it.

use std::fmt;

use serde::de::{Deserializer, Error as _, SeqAccess, Visitor};
use serde::Deserialize;

/// A whole number from `MIN` to `MAX`.
#[derive(Clone, Copy)]
pub(super) struct Whole<const MIN: u32, const MAX: u32>(pub(super) u32);

impl<'de, const MIN: u32, const MAX: u32> Deserialize<'de> for Whole<MIN, MAX> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WholeVisitor<const MIN: u32, const MAX: u32>;
        impl<const MIN: u32, const MAX: u32> Visitor<'_> for WholeVisitor<MIN, MAX> {
            type Value = Whole<MIN, MAX>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                if MIN == MAX {
                    write!(f, "{MIN}")
                } else {
                    write!(f, "a whole number from {MIN} to {MAX}")
                }
            }

            fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<Self::Value, E> {
                match u32::try_from(number) {
                    Ok(fitting) if (MIN..=MAX).contains(&fitting) => Ok(Whole(fitting)),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Unsigned(number), &self)),
                }
            }
        }
        deserializer.deserialize_u32(WholeVisitor)
    }
}

/// A width or height, in pixels.
pub(super) type Size = Whole<1, { u32::MAX }>;

/// Finite numbers.
pub(super) struct Numbers(pub(super) Vec<f64>);

/// `N` finite numbers.
#[derive(Clone, Copy)]
pub(super) struct Matrix<const N: usize>(pub(super) [f64; N]);

struct NumbersVisitor {
    wanted: Option<usize>,
}

impl<'de> Visitor<'de> for NumbersVisitor {
    type Value = Vec<f64>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.wanted {
            Some(wanted) => write!(f, "a list of {wanted} numbers"),
            None => write!(f, "a list of numbers"),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<f64>, A::Error> {
        let mut numbers = Vec::new();
        while let Some(number) = list.next_element::<f64>()? {
            if !number.is_finite() {
                return Err(A::Error::custom(format!("{number} is not a finite number")));
            }
            numbers.push(number);
        }
        match self.wanted {
            Some(wanted) if wanted != numbers.len() => {
                Err(A::Error::custom(format!("{} numbers where {wanted} are needed", numbers.len())))
            }
            _ => Ok(numbers),
        }
    }
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(NumbersVisitor { wanted: None }).map(Self)
    }
}

impl<'de, const N: usize> Deserialize<'de> for Matrix<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let numbers = deserializer.deserialize_seq(NumbersVisitor { wanted: Some(N) })?;
        let too_few = |numbers: Vec<f64>| D::Error::invalid_length(numbers.len(), &"another number of values");
        numbers.try_into().map(Self).map_err(too_few)
    }
}
