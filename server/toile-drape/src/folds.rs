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
        let opposed = s.normals[v].dot(s.normals[hit.index as usize]) < OPPOSED;
        if opposed && hit.distance < found[v].1 {
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
}
