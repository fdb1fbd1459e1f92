//! Why an outfit has no normal map.

use thiserror::Error;

/// Why no normal map can be made of a garment: its UVs do not tell its places apart.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NormalMapError {
    /// There are none, or they have no area.
    #[error("the garment {garment:?} has no UVs")]
    NoUvs {
        /// Its name.
        garment: String,
    },
    /// Places of one island lie over each other.
    #[error("{percent:.0} % of the UVs of the garment {garment:?} lie over others of the same island")]
    Overlapping {
        /// Its name.
        garment: String,
        /// How much of its texels.
        percent: f32,
    },
    /// More pieces than fit beside each other.
    #[error("the UVs of the garment {garment:?} fall into {islands} islands, too many for one picture")]
    Fragmented {
        /// Its name.
        garment: String,
        /// Its islands.
        islands: usize,
    },
}
