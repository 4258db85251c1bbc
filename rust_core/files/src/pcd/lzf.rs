//! LZF decompression of PCD's `binary_compressed` data.
//!
//! The format (Marc Lehmann's LibLZF) is a sequence of runs. A control byte `c` below 32 starts `c + 1` literal bytes.
//! Otherwise its upper three bits are a length (7: the next byte is added to it) and its lower five bits with one more
//! byte are a distance: `length + 2` bytes are repeated from `distance + 1` bytes before the end of what was
//! written; they may overlap what they write.

/// Compressed data are damaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(crate) enum LzfError {
    /// The data end in the middle of a run.
    #[error("the compressed data end in the middle of a run at byte {at}")]
    Truncated {
        /// Offset in the compressed data, bytes.
        at: usize,
    },
    /// A repetition starts before the first byte written.
    #[error("the compressed data repeat what was never written at byte {at}")]
    BadDistance {
        /// Offset in the compressed data, bytes.
        at: usize,
    },
    /// The data are longer or shorter than announced.
    #[error("the compressed data hold {got_bytes} bytes or more where {expected_bytes} are announced")]
    WrongLength {
        /// Bytes announced.
        expected_bytes: usize,
        /// Bytes written at the error.
        got_bytes: usize,
    },
}

/// Most bytes of three compressed bytes.
const LONGEST_RUN: usize = 7 + 255 + 2;

/// Decompresses `input` to exactly `expected_bytes` bytes. Memory is allocated only for what the input can hold.
///
/// # Errors
/// [`LzfError`].
pub(crate) fn decompress(input: &[u8], expected_bytes: usize) -> Result<Vec<u8>, LzfError> {
    let possible = input.len().saturating_mul(LONGEST_RUN) / 3 + LONGEST_RUN;
    let mut out: Vec<u8> = Vec::with_capacity(expected_bytes.min(possible));
    let mut at = 0;
    while let Some(&control) = input.get(at) {
        let run_start = at;
        let truncated = LzfError::Truncated { at: run_start };
        let mut next = || {
            at += 1;
            input.get(at).copied().map(usize::from).ok_or(truncated)
        };
        let control = usize::from(control);
        let run = if control < 32 {
            at += 1;
            let literals = input.get(at..at + control + 1).ok_or(truncated)?;
            out.extend_from_slice(literals);
            at += literals.len();
            continue_if_within(&out, expected_bytes)?;
            continue;
        } else {
            match control >> 5 {
                7 => 7 + next()?,
                length => length,
            }
        };
        let distance = ((control & 31) << 8 | next()?) + 1;
        at += 1;
        let length = run + 2;
        let mut from = out.len().checked_sub(distance).ok_or(LzfError::BadDistance { at: run_start })?;
        // The source may run into what is being written, so it is copied in pieces that exist already.
        let end = out.len() + length;
        while out.len() < end {
            let piece = (out.len() - from).min(end - out.len());
            out.extend_from_within(from..from + piece);
            from += piece;
        }
        continue_if_within(&out, expected_bytes)?;
    }
    if out.len() == expected_bytes {
        Ok(out)
    } else {
        Err(LzfError::WrongLength { expected_bytes, got_bytes: out.len() })
    }
}

fn continue_if_within(out: &[u8], expected_bytes: usize) -> Result<(), LzfError> {
    if out.len() > expected_bytes {
        return Err(LzfError::WrongLength { expected_bytes, got_bytes: out.len() });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn literals_repetitions_and_overlaps_are_expanded() {
        // "abc", then 5 bytes from 3 back (overlapping), then a long run of the last byte.
        let input = [2, b'a', b'b', b'c', 3 << 5, 2, 7 << 5, 1, 0];
        let expected = [b"abcabcab".as_slice(), &[b'b'; 10]].concat();
        assert_eq!(decompress(&input, 18).unwrap(), expected);
    }

    #[test]
    fn a_far_distance_uses_the_five_low_bits() {
        let text: Vec<u8> = (0..=255).cycle().take(640).collect();
        let mut input: Vec<u8> = Vec::new();
        for run in text.chunks(32) {
            input.push(31);
            input.extend_from_slice(run);
        }
        // Distance 600 = 2 * 256 + 88, stored less one.
        input.extend_from_slice(&[1 << 5 | 2, 87]);
        let out = decompress(&input, 643).unwrap();
        assert_eq!(out[640..], out[40..43]);
    }

    #[test]
    fn damage_is_named_by_its_place() {
        assert_eq!(decompress(&[4, 1, 2], 5), Err(LzfError::Truncated { at: 0 }));
        assert_eq!(decompress(&[0, 9, 1 << 5, 1], 4), Err(LzfError::BadDistance { at: 2 }));
        assert_eq!(decompress(&[0, 9, 1 << 5], 4), Err(LzfError::Truncated { at: 2 }));
        assert_eq!(decompress(&[1, 9, 9], 1), Err(LzfError::WrongLength { expected_bytes: 1, got_bytes: 2 }));
        assert!(decompress(&[], usize::MAX).is_err());
    }

    proptest! {
        #[test]
        fn any_bytes_end_in_an_answer(input in proptest::collection::vec(any::<u8>(), 0..300), expected in 0usize..2000) {
            if let Ok(out) = decompress(&input, expected) {
                prop_assert_eq!(out.len(), expected);
            }
        }

        #[test]
        fn literal_runs_give_the_bytes_back(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            let mut input = Vec::new();
            for run in bytes.chunks(32) {
                input.push(u8::try_from(run.len() - 1).unwrap());
                input.extend_from_slice(run);
            }
            prop_assert_eq!(decompress(&input, bytes.len()).unwrap(), bytes);
        }
    }
}
