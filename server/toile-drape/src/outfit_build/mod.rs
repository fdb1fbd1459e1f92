//! From the meshes of a file to an outfit: welded, mended, split into garments, ordered into layers.
//!
//! The line: weld → drop bad faces → place on the body → orient → components → garments → layers → outfit.

mod assemble;
pub(crate) mod components;
mod error;
mod faces;
mod garments;
mod layers;
mod orient;
mod placement;
#[cfg(test)]
mod tests;
mod weld;

use glam::Vec3;
use toile_geometry::mesh::edges;

pub use self::error::OutfitError;
use crate::evaluation::crossed;
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
    source: OutfitSource,
    body_vertices: &[Vec3],
    body_triangles: &[[u32; 3]],
) -> Result<(Outfit, Report), OutfitError> {
    let mut report = source.report.clone();
    let mut soup = weld::weld(&source, &mut report)?;
    faces::drop_bad(&mut soup, &mut report)?;
    placement::check_size(&soup, &report)?;
    let placement = placement::Placement::measure(&soup, body_vertices, body_triangles)?;
    report.rest_penetration_percent = placement.penetration_percent(&soup);
    orient::orient(&mut soup, &placement, &mut report);
    let components = components::find(&soup);
    report.components = components.len();
    let drafts = garments::group(&soup, &components, &source, &mut report)?;
    let layers = layers::order(&drafts, &soup, &placement, &source.layers)?;
    let outfit = assemble::assemble(source, soup, drafts, &layers);
    report.self_crossed_percent = crossed(&outfit, &outfit.positions, &edges(&outfit.triangles)).0;
    Ok((outfit, report))
}
