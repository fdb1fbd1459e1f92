//! Why a mesh is not an outfit.

use thiserror::Error;

/// Why an outfit cannot be built. Every message says what to do about it.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OutfitError {
    /// A coordinate is NaN or infinite.
    #[error(
        "vertex {vertex} of mesh \"{mesh}\" is not a finite point; export the mesh again without NaN or infinite coordinates"
    )]
    NonFinitePosition {
        /// Name of the mesh.
        mesh: String,
        /// Vertex in the mesh.
        vertex: usize,
    },
    /// A triangle or a material index points at nothing.
    #[error("mesh \"{mesh}\" refers to {what} {index}, but there are only {count}; export the mesh again")]
    IndexOutOfRange {
        /// Name of the mesh.
        mesh: String,
        /// `vertex`, `UV` or `material`.
        what: &'static str,
        /// The index that was found.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Nothing with an area is left.
    #[error(
        "the outfit has no triangles with an area; upload a mesh of faces, not points, lines or collapsed faces"
    )]
    NoTriangles,
    /// More separate garments than one outfit may have.
    #[error(
        "the outfit has {count} garments and at most {limit} are allowed; join pieces that belong together, or upload them as several outfits"
    )]
    TooLarge {
        /// Garments found.
        count: usize,
        /// Garments allowed.
        limit: usize,
    },
    /// The size fits no person.
    #[error(
        "the outfit is {extent_m:.3} m across after scaling by {scale}; state the file's `units` (m, cm, mm or in)"
    )]
    WrongUnits {
        /// Largest extent of the bounding box, metres.
        extent_m: f32,
        /// Factor that was applied to the file's lengths.
        scale: f32,
    },
    /// The size fits, the place does not.
    #[error(
        "{percent:.0} % of the outfit is {place}; place it on the body that it is fitted on (feet at the origin, facing +Z), see /v1/body/reference.glb"
    )]
    OffBody {
        /// Share of the vertices, percent.
        percent: f32,
        /// Where they are.
        place: &'static str,
    },
    /// `layers` names a garment that the file does not have, or names one twice.
    #[error("\"{name}\" in `layers` is {problem}; the garments of this file are: {garments}")]
    InvalidLayers {
        /// Position in `layers`.
        index: usize,
        /// The name in `layers`.
        name: String,
        /// What is wrong with it.
        problem: &'static str,
        /// Names of the garments, comma-separated.
        garments: String,
    },
}

impl OutfitError {
    /// The stable error code of the HTTP API.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NonFinitePosition { .. } => "non-finite-position",
            Self::IndexOutOfRange { .. } => "index-out-of-range",
            Self::NoTriangles => "no-triangles",
            Self::TooLarge { .. } => "too-large",
            Self::WrongUnits { .. } => "wrong-units",
            Self::OffBody { .. } => "off-body",
            Self::InvalidLayers { .. } => "invalid-field",
        }
    }

    /// JSON pointer into the upload's `metadata`, where that is at fault.
    #[must_use]
    pub fn pointer(&self) -> Option<String> {
        match self {
            Self::InvalidLayers { index, .. } => Some(format!("/layers/{index}")),
            _ => None,
        }
    }
}
