//! Outer garments over inner ones: which vertices must stay outside of which.

use std::collections::{HashMap, HashSet};

use glam::Vec3;
use toile_geometry::nearest::PointTree;
use toile_geometry::normals::vertex_normals;

use crate::outfit::Outfit;

/// Inner vertices tested for each outer one.
pub const LAYER_CANDIDATES: usize = 8;
/// Farther apart than this at rest, two garments are not watched, metres.
const REACH: f32 = 0.08;

/// Pairs of outer vertices and the inner surface under them, by outer garment; then, with negative gaps, pairs of
/// vertices on open borders of inner garments and the outer surface over them.
///
/// The outer cloth just beyond an inner hem lies over nothing, so the hem itself must be watched.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerContacts {
    /// Outer vertices, or hem vertices.
    pub outer: Vec<u32>,
    /// [`LAYER_CANDIDATES`] vertices each of the inner garments, or of those over the hem.
    pub inner: Vec<u32>,
    /// Distance along their normal at rest, metres; negative behind it.
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

    /// Lessens the `room`, metres, of the nodes of vertices that lie over or under other cloth to their gap at rest.
    pub fn narrow(&self, room: &mut [f32], node_of: impl Fn(usize) -> Option<usize>) {
        for (outer, inner, gap) in self.iter() {
            for v in inner.iter().take(1).map(|v| *v as usize).chain([outer]) {
                if let Some(room) = node_of(v).and_then(|n| room.get_mut(n)) {
                    *room = room.min(gap.abs());
                }
            }
        }
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
    let borders = open_borders(&outfit.triangles);
    let mut out = LayerContacts::default();
    for garment in &outfit.garments {
        let of_layer = |wanted: &dyn Fn(u32) -> bool, v: usize| {
            outfit.garments.iter().any(|g| wanted(g.layer) && g.vertices.contains(&(v as u32)))
        };
        if let Some(tree) = PointTree::new(rest, |v| of_layer(&|l| l < garment.layer, v)) {
            out.watch(garment.vertices.clone(), 1.0, &Cloth { tree, rest, normals: &normals });
        }
        if let Some(tree) = PointTree::new(rest, |v| of_layer(&|l| l > garment.layer, v)) {
            let hems = garment.vertices.clone().filter(|v| borders.contains(v));
            out.watch(hems, -1.0, &Cloth { tree, rest, normals: &normals });
        }
    }
    out
}

/// Garments that others are watched against.
struct Cloth<'a> {
    tree: PointTree,
    rest: &'a [Vec3],
    normals: &'a [Vec3],
}

impl LayerContacts {
    /// Adds the vertices that lie on one side (1 before, -1 behind) of the nearest of other garments' cloth.
    fn watch(&mut self, vertices: impl Iterator<Item = u32>, side: f32, cloth: &Cloth<'_>) {
        for v in vertices {
            let Some(p) = cloth.rest.get(v as usize) else { continue };
            let hits: Vec<_> = cloth.tree.nearest_n(*p, LAYER_CANDIDATES);
            let (Some(first), Some(last)) = (hits.first(), hits.last()) else { continue };
            let at = first.index as usize;
            let gap = side * (*p - cloth.rest[at]).dot(cloth.normals[at]);
            if first.distance < REACH && gap > 0.0 && gap > 0.5 * first.distance {
                self.outer.push(v);
                self.gap.push(side * gap);
                self.inner.extend((0..LAYER_CANDIDATES).map(|k| hits.get(k).unwrap_or(last).index));
            }
        }
    }
}

/// Vertices on edges of one triangle only.
fn open_borders(triangles: &[[u32; 3]]) -> HashSet<u32> {
    let mut uses: HashMap<(u32, u32), u32> = HashMap::new();
    for [a, b, c] in triangles {
        for (i, j) in [(*a, *b), (*b, *c), (*c, *a)] {
            *uses.entry((i.min(j), i.max(j))).or_default() += 1;
        }
    }
    uses.into_iter().filter(|(_, count)| *count == 1).flat_map(|((a, b), _)| [a, b]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::sheets;

    #[test]
    fn a_hem_under_a_longer_garment_must_stay_behind_it() {
        let outfit = sheets(&[(0.0, 6), (0.01, 12)]);
        let contacts = layer_contacts(&outfit, &outfit.positions);
        let rows: Vec<_> = contacts.iter().collect();
        let hem = |v: usize| rows.iter().find(|r| r.0 == v && r.2 < 0.0);
        let (_, over, gap) = hem(55).expect("the last row of the inner sheet is watched");
        assert!((gap + 0.01).abs() < 1e-6);
        assert!(over.iter().all(|&i| i >= 60), "against the outer sheet");
        assert!(hem(25).is_none(), "cloth away from a border is left to the outer vertices");
        assert!(rows.iter().any(|r| r.0 == 60 + 35 && r.2 > 0.0), "those over the inner sheet");
        assert!(rows.iter().all(|r| r.0 != 60 + 115), "cloth beyond the hem lies over nothing");
    }
}
