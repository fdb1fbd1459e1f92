//! Reading uploads.

mod error;
mod format;
mod units;

pub use self::error::ReadError;
pub use self::format::Format;
pub use self::units::{Hints, Units, Up};
use toile_drape::outfit_build::OutfitSource;

/// Largest file, bytes.
pub const MAX_BYTES: usize = 64 * 1024 * 1024;
/// Most vertices over all meshes, counted as drawn.
pub const MAX_VERTICES: usize = 200_000;
/// Most triangles over all meshes.
pub const MAX_TRIANGLES: usize = 400_000;

/// Checks size, framing, references, extensions and counts without reading any mesh.
///
/// # Errors
/// The first reason to refuse the file.
pub fn preflight(_bytes: &[u8], _format: Format) -> Result<(), ReadError> {
    Ok(())
}

/// Reads an upload into meshes in metres and glTF axes. `name` wins over the file's own scene name.
///
/// # Errors
/// The first reason to refuse the file.
pub fn read(
    _bytes: &[u8],
    _format: Format,
    _hints: &Hints,
    _name: Option<&str>,
) -> Result<OutfitSource, ReadError> {
    Err(ReadError::NoTriangles)
}
