//! Bakes on disk: what `model/bake.py` found for one outfit, beside the static pass that it refines.

use std::path::Path;

use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};
use toile_drape::bake::{Bake, BakeError};
use toile_drape::static_pass::StaticPass;

use crate::errors::{ApiError, Code};
use crate::files::write_atomically;
use crate::static_files::{load_sealed, sealed};

/// Largest bake: an outfit of 50 000 nodes, many times what a body can wear.
pub const MAX_BAKE_BYTES: usize = 48 * 1024 * 1024;
/// Metadata of a bake: the static pass that it refines.
const STATIC: &str = "static";
/// Metadata of a bake: what it buys.
const REPORT: &str = "report";

/// What a bake buys, measured on drapes that it did not learn from, before the resolve.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BakeReport {
    /// How long it took.
    pub minutes: f32,
    /// Relaxed drapes that it learned from.
    pub drapes: u32,
    /// With the networks' answers.
    pub before: Measured,
    /// With the bake.
    pub after: Measured,
}

/// Means over drapes.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Distance of the vertices to relaxed cloth, millimetres.
    pub miss_mm: f32,
    /// |length - rest length| of the edges, millimetres.
    pub edge_mm: f32,
    /// Vertices inside the body, percent.
    pub inside_percent: f32,
}

/// Reads a bake's file, made for the static pass of this key.
///
/// # Errors
/// `invalid-bake` or `outdated-bake`.
pub fn read(bytes: &[u8], statics: &StaticPass, key: &str) -> Result<(Bake, BakeReport), ApiError> {
    let invalid =
        |cause: String| ApiError::new(Code::InvalidBake, format!("The bake cannot be used: {cause}."));
    let (_, header) = SafeTensors::read_metadata(bytes)
        .map_err(|e| invalid(BakeError::Container(e.to_string()).to_string()))?;
    let about = header.metadata().clone().unwrap_or_default();
    if about.get(STATIC).is_none_or(|made_for| made_for != key) {
        let detail = "The bake was made for other networks or another outfit; make it again from this outfit's \
                      static.safetensors.";
        return Err(ApiError::new(Code::OutdatedBake, detail));
    }
    let report = about.get(REPORT).map_or("", String::as_str);
    let report = serde_json::from_str(report).map_err(|e| invalid(format!("metadata `report`: {e}")))?;
    Ok((Bake::from_bytes(bytes, statics).map_err(|e| invalid(e.to_string()))?, report))
}

/// What is stored at `path`, if it is there and whole. A file that is not is logged and left out.
pub fn load(path: &Path, statics: &StaticPass, key: &str) -> Option<(Bake, BakeReport)> {
    load_sealed(path, key, "bake", |content| read(content, statics, key).map_err(|error| error.to_string()))
}

/// Keeps a bake's file.
///
/// # Errors
/// When it cannot be written.
pub fn save(path: &Path, key: &str, bytes: &[u8]) -> std::io::Result<()> {
    write_atomically(path, &sealed(key, bytes))
}
