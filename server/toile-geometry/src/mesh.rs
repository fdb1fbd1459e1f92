//! A triangle mesh and its adjacency.

use glam::Vec3;

/// A triangle mesh in one space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions, metres.
    pub positions: Vec<Vec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// For every vertex its neighbours over edges, in ascending order, as one packed list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Adjacency {
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Adjacency {
    /// Builds the adjacency of `vertex_count` vertices; indices beyond the count are ignored.
    #[must_use]
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut pairs = Vec::with_capacity(triangles.len() * 6);
        for t in triangles.iter().filter(|t| t.iter().all(|&i| (i as usize) < vertex_count)) {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                pairs.push((a, b));
                pairs.push((b, a));
            }
        }
        Self::from_pairs(vertex_count, pairs)
    }

    /// Builds an adjacency from directed pairs `(from, to)` with `from < vertex_count`.
    #[must_use]
    pub fn from_pairs(vertex_count: usize, mut pairs: Vec<(u32, u32)>) -> Self {
        pairs.sort_unstable();
        pairs.dedup();
        let mut starts = vec![0_u32; vertex_count + 1];
        for &(from, _) in &pairs {
            if let Some(count) = starts.get_mut(from as usize + 1) {
                *count += 1;
            }
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        // Collecting from the pairs themselves would keep their memory.
        Self { starts, neighbours: pairs.iter().map(|(_, to)| *to).collect() }
    }

    /// The neighbours of vertex `v`; empty when there is no such vertex.
    #[must_use]
    #[inline]
    pub fn of(&self, v: usize) -> &[u32] {
        match (self.starts.get(v), self.starts.get(v + 1)) {
            (Some(&a), Some(&b)) => self.neighbours.get(a as usize..b as usize).unwrap_or(&[]),
            _ => &[],
        }
    }

    /// Number of vertices.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there are no vertices.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Undirected edges `(a, b)` with `a < b`, sorted, each once.
#[must_use]
pub fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut out: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .map(|(a, b)| [a.min(b), a.max(b)])
        .collect();
    out.sort_unstable();
    out.dedup();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_of_two_triangles_has_five_edges_and_symmetric_neighbours() {
        let triangles = [[0, 1, 2], [0, 2, 3]];
        assert_eq!(edges(&triangles), vec![[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]);
        let adjacency = Adjacency::new(4, &triangles);
        assert_eq!(adjacency.of(0), &[1, 2, 3]);
        assert_eq!(adjacency.of(1), &[0, 2]);
        assert!(adjacency.of(9).is_empty());
    }
}
