//! Small loose pieces (bows, buttons, pockets) ride on the garment that carries them.
//!
//! Nothing sews them on, so a network of cloth would let them fall. Training does the same
//! (`model/garment/ornaments.py`).

use glam::Vec3;
use toile_geometry::mesh::Adjacency;
use toile_geometry::nearest::PointTree;

use crate::graph::Links;

/// Pieces whose bounding box has a diagonal below this are small, metres.
const SMALL: f32 = 0.25;
/// A small piece is carried when some vertex of it lies this near to a larger one, metres.
const TOUCHES: f32 = 0.03;

/// Gives every vertex of a small piece the links of the vertex that carries it.
pub fn ride(links: &mut Links, rest: &[Vec3], ring: &Adjacency) {
    for (vertex, carrier) in carriers(rest, ring).into_iter().enumerate() {
        if let Some(carrier) = carrier {
            links.copy_row(carrier as usize, vertex);
        }
    }
}

/// For every vertex of a carried piece the nearest vertex of the larger pieces.
fn carriers(rest: &[Vec3], ring: &Adjacency) -> Vec<Option<u32>> {
    let pieces = pieces(rest.len(), ring);
    let mut small = vec![false; rest.len()];
    for piece in &pieces {
        let at = || piece.iter().filter_map(|&v| rest.get(v as usize));
        let low = at().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = at().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        if (high - low).length() < SMALL {
            piece.iter().filter_map(|&v| small.get_mut(v as usize).map(|s| *s = true)).for_each(drop);
        }
    }
    let is_small = |v: u32| small.get(v as usize).copied().unwrap_or(true);
    let mut out = vec![None; rest.len()];
    let Some(large) = PointTree::new(rest, |v| !is_small(v as u32)) else { return out };
    for piece in pieces.iter().filter(|p| p.first().is_some_and(|&v| is_small(v))) {
        let at = |v: u32| rest.get(v as usize).map(|p| (v as usize, large.nearest(*p)));
        let hits: Vec<_> = piece.iter().filter_map(|&v| at(v)).collect();
        if hits.iter().any(|(_, hit)| hit.distance < TOUCHES) {
            hits.iter().for_each(|(v, hit)| out[*v] = Some(hit.index));
        }
    }
    out
}

/// Vertices of each connected piece.
fn pieces(count: usize, ring: &Adjacency) -> Vec<Vec<u32>> {
    let (mut seen, mut out) = (vec![false; count], Vec::new());
    for seed in 0..count {
        if std::mem::replace(&mut seen[seed], true) {
            continue;
        }
        let (mut piece, mut next) = (vec![seed as u32], 0);
        while let Some(&v) = piece.get(next) {
            next += 1;
            for &w in ring.of(v as usize) {
                if !std::mem::replace(&mut seen[w as usize], true) {
                    piece.push(w);
                }
            }
        }
        out.push(piece);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of squares along x, `count` of 5 cm, at height `y`.
    fn strip(count: u32, y: f32, first: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let points = (0..2 * (count + 1)).map(|i| Vec3::new((i / 2) as f32 * 0.05, y, (i % 2) as f32 * 0.05));
        let faces = (0..count).flat_map(|c| {
            let i = first + 2 * c;
            [[i, i + 2, i + 1], [i + 1, i + 2, i + 3]]
        });
        (points.collect(), faces.collect())
    }

    #[test]
    fn a_small_piece_rides_on_the_large_one_near_it_and_a_far_one_does_not() {
        let (mut points, mut faces) = strip(12, 0.0, 0);
        for (y, near) in [(0.01, true), (0.2, false)] {
            let first = points.len() as u32;
            let (more, more_faces) = strip(2, y, first);
            points.extend(more);
            faces.extend(more_faces);
            let found = carriers(&points, &Adjacency::new(points.len(), &faces));
            assert!(found[..26].iter().all(Option::is_none));
            assert_eq!(found[first as usize], near.then_some(0));
        }
    }
}
