//! A coarse mesh of an outfit, and pictures that give it back the folds of the fine drape.
//!
//! What depends on the outfit alone is [`CoarseOutfit`]: fewer triangles over some of the fine mesh's own drawn
//! vertices, and a second UV set in which no two places share a texel. Of each drape, [`CoarseOutfit::shade`] makes
//! the coarse mesh's normals and tangents, and [`CoarseOutfit::bake`] a picture a garment.

mod bake;
mod charts;
mod error;
mod islands;
mod packing;
mod patch;
mod simplify;
mod tangents;
mod texels;

use std::ops::Range;

use glam::{Vec2, Vec3};

use crate::outfit::{Garment, Outfit, Part, Surface};

pub use self::bake::NormalMap;
pub use self::error::NormalMapError;
pub use self::tangents::Shading;

use self::islands::Islands;
use self::packing::Box2;
use self::patch::{Patch, pick};

/// An outfit's coarse mesh with a UV set of its own. It depends on the outfit alone.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarseOutfit {
    /// Garments, parts, materials and welded positions of the fine outfit; fewer triangles, fewer drawn vertices.
    pub outfit: Outfit,
    /// Where each coarse drawn vertex lies in its garment's picture, in the unit square, v downwards.
    pub uvs: Vec<Vec2>,
    /// What each garment's picture is made of.
    sources: Vec<Source>,
}

/// A garment's fine mesh in its picture.
#[derive(Clone, Debug, PartialEq)]
struct Source {
    /// Welded vertex of each vertex, counted from the outfit's first.
    welded: Vec<u32>,
    /// Where it lies in the picture.
    uvs: Vec<Vec2>,
    /// Triangles over these vertices.
    triangles: Vec<[u32; 3]>,
    /// Boxes of the islands in the unit square; no two overlap.
    boxes: Vec<Box2>,
    /// Texels each way that the folds ask for.
    side: usize,
}

impl CoarseOutfit {
    /// Simplifies `fine`, whose welded vertices lie at `rest` (metres), and lays its UV islands out anew.
    ///
    /// # Errors
    /// When a garment has no UVs, or none that tell its places apart.
    pub fn new(fine: &Outfit, rest: &[Vec3]) -> Result<Self, NormalMapError> {
        let outfit = Outfit {
            name: fine.name.clone(),
            positions: rest.to_vec(),
            materials: fine.materials.clone(),
            ..Outfit::default()
        };
        let mut out = Self { outfit, uvs: Vec::new(), sources: Vec::new() };
        for garment in &fine.garments {
            out.add(fine, garment)?;
        }
        Ok(out)
    }

    /// Bytes that the coarse mesh of an outfit takes at most, for a cache that counts them beforehand.
    #[must_use]
    pub fn byte_bound(fine: &Outfit) -> usize {
        // Of each fine vertex the welded one and a UV, a coarse one for every second with its template; of each fine
        // triangle its corners, and two lists and a template of a quarter.
        const VERTEX: usize = 3 * size_of::<u32>() + 3 * size_of::<Vec2>();
        const TRIANGLE: usize = 2 * size_of::<[u32; 3]>();
        let positions = size_of_val(fine.positions.as_slice());
        fine.surface.vertex_of.len() * VERTEX + fine.triangles.len() * TRIANGLE + positions
    }

    /// Coarse triangles of garment `index`, over coarse drawn vertices.
    fn triangles(&self, index: usize) -> &[[u32; 3]] {
        let garment = self.outfit.garments.get(index);
        garment.and_then(|g| self.outfit.surface.triangles.get(range(&g.triangles()))).unwrap_or(&[])
    }

    fn add(&mut self, fine: &Outfit, garment: &Garment) -> Result<(), NormalMapError> {
        let patch = Patch::new(fine, &self.outfit.positions, garment)?;
        let (uvs, _) = Islands::find(&patch).lay_out(&patch)?;
        let patch = charts::cut(&patch, &uvs, islands::MOST);
        let (uvs, boxes) = Islands::find(&patch).lay_out(&patch)?;
        let side = texels::check(&patch, &uvs)?;
        let parts = simplify::simplify(&patch, &uvs);
        self.push_garment(garment, &patch, &uvs, &parts);
        let Patch { welded, triangles, .. } = patch;
        self.sources.push(Source { welded, uvs, triangles, boxes, side });
        Ok(())
    }

    /// Adds the simplified garment with the drawn vertices that its triangles still have, in the fine order.
    fn push_garment(&mut self, fine: &Garment, patch: &Patch, uvs: &[Vec2], parts: &[Vec<[u32; 3]>]) {
        let surface = &mut self.outfit.surface;
        let first = surface.vertex_of.len() as u32;
        let coarse_of = coarse_vertices(surface, patch, parts);
        let kept = coarse_of.iter().zip(uvs).filter(|(coarse, _)| coarse.is_some());
        self.uvs.extend(kept.map(|(_, uv)| *uv));
        let mut garment = Garment {
            name: fine.name.clone(),
            layer: fine.layer,
            vertices: fine.vertices.clone(),
            drawn_vertices: first..surface.vertex_of.len() as u32,
            parts: Vec::new(),
        };
        for (part, triangles) in fine.parts.iter().zip(parts) {
            let start = surface.triangles.len() as u32;
            let drawn = triangles.iter().map(|t| t.map(|i| pick(&coarse_of, i).unwrap_or(first)));
            surface.triangles.extend(drawn);
            self.outfit.triangles.extend(triangles.iter().map(|t| t.map(|i| pick(&patch.welded, i))));
            let triangles = start..surface.triangles.len() as u32;
            garment.parts.push(Part { material: part.material, triangles });
        }
        self.outfit.garments.push(garment);
    }
}

/// Adds the vertices that `parts` use to a surface; the new index of each vertex of the patch.
fn coarse_vertices(surface: &mut Surface, patch: &Patch, parts: &[Vec<[u32; 3]>]) -> Vec<Option<u32>> {
    let mut used = vec![false; patch.welded.len()];
    for &corner in parts.iter().flatten().flatten() {
        if let Some(slot) = used.get_mut(corner as usize) {
            *slot = true;
        }
    }
    let mut add = |(vertex, used): (usize, bool)| {
        used.then(|| {
            surface.vertex_of.push(pick(&patch.welded, vertex as u32));
            surface.uvs.push(pick(&patch.uvs, vertex as u32));
            surface.vertex_of.len() as u32 - 1
        })
    };
    used.into_iter().enumerate().map(&mut add).collect()
}

fn range(of: &Range<u32>) -> Range<usize> {
    of.start as usize..of.end as usize
}

#[cfg(test)]
mod tests;
