//! What draped layers lack to their distance from each other.

use glam::Vec3;
use toile_geometry::nearest::descend;
use toile_geometry::normals::vertex_normals;

use crate::resolve::{STILL, TOLERANCE};
use crate::static_pass::StaticPass;

/// Distance that layers keep, metres, where their rest poses do too: never less, and no more but for what their triangles
/// sink in between their corners.
const GAP: (f32, f32) = (0.0005, 0.002);

/// What lies under each outer garment, kept up to date from round to round of the resolve.
pub struct LayerContact<'a> {
    statics: &'a StaticPass,
    triangles: &'a [[u32; 3]],
    sags: &'a [f32],
    /// Vertex of the other garment nearest to each pair's own.
    hits: Vec<u32>,
    normals: Vec<Vec3>,
    /// Where the cloth was in the round before, metres.
    last: Vec<Vec3>,
}

impl<'a> LayerContact<'a> {
    /// Of an outfit with these triangles; `sags`: how far the cloth around each vertex may sink in, metres.
    pub fn new(statics: &'a StaticPass, triangles: &'a [[u32; 3]], sags: &'a [f32]) -> Self {
        Self { statics, triangles, sags, hits: vec![0; statics.layers.len()], normals: vec![], last: vec![] }
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
            let sag = |v: usize| self.sags.get(v).copied().unwrap_or(0.0);
            let lack = gap.abs().clamp(GAP.0, GAP.1 + sag(v) + sag(hit))
                - gap.signum() * (point - *other).dot(*normal);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::layer_contacts;
    use crate::test_meshes::sheets;
    use toile_geometry::mesh::Adjacency;

    #[test]
    fn cloth_that_sinks_in_between_its_corners_keeps_farther_off() {
        let outfit = sheets(&[(0.0, 12), (0.02, 12)]);
        let statics = StaticPass {
            layers: layer_contacts(&outfit, &outfit.positions),
            ring: Adjacency::new(outfit.positions.len(), &outfit.triangles),
            ..StaticPass::default()
        };
        let mut near = outfit.positions.clone();
        near[120..].iter_mut().for_each(|p| p.y = 0.001);
        let inside = 120 + 55;
        let lack = |sag: f32| {
            let (sags, mut need) = (vec![sag; near.len()], vec![Vec3::ZERO; near.len()]);
            let mut layers = LayerContact::new(&statics, &outfit.triangles, &sags);
            layers.add_needs(|_| 0.0, &near, true, &mut need);
            need[inside]
        };
        assert!(lack(0.0).distance(Vec3::Y * 0.001) < 1e-6, "{}", lack(0.0));
        assert!(lack(0.0015).distance(Vec3::Y * 0.004) < 1e-6, "both sheets sink: {}", lack(0.0015));
    }
}
