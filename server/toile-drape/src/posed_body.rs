//! A body in one pose, standing on the floor. World space.

use glam::{Affine3A, Vec3};
use toile_geometry::body::{Body, ShapedBody};
use toile_geometry::normals::vertex_normals;

use crate::folds;
use crate::reference::Part;
use crate::skin_cells::SkinCells;

/// A posed body.
#[derive(Clone, Debug, PartialEq)]
pub struct PosedBody {
    /// Vertices, metres; the lowest is at y = 0.
    pub vertices: Vec<Vec3>,
    /// Unit vertex normals.
    pub normals: Vec<Vec3>,
    /// For every vertex the one that faces it across a fold, or [`folds::NONE`].
    pub facing: Vec<u32>,
    /// Which vertex is near a place.
    pub cells: SkinCells,
    /// What standing on the floor moved the body by, metres.
    pub lift: Vec3,
}

impl PosedBody {
    /// Poses the body by its joints' world transforms and puts its lowest vertex on the floor.
    #[must_use]
    pub fn standing(body: &Body, parts: &[Option<Part>], shaped: &ShapedBody, world: &[Affine3A]) -> Self {
        let mut vertices = body.posed_vertices(shaped, world);
        let lowest = vertices.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
        let lift = Vec3::Y * if lowest.is_finite() { -lowest } else { 0.0 };
        vertices.iter_mut().for_each(|p| *p += lift);
        let normals = vertex_normals(&vertices, body.triangles());
        let facing = folds::facing(&vertices, &normals, parts);
        let cells = SkinCells::new(&vertices, &normals);
        Self { vertices, normals, facing, cells, lift }
    }
}
