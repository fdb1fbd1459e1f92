//! Why an outfit could not be draped.

use thiserror::Error;

use crate::network::NetworkError;
use crate::reference::ReferenceError;

/// Any failure of a static pass or a drape.
#[derive(Debug, Error)]
pub enum DrapeError {
    /// The runtime refused or failed.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The body file does not fit.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// A network's answer does not have the promised shape.
    #[error("network {graph} answered {found} values where {expected} were due")]
    Answer {
        /// Which graph.
        graph: String,
        /// Values promised.
        expected: usize,
        /// Values found.
        found: usize,
    },
    /// A stored static pass cannot be read.
    #[error("stored static pass: {0}")]
    Stored(String),
    /// The static pass was made of another outfit.
    #[error("the static pass has {found} vertices, the outfit {expected}")]
    OtherOutfit {
        /// Vertices of the outfit.
        expected: usize,
        /// Vertices of the static pass.
        found: usize,
    },
    /// Kinds of garments that do not go with the outfit's.
    #[error("{found} kinds of garments are stated where the outfit has {expected}")]
    NoKinds {
        /// Garments of the outfit.
        expected: usize,
        /// Kinds stated.
        found: usize,
    },
    /// A garment without a pixel-cloth network.
    #[error("no pixel-cloth network was trained on the garment {garment:?}")]
    NoHero {
        /// Its name.
        garment: String,
    },
    /// A body or a pose that the outfit was not simulated in.
    #[error("no simulation of this outfit was kept on this body in this pose")]
    NotSimulated,
    /// A motion without poses.
    #[error("there is no pose to drape")]
    NoPose,
}
