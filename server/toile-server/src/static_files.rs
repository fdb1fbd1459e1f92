//! Static passes on disk, each with the outfit that it was made of: content-addressed, checksummed, and
//! computed again when they are not what they should be.

use std::path::Path;

use toile_drape::outfit::Outfit;
use toile_drape::outfit_codec::{self, OUTFIT_FORMAT};
use toile_drape::static_pass::{STATIC_FORMAT, StaticPass};

use crate::files::write_atomically;
use crate::hash::{hash, short_hash};

const CHECKSUM_BYTES: usize = 32;
const LENGTH_BYTES: usize = 8;

/// The address of a static pass: everything that it follows from.
pub fn key(outfit_id: &str, fingerprint: &str, body_hash: &str) -> String {
    let formats = [STATIC_FORMAT, OUTFIT_FORMAT].map(u32::to_le_bytes).concat();
    short_hash([outfit_id.as_bytes(), fingerprint.as_bytes(), body_hash.as_bytes(), &formats])
}

/// What is stored at `path`, if it is there and whole. A file that is not is logged and treated as absent.
pub fn load(path: &Path, key: &str) -> Option<(Outfit, StaticPass)> {
    load_sealed(path, key, "static pass", decode)
}

/// Writes a static pass. No drape depends on it: a failure is logged.
pub fn save(path: &Path, key: &str, outfit: &Outfit, statics: &StaticPass) {
    let written = encode(key, outfit, statics).and_then(|bytes| write_atomically(path, &bytes).map_err(text));
    if let Err(reason) = written {
        tracing::warn!(key, reason, "static pass cannot be kept; it will be computed again after a restart");
    }
}

/// Length of the outfit, outfit, static pass; sealed.
fn encode(key: &str, outfit: &Outfit, statics: &StaticPass) -> Result<Vec<u8>, String> {
    let outfit = outfit_codec::to_bytes(outfit);
    let statics = statics.to_bytes().map_err(text)?;
    Ok(sealed(key, &[&(outfit.len() as u64).to_le_bytes(), outfit.as_slice(), &statics].concat()))
}

fn decode(content: &[u8]) -> Result<(Outfit, StaticPass), String> {
    let (length, content) = content.split_first_chunk::<LENGTH_BYTES>().ok_or("it is truncated")?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(text)?;
    let (outfit, statics) = content.split_at_checked(length).ok_or("it is truncated")?;
    let outfit = outfit_codec::from_bytes(outfit).map_err(text)?;
    let statics = StaticPass::from_bytes(statics).map_err(text)?;
    if statics.rest_positions().len() != outfit.positions.len() {
        return Err("it is of another outfit".to_owned());
    }
    Ok((outfit, statics))
}

/// Content after its checksum.
pub fn sealed(key: &str, content: &[u8]) -> Vec<u8> {
    [checksum(key, content).as_slice(), content].concat()
}

/// What `read` makes of the sealed content at `path`, if it is there and whole. A file that is not is logged as `what`
/// it should be, and left out.
pub fn load_sealed<T>(
    path: &Path,
    key: &str,
    what: &str,
    read: impl FnOnce(&[u8]) -> Result<T, String>,
) -> Option<T> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
        Err(error) => {
            tracing::warn!(key, %error, "{what} cannot be read; going on without it");
            return None;
        }
    };
    unsealed(&bytes, key)
        .and_then(read)
        .inspect_err(|reason| tracing::warn!(key, reason, "{what} cannot be used; going on without it"))
        .ok()
}

/// Content whose checksum is right.
fn unsealed<'b>(bytes: &'b [u8], key: &str) -> Result<&'b [u8], String> {
    let (sum, content) = bytes.split_at_checked(CHECKSUM_BYTES).ok_or("it is truncated")?;
    if sum == checksum(key, content) { Ok(content) } else { Err("its checksum is wrong".to_owned()) }
}

/// Over key and content, so that a file under a wrong name does not pass either.
fn checksum(key: &str, content: &[u8]) -> [u8; CHECKSUM_BYTES] {
    hash([key.as_bytes(), content])
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}
