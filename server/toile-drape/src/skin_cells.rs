//! What of a posed body's surface is near a place, of whichever limb: cells of space that each know a vertex.
//!
//! Cloth keeps to the limb that it was drawn on, whose vertices are its candidates. An arm at the side or a hand on a
//! thigh brings it into another one, which they do not know.

use glam::{IVec3, Vec3};

/// Size of a cell, metres.
const SIZE: f32 = 0.025;
/// How far under the surface cells still know it, metres; what lies deeper has passed through it.
const DEPTHS: [f32; 3] = [0.016, 0.008, 0.0];
/// Cells each way at most.
const MOST: i32 = 255;
/// Stands for "no surface here".
const NONE: u16 = u16::MAX;

/// The cells around a posed body; world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinCells {
    low: Vec3,
    count: IVec3,
    vertex: Vec<u16>,
}

impl SkinCells {
    /// Of a surface with these vertices, metres, and unit normals.
    #[must_use]
    pub fn new(vertices: &[Vec3], normals: &[Vec3]) -> Self {
        let low = vertices.iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
        let high = vertices.iter().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
        let count = ((high - low) / SIZE).as_ivec3().clamp(IVec3::ZERO, IVec3::splat(MOST)) + IVec3::ONE;
        let mut out = Self { low, count, vertex: vec![NONE; count.as_usizevec3().element_product()] };
        // The shallowest comes last and stays.
        for depth in DEPTHS {
            for (v, (p, normal)) in (0..NONE).zip(vertices.iter().zip(normals)) {
                if let Some(cell) = out.index(*p - *normal * depth).and_then(|i| out.vertex.get_mut(i)) {
                    *cell = v;
                }
            }
        }
        out
    }

    /// A vertex of the surface in whose cell a point lies.
    #[must_use]
    pub fn at(&self, point: Vec3) -> Option<u32> {
        self.index(point).and_then(|i| self.vertex.get(i)).filter(|v| **v != NONE).map(|v| u32::from(*v))
    }

    fn index(&self, point: Vec3) -> Option<usize> {
        let way = point - self.low;
        let cell = (way * (1.0 / SIZE)).as_ivec3();
        let inside = way.cmpge(Vec3::ZERO).all() && cell.cmplt(self.count).all();
        inside.then(|| ((cell.z * self.count.y + cell.y) * self.count.x + cell.x) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::sheet;

    #[test]
    fn cells_know_what_is_at_and_a_little_under_the_surface() {
        let vertices = sheet(30).0;
        let cells = SkinCells::new(&vertices, &vec![Vec3::NEG_Y; vertices.len()]);
        assert_eq!(
            cells,
            SkinCells::new(&vertices, &vec![Vec3::Y; vertices.len()]),
            "a sheet is one cell high"
        );
        let point = Vec3::new(0.11, 0.003, 0.16);
        let found = cells.at(point).expect("a vertex") as usize;
        assert!(vertices[found].distance(point) < 2.0 * SIZE);
        assert_eq!(cells.at(point + Vec3::Y * 0.1), None);
        assert_eq!(cells.at(Vec3::splat(f32::NAN)), None);
        assert_eq!(SkinCells::new(&[], &[]).at(point), None);
        let above = vertices.iter().map(|p| *p + Vec3::Y * 0.102);
        let both: Vec<Vec3> = vertices.iter().copied().chain(above).collect();
        let normals: Vec<Vec3> = both.iter().map(|p| if p.y > 0.0 { Vec3::Y } else { Vec3::NEG_Y }).collect();
        let cells = SkinCells::new(&both, &normals);
        let known = |height: f32| cells.at(point.with_y(height)).map(|v| both[v as usize].y);
        assert_eq!([known(0.09), known(0.06)], [Some(0.102), None], "under the upper sheet, between both");
    }
}
