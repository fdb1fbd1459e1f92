//! Gather tables of GarNet: the body's points that it sees, thinned, and those nearest to a garment's nodes.
//!
//! Metres. Training makes the same tables (`model/garment/garnet_tables.py`).

use glam::{DVec3, I64Vec3, Vec3};
use toile_geometry::nearest::PointTree;

/// Points of a body that the network sees, about.
const POINTS: usize = 4096;
/// Points that a thinned point averages, and how many become one (`GarNet++` section 3.5).
pub const AVERAGED: usize = 16;
const THINNED: usize = 10;
/// Thinned points whose features a node pools (section 3.5).
pub const POOLED: usize = 15;
/// Halvings of the range in which a cell's size is looked for.
const HALVINGS: usize = 24;

/// What the network sees of a body's surface, whatever its pose.
#[derive(Clone, Debug)]
pub struct SeenPoints {
    /// Vertices of the body.
    pub points: Vec<u32>,
    /// For every thinned point the seen points that it averages, by their number among `points`.
    pub thinned: Vec<[u32; AVERAGED]>,
}

impl SeenPoints {
    /// Evenly spread vertices of a body in the A-pose, metres.
    #[must_use]
    pub fn of(apose: &[Vec3]) -> Self {
        let points = spread_out(apose, POINTS);
        let seen: Vec<Vec3> = points.iter().filter_map(|&i| apose.get(i as usize)).copied().collect();
        Self { thinned: thinned(&seen), points }
    }

    /// For each node the thinned points nearest to it, [`POOLED`] a node. `seen`: positions of `points`, world space.
    #[must_use]
    pub fn pooled(&self, seen: &[Vec3], nodes: &[Vec3]) -> Vec<i64> {
        let at = |i: &u32| seen.get(*i as usize).copied().unwrap_or_default();
        let centre = |row: &[u32; AVERAGED]| row.iter().map(at).sum::<Vec3>() / AVERAGED as f32;
        let centres: Vec<Vec3> = self.thinned.iter().map(centre).collect();
        let Some(tree) = PointTree::new(&centres, |_| true) else { return vec![0; nodes.len() * POOLED] };
        let mut out = Vec::with_capacity(nodes.len() * POOLED);
        for node in nodes {
            let hits = tree.nearest_n(*node, POOLED);
            let first = hits.first().map_or(0, |h| i64::from(h.index));
            out.extend((0..POOLED).map(|k| hits.get(k).map_or(first, |h| i64::from(h.index))));
        }
        out
    }
}

/// About `wanted` of the points, evenly spread: the most central one in each cell of a grid.
#[must_use]
pub fn spread_out(points: &[Vec3], wanted: usize) -> Vec<u32> {
    if points.len() <= wanted {
        return (0..points.len() as u32).collect();
    }
    let low = points.iter().copied().reduce(Vec3::min).unwrap_or_default().as_dvec3();
    let size = cell_size(points, low, wanted);
    let mut keyed: Vec<(I64Vec3, f64, u32)> = points
        .iter()
        .zip(0..)
        .map(|(p, i)| {
            let key = cell(*p, low, size);
            let centre = low + (key.as_dvec3() + 0.5) * size;
            (key, centre.distance_squared(p.as_dvec3()), i)
        })
        .collect();
    keyed.sort_by(|(a, off_a, i), (b, off_b, j)| {
        a.to_array().cmp(&b.to_array()).then(off_a.total_cmp(off_b)).then(i.cmp(j))
    });
    keyed.dedup_by_key(|(key, ..)| *key);
    keyed.into_iter().map(|(.., i)| i).collect()
}

fn cell(point: Vec3, low: DVec3, size: f64) -> I64Vec3 {
    ((point.as_dvec3() - low) / size).floor().as_i64vec3()
}

/// Edge of the grid cells of which about `wanted` hold a point.
fn cell_size(points: &[Vec3], low: DVec3, wanted: usize) -> f64 {
    let high = points.iter().copied().reduce(Vec3::max).unwrap_or_default().as_dvec3();
    let (mut small, mut large) = (1e-4, (high - low).max_element() + 1e-3);
    for _ in 0..HALVINGS {
        let middle = f64::sqrt(small * large);
        let mut cells: Vec<[i64; 3]> = points.iter().map(|p| cell(*p, low, middle).to_array()).collect();
        cells.sort_unstable();
        cells.dedup();
        if cells.len() > wanted { small = middle } else { large = middle }
    }
    f64::sqrt(small * large)
}

fn thinned(points: &[Vec3]) -> Vec<[u32; AVERAGED]> {
    let Some(tree) = PointTree::new(points, |_| true) else { return Vec::new() };
    let seeds = if points.len() <= AVERAGED {
        (0..points.len() as u32).collect()
    } else {
        spread_out(points, points.len() / THINNED)
    };
    let row = |seed: &u32| {
        let at = points.get(*seed as usize).copied().unwrap_or_default();
        let hits = tree.nearest_n(at, if points.len() <= AVERAGED { 1 } else { AVERAGED });
        std::array::from_fn(|k| hits.get(k).or(hits.first()).map_or(0, |h| h.index))
    };
    seeds.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize) -> Vec<Vec3> {
        (0..n * n).map(|i| Vec3::new((i % n) as f32 * 0.01, 0.0, (i / n) as f32 * 0.01)).collect()
    }

    #[test]
    fn points_are_spread_over_the_whole_and_about_as_many_as_wanted() {
        let points = grid(60);
        let chosen = spread_out(&points, 400);
        assert!((350..=450).contains(&chosen.len()), "{}", chosen.len());
        let tree = PointTree::new(&points, |i| chosen.contains(&(i as u32))).unwrap();
        let farthest = points.iter().map(|p| tree.nearest(*p).distance).fold(0.0, f32::max);
        assert!(farthest < 0.05, "{farthest}");
        assert_eq!(spread_out(&points[..7], 400), (0..7).collect::<Vec<_>>());
    }

    #[test]
    fn a_node_pools_from_the_thinned_points_around_it() {
        let points = grid(40);
        let seen = SeenPoints::of(&points);
        assert_eq!(seen.points.len(), points.len());
        assert!((120..=200).contains(&seen.thinned.len()), "{}", seen.thinned.len());
        let pooled = seen.pooled(&points, &[Vec3::ZERO, Vec3::new(0.39, 0.0, 0.39)]);
        assert_eq!(pooled.len(), 2 * POOLED);
        assert!(pooled[..POOLED].iter().all(|p| !pooled[POOLED..].contains(p)));
        let few = SeenPoints::of(&points[..5]);
        assert_eq!(few.pooled(&points[..5], &[Vec3::ZERO]).len(), POOLED);
    }
}
