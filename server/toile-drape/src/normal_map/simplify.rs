//! Fewer triangles over the same vertices, by quadric edge collapses of the `meshopt` crate (meshoptimizer).
//!
//! After M. Garland, P. S. Heckbert, *Surface Simplification Using Quadric Error Metrics*, SIGGRAPH 1997.

use std::collections::HashMap;
use std::ops::Range;

use glam::{Vec2, Vec3};
use meshopt::{SimplifyOptions, simplify_with_attributes_and_locks_decoder};

use super::patch::{Patch, pick};

/// A triangle in this many stays …
const FACTOR: usize = 4;
/// … or as many as are this large on average, if they are fewer, square metres.
const AREA: f32 = 8e-4;
/// Garments keep at least so many triangles, if they have them.
const LEAST: usize = 64;
/// How much it counts, against an error of positions, when places move in the picture.
const UV_WEIGHT: f32 = 0.5;
/// Largest error, of the garment's extent.
const MOST_ERROR: f32 = 0.05;

/// The garment's triangles by part, simplified in its rest pose. UVs (unit square) are kept with the positions;
/// where parts meet, vertices stay.
pub(super) fn simplify(patch: &Patch, uvs: &[Vec2]) -> Vec<Vec<[u32; 3]>> {
    let positions: Vec<[f32; 3]> = patch.positions.iter().map(Vec3::to_array).collect();
    let places: Vec<f32> = uvs.iter().flat_map(|uv| uv.to_array()).collect();
    let locks = shared_by_parts(patch);
    let simplified = |part: &Range<usize>| {
        let triangles = patch.triangles.get(part.clone()).unwrap_or(&[]);
        let indices = triangles.as_flattened();
        // Even triangles bend better than the few large ones that a flat rest pose would do with.
        let options = SimplifyOptions::Sparse | SimplifyOptions::Regularize;
        let (weights, stride, target) = ([UV_WEIGHT; 2], size_of::<[f32; 2]>(), 3 * target(patch, triangles));
        let fewer = simplify_with_attributes_and_locks_decoder(
            indices, &positions, &places, &weights, stride, &locks, target, MOST_ERROR, options, None,
        );
        fewer.as_chunks::<3>().0.to_vec()
    };
    patch.parts.iter().map(simplified).collect()
}

fn target(patch: &Patch, triangles: &[[u32; 3]]) -> usize {
    let area = |&t: &[u32; 3]| {
        let [a, b, c] = Patch::corners(&patch.positions, t);
        (b - a).cross(c - a).length() / 2.0
    };
    let area: f32 = triangles.iter().map(area).sum();
    (triangles.len() / FACTOR).min((area / AREA) as usize).max(LEAST)
}

/// Whether a vertex lies where triangles of several parts meet.
fn shared_by_parts(patch: &Patch) -> Vec<bool> {
    let mut part_of: HashMap<u32, Option<usize>> = HashMap::new();
    for (index, part) in patch.parts.iter().enumerate() {
        for &corner in patch.triangles.get(part.clone()).unwrap_or(&[]).as_flattened() {
            let only = part_of.entry(pick(&patch.welded, corner)).or_insert(Some(index));
            *only = only.filter(|only| *only == index);
        }
    }
    patch.welded.iter().map(|vertex| part_of.get(vertex).is_some_and(Option::is_none)).collect()
}
