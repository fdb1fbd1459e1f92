//! What draped layers lack to their distance from each other.

use glam::Vec3;
use toile_geometry::nearest::descend;
use toile_geometry::normals::vertex_normals;

use crate::resolve::{STILL, TOLERANCE};
use crate::static_pass::StaticPass;

/// Distance that layers keep, metres, where their rest poses do too: never less, never more.
const GAP: (f32, f32) = (0.0005, 0.002);

/// What lies under each outer garment, kept up to date from round to round of the resolve.
pub struct LayerContact<'a> {
    statics: &'a StaticPass,
    triangles: &'a [[u32; 3]],
    /// Vertex of the other garment nearest to each pair's own.
    hits: Vec<u32>,
    normals: Vec<Vec3>,
    /// Where the cloth was in the round before, metres.
    last: Vec<Vec3>,
}

impl<'a> LayerContact<'a> {
    /// Of an outfit with these triangles.
    pub fn new(statics: &'a StaticPass, triangles: &'a [[u32; 3]]) -> Self {
        Self { statics, triangles, hits: vec![0; statics.layers.len()], normals: vec![], last: vec![] }
    }

    /// Adds what outer vertices lack to their distance from the inner garment under them, and hems of inner garments
    /// to theirs from the garment over them; a hem gives way where it has `room` over the skin, metres, otherwise the
    /// outer cloth does. `anew`: asks all candidates for the nearest, and takes the normals of the cloth as it is now.
    pub fn add_needs(
        &mut self,
        room: impl Fn(usize) -> f32,
        positions: &[Vec3],
        anew: bool,
        need: &mut [Vec3],
    ) {
        if self.hits.is_empty() {
            return;
        }
        let moved: Vec<Vec3> = positions.iter().zip(&*need).map(|(p, n)| *p + *n).collect();
        if anew {
            self.normals = vertex_normals(&moved, self.triangles);
        }
        let ring = &self.statics.ring;
        // What lacked nothing and has not moved lacks nothing.
        let stays = |(now, before): (&Vec3, &Vec3)| !anew && now.distance_squared(*before) < STILL * STILL;
        let still: Vec<bool> = moved.iter().zip(&self.last).map(stays).collect();
        let is_still = |v: usize| still.get(v).is_some_and(|s| *s);
        for ((v, candidates, gap), kept) in self.statics.layers.iter().zip(&mut self.hits) {
            let Some(point) = moved.get(v).copied() else { continue };
            if is_still(v) && is_still(*kept as usize) {
                continue;
            }
            *kept = descend(point, &moved, if anew { candidates } else { std::slice::from_ref(kept) }, ring);
            let hit = *kept as usize;
            let (Some(other), Some(normal)) = (moved.get(hit), self.normals.get(hit)) else { continue };
            let lack = gap.abs().clamp(GAP.0, GAP.1) - gap.signum() * (point - *other).dot(*normal);
            if lack <= TOLERANCE {
                continue;
            }
            if gap < 0.0 {
                let back = lack.min(room(v));
                need[v] -= *normal * back;
                need[hit] += *normal * (lack - back);
            } else {
                need[v] += *normal * lack;
            }
        }
        self.last = moved;
    }
}
