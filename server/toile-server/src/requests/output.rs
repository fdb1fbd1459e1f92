//! What the answer holds.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use toile_drape::methods::MethodKind;

use crate::errors::{ApiError, Code};
use crate::upload::Kinds;

/// Texels each way that a normal map may have.
const MAP_SIZES: [u32; 4] = [128, 256, 512, 1024];

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

/// How the folds of the garments are told.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Detail {
    /// By the outfit's own mesh.
    #[default]
    Mesh,
    /// By a coarse mesh with normal maps.
    NormalMap,
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
    /// Mesh or normal maps.
    pub detail: Detail,
    /// Texels each way of a normal map; as many as the mesh has folds for when not stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_map_size: Option<u32>,
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
            detail: Detail::Mesh,
            normal_map_size: None,
        }
    }
}

impl OutputRequest {
    /// Refuses normal maps of a sequence, and of sizes that are none.
    pub(super) fn check_detail(&self, is_sequence: bool) -> Result<(), ApiError> {
        let maps = self.detail == Detail::NormalMap;
        if maps && is_sequence {
            let detail = "Normal maps are made of a single pose; ask for the detail \"mesh\", or for one pose at a time.";
            return Err(ApiError::new(Code::SinglePoseOnly, detail).at("/output/detail"));
        }
        let invalid = |detail| Err(ApiError::new(Code::InvalidField, detail).at("/output/normal_map_size"));
        match self.normal_map_size {
            Some(_) if !maps => invalid("Only the detail \"normal_map\" has a size."),
            Some(size) if !MAP_SIZES.contains(&size) => {
                invalid("A normal map has 128, 256, 512 or 1024 texels each way.")
            }
            _ => Ok(()),
        }
    }
}
