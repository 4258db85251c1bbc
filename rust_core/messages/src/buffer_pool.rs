//! Recycled vectors.
//!
//! A depth camera's cloud takes megabytes of bytes, positions and colours thirty times a second. The allocator returns
//! vectors of that size to the system and gets them anew, cleared page by page, so they are kept in a pool.

use std::time::Instant;

/// Pool of unused vectors, the longest unused first.
#[derive(Debug)]
pub struct BufferPool<T> {
    unused: Vec<Unused<T>>,
}

#[derive(Debug)]
struct Unused<T> {
    vector: Vec<T>,
    since: Instant,
}

/// Least size of a pooled vector; the allocator keeps smaller ones itself.
const MIN_BYTES: usize = 4096;

/// A vector is used for no fewer elements than its capacity divided by this.
const MAX_WASTE: usize = 4;

/// A new vector's extra room is the length divided by this, for a next cloud that is a little larger.
const ROOM_ON_TOP: usize = 8;

impl<T> BufferPool<T> {
    /// An empty pool.
    pub const fn new() -> Self {
        Self { unused: Vec::new() }
    }

    /// Takes an empty vector with room for `len` elements: the smallest unused one that fits, or a new one.
    pub fn take(&mut self, len: usize) -> Vec<T> {
        let mut vector = self.find(len);
        vector.clear();
        vector
    }

    /// Takes a vector of `len` elements of unspecified values.
    pub fn take_filled(&mut self, len: usize) -> Vec<T>
    where
        T: Copy + Default,
    {
        let mut vector = self.find(len);
        vector.resize(len, T::default());
        vector
    }

    fn find(&mut self, len: usize) -> Vec<T> {
        let is_small = len.saturating_mul(size_of::<T>()) < MIN_BYTES;
        let fits = |capacity: usize| capacity >= len && capacity / MAX_WASTE <= len;
        let capacities = self.unused.iter().map(|unused| unused.vector.capacity()).enumerate();
        let fitting = capacities.filter(|(_, capacity)| !is_small && fits(*capacity));
        match fitting.min_by_key(|(_, capacity)| *capacity) {
            Some((i, _)) => self.unused.remove(i).vector,
            None => Vec::with_capacity(if is_small { len } else { len + len / ROOM_ON_TOP }),
        }
    }

    /// Returns a vector to the pool.
    pub fn give(&mut self, vector: Vec<T>) {
        if vector.capacity().saturating_mul(size_of::<T>()) >= MIN_BYTES {
            self.unused.push(Unused { vector, since: Instant::now() });
        }
    }

    /// Frees vectors that have been unused since before a time.
    pub fn free_unused_since(&mut self, time: Instant) {
        let count = self.unused.partition_point(|unused| unused.since < time);
        self.unused.drain(..count);
    }

    /// Frees the longest unused vectors until the others have room for at most `elements` together.
    pub fn limit_to(&mut self, elements: usize) {
        let capacities = || self.unused.iter().map(|unused| unused.vector.capacity());
        let mut room: usize = capacities().sum();
        let too_many = capacities().take_while(|capacity| {
            let is_over = room > elements;
            room -= capacity;
            is_over
        });
        let count = too_many.count();
        self.unused.drain(..count);
    }
}

impl<T> Default for BufferPool<T> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn capacities(pool: &BufferPool<u8>) -> Vec<usize> {
        pool.unused.iter().map(|unused| unused.vector.capacity()).collect()
    }

    #[test]
    fn the_memory_of_one_cloud_is_used_for_the_next() {
        let mut pool = BufferPool::new();
        let first: Vec<u32> = pool.take(5000);
        let address = first.as_ptr();
        pool.give(first);
        let second = pool.take(5100);
        assert_eq!((second.as_ptr(), second.len()), (address, 0));
        let third = pool.take(5000);
        assert_ne!(third.as_ptr(), address, "it is in use");
    }

    #[test]
    fn a_vector_that_is_far_too_large_stays_in_the_pool() {
        let mut pool = BufferPool::new();
        for len in [100_000_usize, 9000, 20_000] {
            pool.give(Vec::<u8>::with_capacity(len));
        }
        assert_eq!(pool.take(8500).capacity(), 9000, "the smallest that fits");
        assert_eq!(pool.take(5000).capacity(), 20_000);
        assert!(pool.take(5000).capacity() < 100_000);
        assert_eq!(pool.take(0).capacity(), 0);
    }

    #[test]
    fn those_unused_for_longest_are_freed_first() {
        let mut pool = BufferPool::new();
        for len in [5000_usize, 7000, 6000] {
            pool.give(Vec::<u8>::with_capacity(len));
        }
        pool.limit_to(13_500);
        assert_eq!(capacities(&pool), [7000, 6000]);
        pool.limit_to(0);
        assert!(capacities(&pool).is_empty());
    }

    #[test]
    fn those_unused_since_before_a_time_are_freed() {
        let mut pool = BufferPool::new();
        pool.give(Vec::<u8>::with_capacity(5000));
        pool.give(Vec::with_capacity(7000));
        let a_moment_later = || {
            std::thread::sleep(Duration::from_millis(1));
            Instant::now()
        };
        let between = a_moment_later();
        let other = pool.take(5000);
        pool.give(other);
        pool.free_unused_since(between);
        assert_eq!(capacities(&pool), [5000], "it was in use since");
        pool.free_unused_since(a_moment_later());
        assert!(capacities(&pool).is_empty());
    }
}
