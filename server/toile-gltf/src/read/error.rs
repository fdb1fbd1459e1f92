//! Why an uploaded file is refused.

use thiserror::Error;

/// Why a file cannot be read, one variant per code of the HTTP API. Messages say what to do.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ReadError {
    /// Neither GLB, glTF nor OBJ.
    #[error("the file is neither GLB, glTF nor OBJ; export the outfit as GLB")]
    UnsupportedMediaType,
    /// It claims to be one of the formats and is not.
    #[error("the file is not a valid mesh: {0}; export the outfit again as GLB")]
    NotAMesh(String),
    /// It ends early.
    #[error("the file ends early: {0}; upload the whole file")]
    Truncated(String),
    /// It refers to another file.
    #[error("{what} refers to another file; export as GLB, or embed everything in the file")]
    ExternalUri {
        /// Which object, such as `images[0]`.
        what: String,
    },
    /// It needs an extension that is not supported.
    #[error(
        "the file requires {0}, which is not supported; export it without compression or special extensions"
    )]
    UnsupportedExtension(String),
    /// An accessor does not describe data that exists.
    #[error("{0}; export the outfit again")]
    InvalidAccessor(String),
    /// A coordinate is NaN or infinite.
    #[error("{0} is not a finite number; export the outfit again without NaN or infinite coordinates")]
    NonFinitePosition(String),
    /// An index is beyond what it indexes.
    #[error("{what} is {index}, but there are only {count}; export the outfit again")]
    IndexOutOfRange {
        /// Which index.
        what: String,
        /// Its value.
        index: i64,
        /// How many there are.
        count: usize,
    },
    /// There is nothing with a surface.
    #[error("the file has no triangles; upload a mesh of faces, not points, lines or an empty scene")]
    NoTriangles,
    /// More than is accepted.
    #[error(
        "the file has {what}, at most {limit} are accepted; make it smaller, for instance by decimating the mesh"
    )]
    TooLarge {
        /// How much of what.
        what: String,
        /// The cap.
        limit: usize,
    },
    /// No unit, or more than one, puts the outfit on a person.
    #[error("{0}; state `units` (m, cm, mm or in) and `up` (y or z) in the metadata")]
    WrongUnits(String),
}

impl ReadError {
    /// The stable error code of the HTTP API.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnsupportedMediaType => "unsupported-media-type",
            Self::NotAMesh(_) => "not-a-mesh",
            Self::Truncated(_) => "truncated",
            Self::ExternalUri { .. } => "external-uri",
            Self::UnsupportedExtension(_) => "unsupported-extension",
            Self::InvalidAccessor(_) => "invalid-accessor",
            Self::NonFinitePosition(_) => "non-finite-position",
            Self::IndexOutOfRange { .. } => "index-out-of-range",
            Self::NoTriangles => "no-triangles",
            Self::TooLarge { .. } => "too-large",
            Self::WrongUnits(_) => "wrong-units",
        }
    }

    pub(crate) fn too_large(count: usize, what: &str, limit: usize) -> Self {
        Self::TooLarge { what: format!("{count} {what}"), limit }
    }
}
