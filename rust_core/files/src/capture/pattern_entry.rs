//! Keys common to `capture.yaml` and `patterns.yaml`: the projector's size and the list of patterns.

use std::collections::HashSet;
use std::fmt;

use rcs_calibration::patterns::{Axis, Pattern, Stripes};
use serde::de::{Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde::Deserialize;

use super::file_name::FileName;
use super::limits::{MOST_PATTERNS, MOST_PIXELS};
use crate::projector::checked_numbers::IntegerIn;

type Pixels = IntegerIn<1, MOST_PIXELS>;

/// Size of the projector's image.
#[derive(Deserialize)]
pub(super) struct ProjectorSize {
    width: Pixels,
    height: Pixels,
}

impl ProjectorSize {
    pub(super) fn size_px(&self) -> [u32; 2] {
        [self.width.0, self.height.0]
    }
}

/// A pattern and the file of its image.
#[derive(Debug)]
pub(super) struct PatternEntry {
    pub(super) file: FileName,
    pub(super) pattern: Pattern,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum PatternKind {
    White,
    Black,
    GrayCode,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum AxisName {
    X,
    Y,
}

/// Keys of an entry; white and black have none of those of Gray codes.
#[derive(Deserialize)]
struct RawEntry {
    file: FileName,
    kind: PatternKind,
    axis: Option<AxisName>,
    bits: Option<IntegerIn<1, { Stripes::MOST_BITS }>>,
    bit: Option<IntegerIn<0, { Stripes::MOST_BITS }>>,
    step: Option<IntegerIn<1, MOST_PIXELS>>,
    offset: Option<IntegerIn<0, { 2 * MOST_PIXELS }>>,
    inverted: Option<bool>,
}

impl RawEntry {
    fn pattern(&self) -> Result<Pattern, String> {
        fn needed<T>(key: &str, value: Option<T>) -> Result<T, String> {
            value.ok_or_else(|| format!("missing field `{key}`, which a gray_code needs"))
        }
        match self.kind {
            PatternKind::White => return Ok(Pattern::White),
            PatternKind::Black => return Ok(Pattern::Black),
            PatternKind::GrayCode => {}
        }
        let axis = match needed("axis", self.axis.as_ref())? {
            AxisName::X => Axis::X,
            AxisName::Y => Axis::Y,
        };
        let (IntegerIn(bits), IntegerIn(bit)) = (needed("bits", self.bits)?, needed("bit", self.bit)?);
        let (IntegerIn(step), IntegerIn(offset)) = (needed("step", self.step)?, needed("offset", self.offset)?);
        let inverted = needed("inverted", self.inverted)?;
        if bit >= bits {
            return Err(format!("there is no bit {bit} of {bits} (0 is the first)"));
        }
        Ok(Pattern::GrayCode(Stripes { axis, bits, bit, step, offset, inverted }))
    }
}

impl<'de> Deserialize<'de> for PatternEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PatternVisitor;
        impl<'de> Visitor<'de> for PatternVisitor {
            type Value = PatternEntry;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a pattern: {{file, kind: white|black|gray_code, axis, bits, bit, step, offset, inverted}}")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<PatternEntry, A::Error> {
                let raw = RawEntry::deserialize(serde::de::value::MapAccessDeserializer::new(map))?;
                let pattern = raw.pattern().map_err(A::Error::custom)?;
                Ok(PatternEntry { file: raw.file, pattern })
            }
        }
        deserializer.deserialize_map(PatternVisitor)
    }
}

/// The list of patterns: at least one, each with its own file.
pub(super) struct Patterns(pub(super) Vec<PatternEntry>);

impl<'de> Deserialize<'de> for Patterns {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ListVisitor;
        impl<'de> Visitor<'de> for ListVisitor {
            type Value = Patterns;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list of patterns")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Patterns, A::Error> {
                let mut entries: Vec<PatternEntry> = Vec::new();
                let mut files = HashSet::new();
                while let Some(entry) = list.next_element::<PatternEntry>()? {
                    if entries.len() == MOST_PATTERNS {
                        return Err(A::Error::custom(format!("more than {MOST_PATTERNS} patterns")));
                    }
                    if !files.insert(entry.file.clone()) {
                        return Err(A::Error::custom(format!("the file {:?} is listed twice", entry.file.as_str())));
                    }
                    entries.push(entry);
                }
                if entries.is_empty() {
                    return Err(A::Error::custom("the list is empty"));
                }
                Ok(Patterns(entries))
            }
        }
        deserializer.deserialize_seq(ListVisitor)
    }
}

/// Formats a line of a list of patterns.
pub(super) fn entry_line(file: &str, pattern: &Pattern) -> String {
    let keys = match pattern {
        Pattern::White => "white".to_owned(),
        Pattern::Black => "black".to_owned(),
        Pattern::GrayCode(Stripes { axis, bits, bit, step, offset, inverted }) => format!(
            "gray_code, axis: {}, bits: {bits}, bit: {bit}, step: {step}, offset: {offset}, inverted: {inverted}",
            axis.name()
        ),
    };
    format!("  - {{file: {file}, kind: {keys}}}\n")
}

/// Formats the first line of both files.
pub(super) fn projector_line([width, height]: [u32; 2]) -> String {
    format!("projector: {{width: {width}, height: {height}}}\n")
}

/// Checks that a list can be read again.
pub(super) fn check_writable<'a>(
    projector_px: [u32; 2],
    patterns: impl ExactSizeIterator<Item = &'a Pattern>,
) -> Result<(), String> {
    if projector_px.iter().any(|size| !(1..=MOST_PIXELS).contains(size)) {
        let [width, height] = projector_px;
        return Err(format!("a projector of {width}x{height} pixels; 1 to {MOST_PIXELS} are possible"));
    }
    if !(1..=MOST_PATTERNS).contains(&patterns.len()) {
        return Err(format!("{} patterns; 1 to {MOST_PATTERNS} are possible", patterns.len()));
    }
    let is_fine = |pattern: &Pattern| match pattern {
        Pattern::White | Pattern::Black => true,
        Pattern::GrayCode(stripes) => {
            (1..=Stripes::MOST_BITS).contains(&stripes.bits)
                && stripes.bit < stripes.bits
                && (1..=MOST_PIXELS).contains(&stripes.step)
                && stripes.offset <= 2 * MOST_PIXELS
        }
    };
    match patterns.enumerate().find(|(_, pattern)| !is_fine(pattern)) {
        Some((index, pattern)) => Err(format!("pattern {index} is invalid: {pattern:?}")),
        None => Ok(()),
    }
}
