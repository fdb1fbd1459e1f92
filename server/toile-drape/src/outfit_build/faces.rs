//! Dropping faces that are none, or that are there twice, and counting edges that do not fit a surface.

use std::collections::HashSet;

use super::OutfitError;
use super::weld::Soup;
use crate::outfit::Report;

/// Twice the area below which a face has none, square metres.
const LEAST_DOUBLE_AREA: f32 = 1e-10;

/// A face's side, for matching neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// Welded ends, the lower first.
    pub(super) edge: [u32; 2],
    /// Index into the soup's faces.
    pub(super) face: u32,
    /// Whether the face runs along it from the lower end to the higher.
    pub(super) ascending: bool,
}

/// Drops degenerate faces and all but the first over the same three vertices.
pub(super) fn drop_bad(soup: &mut Soup, report: &mut Report) -> Result<(), OutfitError> {
    let before = soup.faces.len();
    let mut faces = std::mem::take(&mut soup.faces);
    faces.retain(|face| {
        let [a, b, c] = face.welded;
        a != b && b != c && c != a && soup.area_vector(face).length() > LEAST_DOUBLE_AREA
    });
    report.degenerate_faces_removed = before - faces.len();
    let regular = faces.len();
    let mut seen = HashSet::with_capacity(regular);
    faces.retain(|face| {
        let mut vertices = face.welded;
        vertices.sort_unstable();
        seen.insert(vertices)
    });
    report.duplicate_faces_removed = regular - faces.len();
    soup.faces = faces;
    if soup.faces.is_empty() {
        return Err(OutfitError::NoTriangles);
    }
    report.non_manifold_edges =
        sides(soup).chunk_by(|a, b| a.edge == b.edge).filter(|edge| edge.len() > 2).count();
    Ok(())
}

/// The sides of all faces, sorted by edge.
pub(super) fn sides(soup: &Soup) -> Vec<Side> {
    let mut sides: Vec<Side> = Vec::with_capacity(soup.faces.len() * 3);
    for (index, face) in soup.faces.iter().enumerate() {
        let [a, b, c] = face.welded;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            sides.push(Side { edge: [from.min(to), from.max(to)], face: index as u32, ascending: from < to });
        }
    }
    sides.sort_unstable();
    sides
}
