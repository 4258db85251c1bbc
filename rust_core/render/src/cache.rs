//! Values derived from a geometry of the scene, once, and kept for as long as that geometry lives.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Weak};

/// Values made from the contents of an `Arc`.
///
/// The key is the `Arc`'s address. A [`Weak`] beside the value keeps that address from being reused, so one address
/// always means one geometry.
pub(crate) struct Derived<K, V> {
    entries: HashMap<usize, (Weak<K>, V)>,
}

impl<K, V> Derived<K, V> {
    /// The value of a geometry, made now if there is none.
    pub(crate) fn get(&mut self, key: &Arc<K>, make: impl FnOnce(&K) -> V) -> &mut V {
        let address = Arc::as_ptr(key) as usize;
        &mut self.entries.entry(address).or_insert_with(|| (Arc::downgrade(key), make(key))).1
    }

    /// Drops the values of geometries that are gone.
    pub(crate) fn forget_dead(&mut self) {
        self.entries.retain(|_, (key, _)| key.strong_count() > 0);
    }
}

impl<K, V> Default for Derived<K, V> {
    fn default() -> Self {
        Self { entries: HashMap::new() }
    }
}

impl<K, V> fmt::Debug for Derived<K, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Derived({} entries)", self.entries.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_made_once_and_dropped_with_its_geometry() {
        let mut derived = Derived::default();
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
