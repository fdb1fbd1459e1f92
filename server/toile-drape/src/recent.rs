//! A few recently computed values, the latest first.

use std::sync::{Arc, Mutex, PoisonError};

/// At most `limit` values by key, compared by equality: for keys that are cheap to compare and few.
#[derive(Debug)]
pub struct Recent<K, V> {
    limit: usize,
    kept: Mutex<Vec<(K, Arc<V>)>>,
}

impl<K: PartialEq, V> Recent<K, V> {
    /// An empty store of at most `limit` values.
    #[must_use]
    pub const fn new(limit: usize) -> Self {
        Self { limit, kept: Mutex::new(Vec::new()) }
    }

    /// The value of `key`, made anew unless it is among the latest. Two callers at once may both make it.
    pub fn get(&self, key: K, make: impl FnOnce(&K) -> V) -> Arc<V> {
        if let Some(value) = self.find(&key) {
            return value;
        }
        let value = make(&key);
        self.keep(key, value)
    }

    /// The value of `key`, if it is among the latest.
    pub fn find(&self, key: &K) -> Option<Arc<V>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let at = kept.iter().position(|(k, _)| k == key)?;
        let entry = kept.remove(at);
        let value = Arc::clone(&entry.1);
        kept.insert(0, entry);
        Some(value)
    }

    /// Keeps the value of `key` as the latest.
    pub fn keep(&self, key: K, value: V) -> Arc<V> {
        let value = Arc::new(value);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|(k, _)| *k != key);
        kept.insert(0, (key, Arc::clone(&value)));
        kept.truncate(self.limit);
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_made_once_and_the_oldest_is_dropped() {
        let recent = Recent::new(2);
        let mut made = Vec::new();
        for key in [1, 2, 1, 3, 1, 2] {
            recent.get(key, |k| made.push(*k));
        }
        assert_eq!(made, [1, 2, 3, 2]);
        assert!(recent.find(&2).is_some() && recent.find(&3).is_none());
    }
}
