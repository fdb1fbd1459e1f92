//! Carrying an outfit to another body shape: made to measure, bone lengths and girth.

use glam::{Affine3A, DMat3, DVec3, Vec3};
use toile_geometry::body::{Body, BodyShape};
use toile_geometry::nearest::PointTree;
use toile_geometry::normals::vertex_normals;

use crate::contact::Collider;
use crate::outfit::Outfit;
use crate::push_out::pushes;
use crate::reference::{GARMENT_JOINTS, ReferenceBody};
use crate::static_pass::StaticPass;

/// Cloth keeps at most this much of its rest distance to the skin on another body, metres.
const MARGIN: f32 = 0.003;
const ROUNDS: usize = 4;
/// Pull of each joint's map towards plain translation, square metres.
const RIDGE: f64 = 20.0 * 1e-4;

/// The rest pose of an outfit on another body shape, pushed out where the carried cloth would enter the skin.
///
/// Each garment joint gets the affine map that best takes its part of the reference body to the other body;
/// blended by the diffused skin weights they carry the cloth without a seam between limbs. What the blend
/// misses (belly, bust) follows the skin around each vertex. Training does the same
/// (`model/garment/carry.py`). `apose`: vertices of the shape in the A-pose, metres.
#[must_use]
pub fn carried(
    statics: &StaticPass,
    reference: &ReferenceBody,
    apose: &[Vec3],
    triangles: &[[u32; 3]],
) -> Vec<Vec3> {
    let maps = joint_maps(reference, apose);
    let missed: Vec<Vec3> = (0..apose.len().min(reference.vertices.len()))
        .map(|v| {
            apose[v] - blended(&maps, reference.skin[v].iter().copied().enumerate(), reference.vertices[v])
        })
        .collect();
    let field = statics.field();
    let followed: Vec<Vec3> = (0..statics.shape.len())
        .map(|node| statics.shape.row(node).fold(Vec3::ZERO, |sum, (b, w)| sum + missed[b] * w))
        .collect();
    let rig = &statics.rig;
    let influences = rig.prior_joints.iter().zip(&rig.prior_weights);
    let mut out: Vec<Vec3> = influences
        .zip(&statics.rest)
        .zip(field.smoothed(followed, statics.rest.len()))
        .map(|(((joints, weights), p), residual)| {
            let row = joints.iter().map(|&j| j as usize).zip(weights.iter().copied());
            blended(&maps, row, *p) + residual
        })
        .collect();
    push_off(statics, reference, apose, triangles, &mut out);
    out
}

fn push_off(
    statics: &StaticPass,
    reference: &ReferenceBody,
    apose: &[Vec3],
    triangles: &[[u32; 3]],
    positions: &mut [Vec3],
) {
    let normals = vertex_normals(apose, triangles);
    let skin = Collider {
        vertices: apose,
        normals: &normals,
        ring: &reference.ring,
        facing: &[],
        cells: None,
        feet: [&[]; 2],
    };
    let field = statics.field();
    for round in 0..ROUNDS {
        let need: Vec<Vec3> = positions
            .iter()
            .enumerate()
            .map(|(v, p)| {
                let (distance, normal) = skin.clearance(*p, statics.candidates_of(v));
                normal * (statics.clearance[v].clamp(0.001, MARGIN) - distance).max(0.0)
            })
            .collect();
        let need = pushes(&need);
        let push = if round + 1 < ROUNDS { field.spread(&need) } else { need };
        push.into_iter().for_each(|(v, way)| positions[v as usize] += way);
    }
}

/// Affine map of each garment joint from the reference body to the shape: least squares over its skin.
fn joint_maps(reference: &ReferenceBody, apose: &[Vec3]) -> Vec<Affine3A> {
    (0..GARMENT_JOINTS).map(|joint| joint_map(reference, apose, joint)).collect()
}

fn joint_map(reference: &ReferenceBody, apose: &[Vec3], joint: usize) -> Affine3A {
    let rows = || {
        let pairs = reference.vertices.iter().zip(apose);
        pairs.zip(&reference.skin).map(move |((r, s), w)| (r.as_dvec3(), s.as_dvec3(), f64::from(w[joint])))
    };
    let rows = || rows().filter(|(_, _, w)| *w > 0.0);
    let total: f64 = rows().map(|r| r.2).sum::<f64>().max(1e-6);
    let centre = rows().fold(DVec3::ZERO, |sum, (r, _, w)| sum + r * w) / total;
    let moved = rows().fold(DVec3::ZERO, |sum, (_, s, w)| sum + s * w) / total;
    let (mut covariance, mut cross) = (DMat3::from_diagonal(DVec3::splat(RIDGE)), DMat3::ZERO);
    for (r, s, w) in rows() {
        let a = r - centre;
        let b = s - moved - a;
        covariance += outer(a, a) * (w / total);
        cross += outer(b, a) * (w / total);
    }
    let linear = cross * covariance.inverse() + DMat3::IDENTITY;
    let shift = moved - linear * centre;
    Affine3A::from_mat3_translation(linear.as_mat3(), shift.as_vec3())
}

/// a times b transposed.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn blended(maps: &[Affine3A], row: impl Iterator<Item = (usize, f32)>, point: Vec3) -> Vec3 {
    row.filter(|(_, w)| *w > 0.0)
        .filter_map(|(joint, w)| maps.get(joint).map(|m| m.transform_point3(point) * w))
        .fold(Vec3::ZERO, |sum, p| sum + p)
}

/// Body vertices whose displacement a vertex follows when an outfit comes from another body.
const FOLLOWED: usize = 24;

/// An outfit fitted on another shape, moved to the reference body: welded positions, rest space.
#[must_use]
pub fn carried_to_reference(
    outfit: &Outfit,
    reference: &ReferenceBody,
    body: &Body,
    fitted_on: &BodyShape,
) -> Vec<Vec3> {
    if *fitted_on == BodyShape::default() {
        return outfit.positions.clone();
    }
    let from = body.shape(fitted_on).apose_vertices;
    let Some(tree) = PointTree::new(&from, |_| true) else { return outfit.positions.clone() };
    let follow = |p: &Vec3| {
        let hits = tree.nearest_n(*p, FOLLOWED);
        let least = hits.first().map_or(0.0, |h| h.distance);
        let spread = (0.5 * least).max(0.02);
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for hit in hits {
            let weight = (-0.5 * ((hit.distance - least) / spread).powi(2)).exp();
            sum += (reference.vertices[hit.index as usize] - from[hit.index as usize]) * weight;
            total += weight;
        }
        *p + sum / total.max(f32::MIN_POSITIVE)
    };
    outfit.positions.iter().map(follow).collect()
}
