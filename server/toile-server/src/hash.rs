//! Content addresses.

use sha2::{Digest, Sha256};

/// SHA-256 over `parts`, each preceded by its length so that they cannot run into each other.
pub fn hash<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> [u8; 32] {
    let mut digest = Sha256::new();
    for part in parts {
        digest.update((part.len() as u64).to_le_bytes());
        digest.update(part);
    }
    digest.finalize().into()
}

/// The first 128 bits of [`hash`] in lowercase hex, as used in ids, URLs and file names.
pub fn short_hash<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    hash(parts).iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_a_part_ends_matters() {
        assert_ne!(short_hash([b"ab".as_ref(), b"c"]), short_hash([b"a".as_ref(), b"bc"]));
        assert_eq!(short_hash([b"ab".as_ref()]).len(), 32);
    }
}
