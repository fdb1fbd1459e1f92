//! Why a scene cannot be written.

use thiserror::Error;

/// Why a scene cannot be written: the caller's data do not fit together.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum WriteError {
    /// A list has another length than the template it belongs to.
    #[error("{what}: {found} values, but the template has {expected}")]
    Length {
        /// Which list.
        what: &'static str,
        /// Length of the template.
        expected: usize,
        /// Length of the list.
        found: usize,
    },
    /// A position, normal or attribute is NaN or infinite.
    #[error("{0} are not finite")]
    NonFinite(&'static str),
    /// There is no frame, nothing to show in it, or the frame rate is not positive.
    #[error("the scene has {0}")]
    EmptyScene(&'static str),
    /// A normal map is not as large as it says.
    #[error("a normal map cannot be written: {0}")]
    Picture(String),
    /// GLB lengths are 32-bit.
    #[error("the GLB would be {0} bytes, more than a GLB can hold")]
    TooLarge(usize),
}

pub(super) fn check_length(what: &'static str, expected: usize, found: usize) -> Result<(), WriteError> {
    if expected == found { Ok(()) } else { Err(WriteError::Length { what, expected, found }) }
}
