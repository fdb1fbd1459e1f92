//! What the answer holds.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use toile_drape::methods::MethodKind;

/// A part of the answer.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Ord, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// The draped garments.
    Outfit,
    /// The posed body.
    Body,
}

/// A figure for every vertex.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Ord, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Attribute {
    /// `_STRAIN`
    Strain,
    /// `_PENETRATION`
    Penetration,
}

/// What the answer holds.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputRequest {
    /// Parts of the scene.
    pub include: BTreeSet<Part>,
    /// Name of the method.
    pub(super) method: String,
    /// Figures for every vertex.
    pub attributes: BTreeSet<Attribute>,
    /// Whether the outfit's pictures are embedded.
    pub textures: bool,
}

impl Default for OutputRequest {
    fn default() -> Self {
        let include = BTreeSet::from([Part::Outfit]);
        Self { include, method: MethodKind::Deepsd.to_string(), attributes: BTreeSet::new(), textures: true }
    }
}
