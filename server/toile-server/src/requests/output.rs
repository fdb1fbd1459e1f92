//! What the answer holds.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use toile_drape::methods::MethodKind;

use crate::upload::Kinds;

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
    /// Kinds of garments by their names, before what the outfit's metadata say.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub kinds: Kinds,
    /// Figures for every vertex.
    pub attributes: BTreeSet<Attribute>,
    /// Whether the outfit's pictures are embedded.
    pub textures: bool,
}

impl Default for OutputRequest {
    fn default() -> Self {
        let include = BTreeSet::from([Part::Outfit]);
        Self {
            include,
            method: MethodKind::Deepsd.to_string(),
            kinds: Kinds::new(),
            attributes: BTreeSet::new(),
            textures: true,
        }
    }
}
