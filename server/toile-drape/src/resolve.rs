//! After the dynamic pass: cloth out of the body, and outer garments out of inner ones, smoothly.

use glam::Vec3;
use toile_geometry::normals::vertex_normals;

use crate::outfit::Outfit;
use crate::push_out::{Collider, Field};
use crate::static_pass::StaticPass;

/// Distance that draped cloth keeps from the skin, metres, where its rest pose does too.
const SKIN_GAP: f32 = 0.003;
/// Distance that layers keep, metres, where their rest poses do too.
const LAYER_GAP: f32 = 0.002;
/// Rounds of smooth pushes; the last ones move single vertices.
const SMOOTH_ROUNDS: usize = 4;
const EXACT_ROUNDS: usize = 2;
/// Triangles with an edge longer than this are also tested at their centroids, metres.
const COARSE_EDGE: f32 = 0.015;

/// What the resolve found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resolved {
    /// Depth of every vertex in the body before, metres; 0 outside.
    pub depth_before: Vec<f32>,
    /// Vertices inside the body before.
    pub inside_before: usize,
    /// Vertices inside the body after.
    pub inside_after: usize,
}

/// Moves world `positions` (welded order) out of the body and the layers below.
pub fn resolve(
    outfit: &Outfit,
    statics: &StaticPass,
    body: &Collider<'_>,
    positions: &mut [Vec3],
) -> Resolved {
    let field = Field { vertex_from_node: &statics.vertex_from_node, near: &statics.near };
    let clearance = |v: usize, p: Vec3| body.clearance(p, statics.candidates_of(v));
    let depth_before: Vec<f32> =
        positions.iter().enumerate().map(|(v, p)| (-clearance(v, *p).0).max(0.0)).collect();
    let coarse = coarse_triangles(outfit, statics);
    for round in 0..SMOOTH_ROUNDS + EXACT_ROUNDS {
        let mut need = skin_needs(statics, body, positions, &coarse);
        add_layer_needs(outfit, statics, positions, &mut need);
        if need.iter().all(|n| *n == Vec3::ZERO) {
            break;
        }
        let push = if round < SMOOTH_ROUNDS { field.spread(&need) } else { need };
        positions.iter_mut().zip(push).for_each(|(p, d)| *p += d);
    }
    let inside_after = positions.iter().enumerate().filter(|(v, p)| clearance(*v, **p).0 < 0.0).count();
    Resolved { inside_before: depth_before.iter().filter(|d| **d > 0.0).count(), inside_after, depth_before }
}

fn coarse_triangles<'o>(outfit: &'o Outfit, statics: &StaticPass) -> Vec<&'o [u32; 3]> {
    let at = |i: u32| statics.rest.get(i as usize).copied().unwrap_or_default();
    let longest = |t: &[u32; 3]| {
        let [a, b, c] = t.map(at);
        a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
    };
    outfit.triangles.iter().filter(|t| longest(t) > COARSE_EDGE * COARSE_EDGE).collect()
}

/// What each vertex lacks to its distance from the skin, also at the centroids of coarse triangles.
fn skin_needs(
    statics: &StaticPass,
    body: &Collider<'_>,
    positions: &[Vec3],
    coarse: &[&[u32; 3]],
) -> Vec<Vec3> {
    let gap = |v: usize| statics.clearance.get(v).map_or(SKIN_GAP, |c| c.clamp(0.001, SKIN_GAP));
    let mut need: Vec<Vec3> = positions
        .iter()
        .enumerate()
        .map(|(v, p)| {
            let (distance, normal) = body.clearance(*p, statics.candidates_of(v));
            normal * (gap(v) - distance).max(0.0)
        })
        .collect();
    for triangle in coarse {
        let corners = triangle.map(|i| positions.get(i as usize).copied().unwrap_or_default());
        let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
        let (distance, normal) = body.clearance(centroid, statics.candidates_of(triangle[0] as usize));
        let lack = 0.5 * gap(triangle[0] as usize) - distance;
        if lack > 0.0 {
            for &i in *triangle {
                let slot = &mut need[i as usize];
                if slot.length_squared() < lack * lack {
                    *slot = normal * lack;
                }
            }
        }
    }
    need
}

/// Adds what outer vertices lack to their distance from the inner garment under them.
fn add_layer_needs(outfit: &Outfit, statics: &StaticPass, positions: &[Vec3], need: &mut [Vec3]) {
    if statics.layers.is_empty() {
        return;
    }
    let moved: Vec<Vec3> = positions.iter().zip(&*need).map(|(p, n)| *p + *n).collect();
    let normals = vertex_normals(&moved, &outfit.triangles);
    let inner = Collider { vertices: &moved, normals: &normals, ring: &statics.ring };
    for (outer, candidates, gap) in statics.layers.iter() {
        let Some(point) = moved.get(outer).copied() else { continue };
        let (distance, normal) = inner.clearance(point, candidates);
        let lack = gap.clamp(0.0005, LAYER_GAP) - distance;
        if lack > 0.0 {
            need[outer] += normal * lack;
        }
    }
}
