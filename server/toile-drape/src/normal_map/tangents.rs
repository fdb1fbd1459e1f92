//! Tangent frames of the coarse mesh.

use glam::{Vec2, Vec3, Vec4};
use toile_geometry::normals::vertex_normals;

use super::CoarseOutfit;
use super::patch::{Patch, pick};

/// How one frame of a coarse mesh is lit.
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    /// Unit normals of the coarse mesh, one a welded vertex; of vertices that it does not have, +Y.
    pub normals: Vec<Vec3>,
    /// One a coarse drawn vertex, as `TANGENT` of glTF: where u grows, a unit vector normal to the normal; and the
    /// sign of the bitangent, which points up in the picture.
    pub tangents: Vec<Vec4>,
}

impl CoarseOutfit {
    /// Normals and tangents of the coarse mesh with its welded vertices at `positions`, metres.
    #[must_use]
    pub fn shade(&self, positions: &[Vec3]) -> Shading {
        let normals = vertex_normals(positions, &self.outfit.triangles);
        let mut sums = vec![(Vec3::ZERO, 0.0_f32); self.uvs.len()];
        for (&drawn, &welded) in self.outfit.surface.triangles.iter().zip(&self.outfit.triangles) {
            let (along_u, facing) =
                gradient(Patch::corners(positions, welded), Patch::corners(&self.uvs, drawn));
            for corner in drawn {
                if let Some((sum, sign)) = sums.get_mut(corner as usize) {
                    *sum += along_u;
                    *sign += facing;
                }
            }
        }
        let vertices = sums.iter().zip(&self.outfit.surface.vertex_of);
        let tangent = |((sum, facing), &vertex): (&(Vec3, f32), &u32)| {
            let normal = pick(&normals, vertex);
            let level = *sum - normal * normal.dot(*sum);
            let tangent = level.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
            tangent.extend(if *facing > 0.0 { -1.0 } else { 1.0 })
        };
        let tangents = vertices.map(tangent).collect();
        Shading { normals, tangents }
    }
}

/// Where u grows on a triangle, as long as its area, and its area with the sign that it has in UVs.
fn gradient([a, b, c]: [Vec3; 3], uvs: [Vec2; 3]) -> (Vec3, f32) {
    let (e1, e2) = (b - a, c - a);
    let (d1, d2) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
    let (area, sign) = (e1.cross(e2).length(), d1.perp_dot(d2).signum());
    ((e1 * d2.y - e2 * d1.y).normalize_or_zero() * sign * area, sign * area)
}
