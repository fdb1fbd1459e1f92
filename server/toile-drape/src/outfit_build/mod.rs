//! From the meshes of a file to an outfit: welded, mended, split into garments, ordered into layers.

mod error;

use glam::Vec3;

pub use self::error::OutfitError;
use crate::outfit::{Material, Outfit, RawMesh, Report};

/// What a file holds, in metres and glTF axes, before it is an outfit.
#[derive(Clone, Debug, Default)]
pub struct OutfitSource {
    /// Name given by the person or the file.
    pub name: Option<String>,
    /// Meshes in file order.
    pub meshes: Vec<RawMesh>,
    /// Materials of the file; `RawPart::material` indexes them.
    pub materials: Vec<Material>,
    /// Garment names, innermost first, where the order is stated.
    pub layers: Vec<String>,
    /// What the reader found; scale, units and up-axis are filled in.
    pub report: Report,
}

/// Builds an outfit in rest pose on the body given by its vertices (metres, glTF axes) and triangles.
///
/// # Errors
/// When the meshes are no outfit on that body; see [`OutfitError`].
pub fn build(
    _source: OutfitSource,
    _body_vertices: &[Vec3],
    _body_triangles: &[[u32; 3]],
) -> Result<(Outfit, Report), OutfitError> {
    Err(OutfitError::NoTriangles)
}
