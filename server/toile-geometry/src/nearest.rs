//! Nearest points: exact among a set (k-d tree), and fast on a moving surface (candidates and descent).

use glam::Vec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::num::NonZeroUsize;

use crate::mesh::Adjacency;

/// An exact nearest-point search over a chosen subset of points.
pub struct PointTree {
    tree: ImmutableKdTree<f32, 3>,
    original: Vec<u32>,
}

/// A point found by a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index into the points that the tree was built from.
    pub index: u32,
    /// Distance, metres.
    pub distance: f32,
}

impl PointTree {
    /// Builds the tree of the points for which `allowed` holds; `None` when there is none.
    #[must_use]
    pub fn new(points: &[Vec3], allowed: impl Fn(usize) -> bool) -> Option<Self> {
        let original: Vec<u32> = (0..points.len()).filter(|&i| allowed(i)).map(|i| i as u32).collect();
        let chosen: Vec<[f32; 3]> =
            original.iter().filter_map(|&i| points.get(i as usize)).map(|p| p.to_array()).collect();
        (!chosen.is_empty()).then(|| Self { tree: ImmutableKdTree::new_from_slice(&chosen), original })
    }

    /// The nearest point.
    #[must_use]
    pub fn nearest(&self, query: Vec3) -> Hit {
        let found = self.tree.nearest_one::<SquaredEuclidean>(&query.to_array());
        self.hit(found.item, found.distance)
    }

    /// The `count` nearest points in ascending distance, fewer when there are fewer points.
    #[must_use]
    pub fn nearest_n(&self, query: Vec3, count: usize) -> Vec<Hit> {
        let Some(count) = NonZeroUsize::new(count) else { return Vec::new() };
        let found = self.tree.nearest_n::<SquaredEuclidean>(&query.to_array(), count);
        found.into_iter().map(|n| self.hit(n.item, n.distance)).collect()
    }

    fn hit(&self, item: u64, squared: f32) -> Hit {
        let index = self.original.get(item as usize).copied().unwrap_or(0);
        Hit { index, distance: squared.sqrt() }
    }
}

/// How many descent steps over the surface a search takes at most.
const DESCENTS: usize = 4;

/// The (locally) nearest surface vertex: the best of `candidates`, then descent over the surface's edges.
///
/// Candidates come from the rest pose, so cloth keeps to its own side of a limb.
#[must_use]
#[inline]
pub fn descend(query: Vec3, surface: &[Vec3], candidates: &[u32], ring: &Adjacency) -> u32 {
    let squared = |i: u32| surface.get(i as usize).map_or(f32::INFINITY, |p| p.distance_squared(query));
    let mut best = candidates.first().copied().unwrap_or(0);
    let mut least = squared(best);
    for &candidate in candidates.iter().skip(1) {
        let d = squared(candidate);
        if d < least {
            (best, least) = (candidate, d);
        }
    }
    for _ in 0..DESCENTS {
        let from = best;
        for &neighbour in ring.of(from as usize) {
            let d = squared(neighbour);
            if d < least {
                (best, least) = (neighbour, d);
            }
        }
        if best == from {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Vec<Vec3> {
        (0..100).map(|i| Vec3::new((i % 10) as f32, (i / 10) as f32, 0.0)).collect()
    }

    #[test]
    fn the_tree_finds_only_allowed_points_and_reports_their_own_indices() {
        let tree = PointTree::new(&grid(), |i| i % 2 == 1).unwrap();
        let hit = tree.nearest(Vec3::new(4.2, 3.0, 0.0));
        assert_eq!(hit.index, 35);
        assert!((hit.distance - 0.8).abs() < 1e-5);
        assert_eq!(tree.nearest_n(Vec3::ZERO, 3).len(), 3);
        assert!(PointTree::new(&grid(), |_| false).is_none());
    }

    #[test]
    fn descent_walks_over_edges_to_the_nearest_vertex() {
        let triangles: Vec<[u32; 3]> = (0..90).filter(|i| i % 10 < 9).map(|i| [i, i + 1, i + 10]).collect();
        let ring = Adjacency::new(100, &triangles);
        assert_eq!(descend(Vec3::new(3.1, 0.2, 0.0), &grid(), &[0], &ring), 3);
    }
}
