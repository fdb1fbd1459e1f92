//! Outer garments over inner ones: which vertices must stay outside of which.

use glam::Vec3;
use toile_geometry::nearest::PointTree;
use toile_geometry::normals::vertex_normals;

use crate::outfit::Outfit;

/// Inner vertices tested for each outer one.
pub const LAYER_CANDIDATES: usize = 8;
/// Farther apart than this at rest, two garments are not watched, metres.
const REACH: f32 = 0.08;

/// Pairs of outer vertices and the inner surface under them, by outer garment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerContacts {
    /// Outer vertices.
    pub outer: Vec<u32>,
    /// [`LAYER_CANDIDATES`] inner vertices each.
    pub inner: Vec<u32>,
    /// Distance along the inner normal at rest, metres.
    pub gap: Vec<f32>,
}

impl LayerContacts {
    /// Number of pairs.
    #[must_use]
    pub fn len(&self) -> usize {
        self.outer.len()
    }

    /// Whether no garments overlap.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.outer.is_empty()
    }

    /// Outer vertex, inner candidates and rest gap of every pair.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &[u32], f32)> {
        let inner = self.inner.chunks_exact(LAYER_CANDIDATES);
        self.outer.iter().zip(inner).zip(&self.gap).map(|((o, i), g)| (*o as usize, i, *g))
    }

    /// Bytes held in memory.
    #[must_use]
    pub fn byte_size(&self) -> usize {
        self.outer.len() * (8 + 4 * LAYER_CANDIDATES)
    }
}

/// Finds the pairs in the mended rest pose.
#[must_use]
pub fn layer_contacts(outfit: &Outfit, rest: &[Vec3]) -> LayerContacts {
    let normals = vertex_normals(rest, &outfit.triangles);
    let mut out = LayerContacts::default();
    for garment in outfit.garments.iter().filter(|g| g.layer > 0) {
        let below = |v: usize| {
            outfit.garments.iter().any(|g| g.layer < garment.layer && g.vertices.contains(&(v as u32)))
        };
        let Some(tree) = PointTree::new(rest, below) else { continue };
        for v in garment.vertices.clone() {
            let (Some(p), hits) = (rest.get(v as usize), &mut Vec::new()) else { continue };
            hits.extend(tree.nearest_n(*p, LAYER_CANDIDATES));
            let (Some(first), Some(last)) = (hits.first(), hits.last()) else { continue };
            let gap = (*p - rest[first.index as usize]).dot(normals[first.index as usize]);
            if first.distance < REACH && gap > 0.0 && gap > 0.5 * first.distance {
                out.outer.push(v);
                out.gap.push(gap);
                out.inner.extend((0..LAYER_CANDIDATES).map(|k| hits.get(k).unwrap_or(last).index));
            }
        }
    }
    out
}
