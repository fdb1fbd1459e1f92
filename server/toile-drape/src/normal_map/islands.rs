//! UV islands: what hangs together in texture space, and how large it is on the cloth.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::NormalMapError;
use super::packing::{Box2, pack};
use super::patch::{Patch, pick};
use crate::outfit_build::components::{root_of, unite};

/// More islands than this leave no texels between their gutters.
pub(super) const MOST: usize = 1024;
/// Triangles whose UVs have less than this share of their own area say nothing of where they are.
const FLAT: f32 = 0.02;
/// Share of a garment's area that may lie in such triangles.
const MOST_FLAT: f32 = 0.05;

/// One island: its bounds in UVs, and metres a unit of u and of v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Island {
    low: Vec2,
    high: Vec2,
    metres: Vec2,
}

impl Island {
    /// Metres.
    fn size(&self) -> Vec2 {
        (self.high - self.low) * self.metres
    }
}

/// Islands of a garment.
#[derive(Clone, Debug)]
pub(super) struct Islands {
    /// Island of each drawn vertex; 0 where no triangle has it.
    of: Vec<u32>,
    all: Vec<Island>,
}

impl Islands {
    /// Vertices that triangles link are one island.
    pub(super) fn find(patch: &Patch) -> Self {
        let mut parent: Vec<u32> = (0..patch.welded.len() as u32).collect();
        for &[a, b, c] in &patch.triangles {
            unite(&mut parent, a, b);
            unite(&mut parent, b, c);
        }
        let mut island_of = HashMap::new();
        let mut of = vec![0; patch.welded.len()];
        for &corner in patch.triangles.iter().flatten() {
            let next = island_of.len() as u32;
            let island = *island_of.entry(root_of(&mut parent, corner)).or_insert(next);
            if let Some(slot) = of.get_mut(corner as usize) {
                *slot = island;
            }
        }
        let all = measured(patch, &of, island_of.len());
        Self { of, all }
    }

    /// Lays all islands side by side in the unit square, to one scale: UVs of the drawn vertices, and the boxes.
    ///
    /// # Errors
    /// When there are too many, or they have no area.
    pub(super) fn lay_out(&self, patch: &Patch) -> Result<(Vec<Vec2>, Vec<Box2>), NormalMapError> {
        if self.flat_share(patch) > MOST_FLAT {
            return Err(NormalMapError::NoUvs { garment: patch.name.clone() });
        }
        let fragmented =
            || NormalMapError::Fragmented { garment: patch.name.clone(), islands: self.all.len() };
        if self.all.len() > MOST {
            return Err(fragmented());
        }
        let sizes: Vec<Vec2> = self.all.iter().map(Island::size).collect();
        let places = pack(&sizes).ok_or_else(fragmented)?;
        let place = |(uv, &island): (&Vec2, &u32)| {
            let (Some(from), Some(place)) = (self.all.get(island as usize), places.get(island as usize))
            else {
                return Vec2::ZERO;
            };
            place.put((*uv - from.low) * from.metres).clamp(Vec2::ZERO, Vec2::ONE)
        };
        let uvs = patch.uvs.iter().zip(&self.of).map(place).collect();
        Ok((uvs, places.iter().map(|place| place.bounds).collect()))
    }

    /// Share of the garment's area that is nothing, or next to nothing, in UVs.
    fn flat_share(&self, patch: &Patch) -> f32 {
        let (mut all, mut flat) = (0.0_f32, 0.0_f32);
        for &triangle in &patch.triangles {
            let metres = self.all.get(pick(&self.of, triangle[0]) as usize).map_or(Vec2::ZERO, |i| i.metres);
            let [a, b, c] = Patch::corners(&patch.uvs, triangle).map(|uv| uv * metres);
            let (in_uvs, on_cloth) = ((b - a).perp_dot(c - a).abs(), area(patch, triangle));
            all += on_cloth;
            // Not a number is flat too.
            flat += if in_uvs >= FLAT * on_cloth { 0.0 } else { on_cloth };
        }
        if all > 0.0 { flat / all } else { 1.0 }
    }
}

/// Twice the area on the cloth, square metres.
fn area(patch: &Patch, triangle: [u32; 3]) -> f32 {
    let [a, b, c] = Patch::corners(&patch.positions, triangle);
    (b - a).cross(c - a).length()
}

/// Bounds and scale of every island. The scale is the mean over its area in UVs.
fn measured(patch: &Patch, of: &[u32], count: usize) -> Vec<Island> {
    let start = Island { low: Vec2::INFINITY, high: Vec2::NEG_INFINITY, metres: Vec2::ZERO };
    let (mut all, mut areas) = (vec![start; count], vec![0.0_f32; count]);
    for &triangle in &patch.triangles {
        let index = pick(of, triangle[0]) as usize;
        let (Some(island), Some(total)) = (all.get_mut(index), areas.get_mut(index)) else { continue };
        let uvs = Patch::corners(&patch.uvs, triangle);
        for uv in uvs {
            (island.low, island.high) = (island.low.min(uv), island.high.max(uv));
        }
        let [along_u, along_v, weight] = slopes(Patch::corners(&patch.positions, triangle), uvs);
        island.metres += Vec2::new(along_u.length(), along_v.length());
        *total += weight.x;
    }
    for (island, total) in all.iter_mut().zip(areas) {
        island.metres = if total > 0.0 { island.metres / total } else { Vec2::ZERO };
    }
    all
}

/// Change of the position with u and with v, each times twice the area in UVs, and that area.
fn slopes([a, b, c]: [Vec3; 3], uvs: [Vec2; 3]) -> [Vec3; 3] {
    let (e1, e2) = (b - a, c - a);
    let (d1, d2) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
    [e1 * d2.y - e2 * d1.y, e2 * d1.x - e1 * d2.x, Vec3::splat(d1.perp_dot(d2).abs())]
}
