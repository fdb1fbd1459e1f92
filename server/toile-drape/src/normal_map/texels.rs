//! Which texels a triangle covers.

use glam::{Vec2, Vec3};

use super::NormalMapError;
use super::patch::Patch;

/// Side of the picture on which overlaps are counted.
const SIDE: usize = 512;
/// Sides to choose from, and texels that an edge of the fine mesh should have: normals are linear between its ends.
const SIDES: [usize; 3] = [128, 256, 512];
const TEXELS_AN_EDGE: f32 = 2.0;
/// How far within both triangles a texel must lie, of their heights, to count as covered twice.
const INSIDE: f32 = 0.02;
/// Share of a garment's texels that may be covered twice; those show one of both places.
const MOST_TWICE: f32 = 0.05;

/// Calls `visit` with every texel of a square picture whose centre lies in a triangle of the unit square, and the
/// weights of the triangle's corners there. Texels run along rows from the corner at UV (0, 0).
pub(super) fn each_texel(side: usize, corners: [Vec2; 3], mut visit: impl FnMut(usize, Vec3)) {
    // Centres on an edge belong to both sides: better twice than a crack.
    const EDGE: f32 = -1e-4;
    // Texel (0, 0) has its centre at the origin.
    let [a, b, c] = corners.map(|uv| uv * side as f32 - Vec2::splat(0.5));
    let double_area = (b - a).perp_dot(c - a);
    if double_area.abs() < 1e-6 || !double_area.is_finite() {
        return;
    }
    let (low, high) = (a.min(b).min(c).ceil().max(Vec2::ZERO), a.max(b).max(c).floor());
    let last = |end: f32| (end + 1.0).clamp(0.0, side as f32) as usize;
    for y in low.y as usize..last(high.y) {
        for x in low.x as usize..last(high.x) {
            let at = Vec2::new(x as f32, y as f32);
            let (wb, wc) = ((at - a).perp_dot(c - a) / double_area, (b - a).perp_dot(at - a) / double_area);
            let weights = Vec3::new(1.0 - wb - wc, wb, wc);
            if weights.min_element() >= EDGE {
                visit(y * side + x, weights);
            }
        }
    }
}

/// Texels each way that the fine mesh's edges ask for; refuses UVs in the unit square of which too many texels
/// belong to several places.
///
/// # Errors
/// When an island lies over itself.
pub(super) fn check(patch: &Patch, uvs: &[Vec2]) -> Result<usize, NormalMapError> {
    let mut counts = vec![0_u8; SIDE * SIDE];
    for &triangle in &patch.triangles {
        each_texel(SIDE, Patch::corners(uvs, triangle), |texel, weights| {
            if let Some(count) = counts.get_mut(texel).filter(|_| weights.min_element() > INSIDE) {
                *count = count.saturating_add(1);
            }
        });
    }
    let covered = counts.iter().filter(|count| **count > 0).count();
    let twice = counts.iter().filter(|count| **count > 1).count();
    let share = twice as f32 / covered.max(1) as f32;
    if covered == 0 {
        return Err(NormalMapError::NoUvs { garment: patch.name.clone() });
    }
    if share > MOST_TWICE {
        return Err(NormalMapError::Overlapping { garment: patch.name.clone(), percent: 100.0 * share });
    }
    // Of triangles of equal sides.
    let edge = (2.31 * covered as f32 / patch.triangles.len() as f32).sqrt() / SIDE as f32;
    let enough = SIDES.into_iter().find(|side| edge * *side as f32 >= TEXELS_AN_EDGE);
    Ok(enough.unwrap_or(SIDE))
}
