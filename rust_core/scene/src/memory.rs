//! Memory of pictures: reused blocks that may be large.

/// Size from which glibc maps a block by itself, so that it goes back to the system as soon as it is freed. Smaller
/// ones may stay once one of their size has been freed (mallopt(3), M_MMAP_THRESHOLD, which rises to 32 MiB at most).
/// Unused parts of a block cost addresses only.
const MAPPED_ALONE_BYTES: usize = 33 << 20;
/// Blocks from this size on are made that large. It is over a quarter of that, so that [`give_back_block`] leaves them.
const LARGE_BYTES: usize = 9 << 20;

/// Resizes `data`, with any of its old elements or `blank`. Keeps its memory, unless that is several times too large.
pub fn resize_block<T: Copy>(data: &mut Vec<T>, len: usize, blank: T) {
    give_back_block(data, len);
    if data.capacity() < len {
        let bytes = len.saturating_mul(size_of::<T>());
        let least_bytes = if bytes < LARGE_BYTES { 0 } else { MAPPED_ALONE_BYTES };
        // Not one that grows: what it holds is not needed, and would be copied.
        *data = Vec::with_capacity(len.max(least_bytes.div_ceil(size_of::<T>().max(1))));
    }
    data.resize(len, blank);
}

/// Frees the memory and elements of `data` if that is several times what `len` elements need.
pub(crate) fn give_back_block<T>(data: &mut Vec<T>, len: usize) {
    const MOST_UNUSED_BYTES: usize = 1 << 20;
    let [owned, needed] = [data.capacity(), len].map(|count| count.saturating_mul(size_of::<T>()));
    if owned > needed.saturating_mul(4).saturating_add(MOST_UNUSED_BYTES) {
        *data = Vec::new();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_kept_for_similar_lengths_and_given_back_for_small_ones() {
        let mut data = Vec::new();
        for len in [3000, 12_000_000, 9_500_000, 50_000_000, 14_000_000, 640 * 480] {
            let before = data.capacity();
            resize_block(&mut data, len, 7_u8);
            assert_eq!(data.len(), len);
            let is_kept = data.capacity() == before;
            assert_eq!(is_kept, [9_500_000, 14_000_000].contains(&len), "{before} for {len}");
            assert!(data.capacity() <= 4 * len + (1 << 20), "{} for {len}", data.capacity());
        }
    }

    #[test]
    fn large_blocks_are_mapped_alone_and_not_given_back_for_that() {
        let mut data = Vec::new();
        for bytes in [LARGE_BYTES, LARGE_BYTES + 1, 15_000_000, MAPPED_ALONE_BYTES, 40_000_000] {
            let len = bytes.div_ceil(size_of::<f32>());
            resize_block(&mut data, len, 0.0_f32);
            assert!(data.capacity() * size_of::<f32>() >= MAPPED_ALONE_BYTES, "{bytes}");
            let place = data.as_ptr();
            resize_block(&mut data, len, 0.0);
            assert_eq!(data.as_ptr(), place, "{bytes}");
            data = Vec::new();
        }
    }
}
