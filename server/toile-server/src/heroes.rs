//! Pixel-cloth networks of outfits on disk: what `model/hero.py` learned of one outfit.

use std::path::Path;

use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};
use toile_drape::hero::{self, Hero};
use toile_drape::outfit::Outfit;

use crate::errors::{ApiError, Code};
use crate::files::write_atomically;
use crate::static_files::{load_sealed, sealed};

/// Largest file of a network with its tables: 16 panels of 10 000 vertices.
pub const MAX_HERO_BYTES: usize = 64 * 1024 * 1024;
/// Metadata of the file: how near the network comes.
const REPORT: &str = "report";

/// How near a network comes to relaxed cloth that it did not learn from, before the resolve.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct HeroReport {
    /// How long it took.
    pub minutes: f32,
    /// Relaxed drapes that it learned from.
    pub drapes: u32,
    /// Mean distance of the vertices by linear blend skinning, cm.
    pub skinning_cm: f32,
    /// By `DeePSD`, cm.
    pub deepsd_cm: f32,
    /// By this network, cm.
    pub pixel_cloth_cm: f32,
}

/// Reads the file of a network for an outfit, on a body of so many vertices.
///
/// # Errors
/// `invalid-hero`.
pub fn read(bytes: &[u8], outfit: &Outfit, body: usize) -> Result<(Hero, HeroReport), ApiError> {
    let invalid =
        |cause: String| ApiError::new(Code::InvalidHero, format!("The network cannot be used: {cause}."));
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| invalid(e.to_string()))?;
    let report = header.metadata().as_ref().and_then(|about| about.get(REPORT)).map_or("", String::as_str);
    let report = serde_json::from_str(report).map_err(|e| invalid(format!("metadata `report`: {e}")))?;
    let hero = Hero::from_safetensors(bytes, body).map_err(|e| invalid(e.to_string()))?;
    if !hero::known(&[&hero], outfit).into_iter().all(|known| known) {
        return Err(invalid("it was trained on another garment, or on one of several".to_owned()));
    }
    Ok((hero, report))
}

/// What is stored at `path` for the outfit `id`, if it is there and whole. A file that is not is logged and left out.
pub fn load(path: &Path, id: &str, outfit: &Outfit, body: usize) -> Option<(Hero, HeroReport)> {
    let read = |content: &[u8]| read(content, outfit, body).map_err(|error| error.to_string());
    load_sealed(path, id, "pixel-cloth network", read)
}

/// Keeps a network's file.
///
/// # Errors
/// When it cannot be written.
pub fn save(path: &Path, id: &str, bytes: &[u8]) -> std::io::Result<()> {
    write_atomically(path, &sealed(id, bytes))
}
