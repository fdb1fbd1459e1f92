//! Draped GLBs that a JSON answer gave a URL for, kept in memory for a while and within a bound.

use bytes::Bytes;
use moka::future::Cache;
use moka::policy::EvictionPolicy;

use crate::hash::short_hash;

/// A byte-bounded store of answers, addressed by their content. The oldest use goes first.
#[derive(Clone)]
pub struct Answers {
    kept: Cache<String, Bytes>,
}

impl Answers {
    /// Keeps at most `bytes` bytes.
    pub fn new(bytes: u64) -> Self {
        let weigher = |key: &String, glb: &Bytes| u32::try_from(key.len() + glb.len()).unwrap_or(u32::MAX);
        let policy = EvictionPolicy::lru();
        Self { kept: Cache::builder().max_capacity(bytes).weigher(weigher).eviction_policy(policy).build() }
    }

    /// Keeps an answer and tells its id.
    pub async fn keep(&self, glb: Bytes) -> String {
        let id = short_hash([glb.as_ref()]);
        self.kept.insert(id.clone(), glb).await;
        // The bound holds now, not when the cache next finds time.
        self.kept.run_pending_tasks().await;
        id
    }

    /// The answer of this id, if it is still kept.
    pub async fn get(&self, id: &str) -> Option<Bytes> {
        self.kept.get(id).await
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn the_store_stays_within_its_bound_and_keeps_what_came_last() {
        let answers = Answers::new(2500);
        let mut ids = Vec::new();
        for fill in 0..4_u8 {
            ids.push(answers.keep(Bytes::from(vec![fill; 1000])).await);
        }
        assert!(answers.kept.weighted_size() <= 2500);
        assert!(answers.get(&ids[0]).await.is_none());
        assert_eq!(answers.get(&ids[3]).await, Some(Bytes::from(vec![3; 1000])));
    }
}
