//! Numbers that are checked in serde's visitors, because only their errors have a line.

use std::fmt;

use serde::de::{Deserializer, Error as _, SeqAccess, Visitor};
use serde::Deserialize;

/// An integer from `MIN` to `MAX`.
#[derive(Clone, Copy)]
pub(crate) struct IntegerIn<const MIN: u32, const MAX: u32>(pub(crate) u32);

impl<'de, const MIN: u32, const MAX: u32> Deserialize<'de> for IntegerIn<MIN, MAX> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct IntegerVisitor<const MIN: u32, const MAX: u32>;
        impl<const MIN: u32, const MAX: u32> Visitor<'_> for IntegerVisitor<MIN, MAX> {
            type Value = IntegerIn<MIN, MAX>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                if MIN == MAX {
                    write!(f, "{MIN}")
                } else {
                    write!(f, "a whole number from {MIN} to {MAX}")
                }
            }

            fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<Self::Value, E> {
                match u32::try_from(number) {
                    Ok(fitting) if (MIN..=MAX).contains(&fitting) => Ok(IntegerIn(fitting)),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Unsigned(number), &self)),
                }
            }
        }
        deserializer.deserialize_u32(IntegerVisitor)
    }
}

/// The integer `N`.
pub(crate) type Exactly<const N: u32> = IntegerIn<N, N>;

/// A width or height, pixels.
pub(crate) type Size = IntegerIn<1, { u32::MAX }>;

/// Finite numbers, which may be a nested list of one row or of one column.
pub(crate) struct Numbers(pub(crate) Vec<f64>);

/// `N` finite numbers, which may be a nested list of rows.
#[derive(Clone, Copy)]
pub(crate) struct Matrix<const N: usize>(pub(crate) [f64; N]);

/// A finite number above zero.
#[derive(Clone, Copy)]
pub(crate) struct PositiveNumber(pub(crate) f64);

impl<'de> Deserialize<'de> for PositiveNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PositiveVisitor;
        impl Visitor<'_> for PositiveVisitor {
            type Value = PositiveNumber;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a finite number above 0")
            }

            fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<PositiveNumber, E> {
                self.visit_f64(number as f64)
            }

            fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<PositiveNumber, E> {
                self.visit_f64(number as f64)
            }

            fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<PositiveNumber, E> {
                if number.is_finite() && number > 0.0 {
                    Ok(PositiveNumber(number))
                } else {
                    Err(E::invalid_value(serde::de::Unexpected::Float(number), &self))
                }
            }
        }
        deserializer.deserialize_f64(PositiveVisitor)
    }
}

/// A number, or a row of a nested list.
enum Item {
    Number(f64),
    Row(Vec<f64>),
}

impl<'de> Deserialize<'de> for Item {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ItemVisitor;
        impl<'de> Visitor<'de> for ItemVisitor {
            type Value = Item;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a number")
            }

            fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<Item, E> {
                Ok(Item::Number(number as f64))
            }

            fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<Item, E> {
                Ok(Item::Number(number as f64))
            }

            fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<Item, E> {
                Ok(Item::Number(number))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Item, A::Error> {
                let mut row = Vec::new();
                while let Some(number) = list.next_element()? {
                    row.push(number);
                }
                Ok(Item::Row(row))
            }
        }
        deserializer.deserialize_any(ItemVisitor)
    }
}

/// Checks the lengths of a nested list's rows: those of a row, a column, or a matrix of three rows.
fn check_rows<E: serde::de::Error>(rows: &[usize], count: usize) -> Result<(), E> {
    let len = rows.first().copied().unwrap_or(1);
    let is_whole = rows.iter().all(|row| *row == len) && rows.len() * len == count;
    if rows.is_empty() || (is_whole && (rows.len() == 1 || len == 1 || (rows.len() == 3 && len >= 3))) {
        return Ok(());
    }
    Err(E::custom(format!("{count} numbers in {} rows where 3 rows of one length are needed", rows.len())))
}

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
        let (mut numbers, mut rows) = (Vec::new(), Vec::new());
        while let Some(item) = list.next_element()? {
            match item {
                Item::Number(number) => numbers.push(number),
                Item::Row(row) => {
                    rows.push(row.len());
                    numbers.extend(row);
                }
            }
        }
        if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
            return Err(A::Error::custom(format!("{number} is not a finite number")));
        }
        check_rows(&rows, numbers.len())?;
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
