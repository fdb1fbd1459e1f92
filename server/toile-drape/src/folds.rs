//! Where a posed body meets itself: belly on thigh, thigh on thigh, calf on thigh.
//!
//! Cloth in such a fold lies between two surfaces, of which its own candidates know only one.

use glam::Vec3;
use toile_geometry::nearest::PointTree;

use crate::reference::Part;

/// Surfaces further apart than this do not pinch cloth, metres.
pub const REACH: f32 = 0.04;
/// Cosine of the normals of the two surfaces of a fold, at most: open creases, as of a bent hip, are folds too.
/// Training leaves out the pinched ones alone, whose surfaces face each other (`model/garment/folds.py`).
const OPPOSED: f32 = 0.5;
/// The same below which surfaces are a fold even where the body has grown into itself; otherwise each must lie in front
/// of the other, or a bent knee's cap would be one.
const GROWN_IN: f32 = -0.2;
/// How far it grows into itself, metres: further apart are the two sides of a knee.
const DEEPEST: f32 = 0.022;
/// Stands for "no surface faces this one".
pub const NONE: u32 = u32::MAX;

/// Parts that can meet.
const PAIRS: [(Part, Part); 6] = [
    (Part::Trunk, Part::ThighLeft),
    (Part::Trunk, Part::ThighRight),
    (Part::ThighLeft, Part::ThighRight),
    (Part::ThighLeft, Part::CalfLeft),
    (Part::ThighRight, Part::CalfRight),
    (Part::CalfLeft, Part::CalfRight),
];

/// For every body vertex the nearest one of another part that faces it within [`REACH`], or [`NONE`].
#[must_use]
pub fn facing(vertices: &[Vec3], normals: &[Vec3], parts: &[Option<Part>]) -> Vec<u32> {
    let mut found = vec![(NONE, REACH); vertices.len()];
    for (a, b) in PAIRS {
        for (from, to) in [(a, b), (b, a)] {
            look(&Surface { vertices, normals, parts }, from, to, &mut found);
        }
    }
    found.into_iter().map(|f| f.0).collect()
}

struct Surface<'a> {
    vertices: &'a [Vec3],
    normals: &'a [Vec3],
    parts: &'a [Option<Part>],
}

impl Surface<'_> {
    fn is_fold(&self, a: usize, b: usize) -> bool {
        let between = self.normals[a].dot(self.normals[b]);
        let hollow = (self.vertices[b] - self.vertices[a]).dot(self.normals[b] - self.normals[a]) < 0.0;
        let near = self.vertices[a].distance_squared(self.vertices[b]) < DEEPEST * DEEPEST;
        between < OPPOSED && (hollow || (near && between < GROWN_IN))
    }
}

/// Notes for the vertices of part `from` those of part `to` that face them.
fn look(s: &Surface<'_>, from: Part, to: Part, found: &mut [(u32, f32)]) {
    let of = |part: Part| s.parts.iter().enumerate().filter(move |(_, p)| **p == Some(part)).map(|(v, _)| v);
    let far = Vec3::splat(REACH);
    let (low, high) = bounds(of(to).filter_map(|v| s.vertices.get(v)));
    let near = |p: &Vec3| p.cmpge(low - far).all() && p.cmple(high + far).all();
    let asking: Vec<usize> = of(from).filter(|&v| s.vertices.get(v).is_some_and(near)).collect();
    let (low, high) = bounds(asking.iter().filter_map(|&v| s.vertices.get(v)));
    let close = |v: usize| s.vertices[v].cmpge(low - far).all() && s.vertices[v].cmple(high + far).all();
    let Some(tree) = PointTree::new(s.vertices, |v| s.parts.get(v) == Some(&Some(to)) && close(v)) else {
        return;
    };
    for v in asking {
        let hit = tree.nearest(s.vertices[v]);
        if s.is_fold(v, hit.index as usize) && hit.distance < found[v].1 {
            found[v] = (hit.index, hit.distance);
        }
    }
}

fn bounds<'a>(points: impl Iterator<Item = &'a Vec3>) -> (Vec3, Vec3) {
    points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_surfaces_that_face_each_other_are_a_fold() {
        let vertices = [Vec3::ZERO, Vec3::Y * 0.01, Vec3::Y * 0.02, Vec3::X];
        let normals = [Vec3::Y, Vec3::NEG_Y, Vec3::Y, Vec3::NEG_Y];
        let parts = [Part::Trunk, Part::ThighLeft, Part::CalfLeft, Part::ThighRight].map(Some);
        assert_eq!(facing(&vertices, &normals, &parts), [1, 0, 1, NONE]);
        assert_eq!(facing(&vertices, &normals, &[None; 4]), [NONE; 4]);
    }

    #[test]
    fn a_crease_is_a_fold_and_the_ridge_of_a_bent_knee_is_not() {
        let normals = [Vec3::new(0.8, 0.6, 0.0), Vec3::new(-0.8, 0.6, 0.0)];
        let parts = [Part::ThighLeft, Part::CalfLeft].map(Some);
        let crease = [Vec3::X * -0.007, Vec3::X * 0.007];
        assert_eq!(facing(&crease, &normals, &parts), [1, 0]);
        let ridge = [Vec3::X * 0.007, Vec3::X * -0.007];
        assert_eq!(facing(&ridge, &normals, &parts), [1, 0], "opposed: grown into itself");
        let open = [Vec3::new(0.6, 0.8, 0.0), Vec3::new(-0.6, 0.8, 0.0)];
        assert_eq!(facing(&crease, &open, &parts), [1, 0]);
        assert_eq!(facing(&ridge, &open, &parts), [NONE; 2]);
        assert_eq!(facing(&[ridge[0] * 2.0, ridge[1] * 2.0], &normals, &parts), [NONE; 2], "a thin knee");
    }
}
