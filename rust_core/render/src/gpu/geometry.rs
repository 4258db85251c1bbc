//! GPU resources made from a geometry of the scene, kept for as long as that geometry lives.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Weak};

/// No buffer is larger than this; larger geometries are split.
pub(super) const MAX_CHUNK_BYTES: usize = 32 << 20;

/// Values made from the contents of an `Arc`.
///
/// The key is the `Arc`'s address. A [`Weak`] beside the value keeps that address from being reused, so one address
/// always means one geometry.
pub(super) struct Derived<K, V> {
    entries: HashMap<usize, (Weak<K>, V)>,
}

impl<K, V> Derived<K, V> {
    pub(super) fn new() -> Self {
        Self { entries: HashMap::new() }
    }

    /// The value of a geometry, made now if there is none.
    pub(super) fn get(&mut self, key: &Arc<K>, make: impl FnOnce(&K) -> V) -> &mut V {
        let address = Arc::as_ptr(key) as usize;
        &mut self.entries.entry(address).or_insert_with(|| (Arc::downgrade(key), make(key))).1
    }

    /// Drops the values of geometries that are gone.
    pub(super) fn forget_dead(&mut self) {
        self.entries.retain(|_, (key, _)| key.strong_count() > 0);
    }
}

impl<K, V> fmt::Debug for Derived<K, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Derived({} entries)", self.entries.len())
    }
}

/// A vertex buffer of instances.
#[derive(Clone, Debug)]
pub(super) struct Instances {
    /// The buffer.
    pub(super) buffer: wgpu::Buffer,
    /// How many there are.
    pub(super) count: u32,
}

/// Whether all coordinates are finite.
pub(super) fn is_finite(position: &[f32; 3]) -> bool {
    position.iter().all(|c| c.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_made_once_and_dropped_with_its_geometry() {
        let mut derived = Derived::new();
        let key = Arc::new(7);
        assert_eq!(*derived.get(&key, |key| key + 1), 8);
        assert_eq!(*derived.get(&key.clone(), |_| 0), 8);
        derived.forget_dead();
        assert_eq!(derived.entries.len(), 1);
        drop(key);
        derived.forget_dead();
        assert!(derived.entries.is_empty());
    }
}
