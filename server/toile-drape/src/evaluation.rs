//! Figures of a drape by exact search, for tables: nothing here is shared with the resolve that it judges.

use glam::Vec3;
use serde::Serialize;
use toile_geometry::crossings::{Crossing, crossings};
use toile_geometry::nearest::PointTree;

use crate::fitted::lengths;
use crate::outfit::Outfit;
use crate::pipeline::Frame;
use crate::repair::garment_of_vertex;

/// Figures of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Vertices inside the body (behind the plane of the nearest body vertex), percent.
    pub vertices_inside: f32,
    /// The same at triangle centroids, percent.
    pub centroids_inside: f32,
    /// Mean depth of the vertices inside, millimetres.
    pub depth_mm: f32,
    /// Mean |length - rest length|, millimetres.
    pub edge_mm: f32,
    /// Mean |length / rest length - 1|, percent.
    pub edge_percent: f32,
    /// 99.9th percentile of length over rest length.
    pub stretch_p999: f32,
    /// Largest length over rest length.
    pub stretch_max: f32,
    /// Edges that pass through their own garment, percent.
    pub self_crossed: f32,
    /// Edges that pass through another garment, percent.
    pub layers_crossed: f32,
}

impl Figures {
    /// Measures cloth against the posed body; `rest_lengths` are those of `edges` on the same body in the A-pose.
    #[must_use]
    pub fn measure(outfit: &Outfit, frame: &Frame, edges: &[[u32; 2]], rest_lengths: &[f32]) -> Self {
        let Some(body) = PointTree::new(&frame.body.vertices, |_| true) else { return Self::default() };
        let signed = |p: Vec3| {
            let hit = body.nearest(p).index as usize;
            (p - frame.body.vertices[hit]).dot(frame.body.normals[hit])
        };
        let depths: Vec<f32> = frame.positions.iter().map(|p| signed(*p)).filter(|d| *d < 0.0).collect();
        let at = |i: u32| frame.positions.get(i as usize).copied().unwrap_or_default();
        let centroid = |t: &[u32; 3]| (at(t[0]) + at(t[1]) + at(t[2])) / 3.0;
        let inside = outfit.triangles.iter().filter(|t| signed(centroid(t)) < 0.0).count();
        let now = lengths(&frame.positions, edges);
        let ratio: Vec<f32> = now.iter().zip(rest_lengths).map(|(n, r)| n / r.max(1e-5)).collect();
        let change: f32 = now.iter().zip(rest_lengths).map(|(n, r)| (n - r).abs()).sum();
        let count = ratio.len().max(1) as f32;
        let (self_crossed, layers_crossed) = crossed(outfit, &frame.positions, edges);
        Self {
            vertices_inside: percent(depths.len(), frame.positions.len()),
            centroids_inside: percent(inside, outfit.triangles.len()),
            depth_mm: -1000.0 * depths.iter().sum::<f32>() / depths.len().max(1) as f32,
            edge_mm: 1000.0 * change / count,
            edge_percent: 100.0 * ratio.iter().map(|r| (r - 1.0).abs()).sum::<f32>() / count,
            stretch_p999: quantile(&ratio, 0.999),
            stretch_max: ratio.iter().copied().fold(0.0, f32::max),
            self_crossed,
            layers_crossed,
        }
    }

    /// Means over frames; the largest stretch is the largest of all.
    #[must_use]
    pub fn mean(all: &[Self]) -> Self {
        let count = all.len().max(1) as f32;
        let of = |f: fn(&Self) -> f32| all.iter().map(f).sum::<f32>() / count;
        Self {
            vertices_inside: of(|x| x.vertices_inside),
            centroids_inside: of(|x| x.centroids_inside),
            depth_mm: of(|x| x.depth_mm),
            edge_mm: of(|x| x.edge_mm),
            edge_percent: of(|x| x.edge_percent),
            stretch_p999: of(|x| x.stretch_p999),
            stretch_max: all.iter().map(|x| x.stretch_max).fold(0.0, f32::max),
            self_crossed: of(|x| x.self_crossed),
            layers_crossed: of(|x| x.layers_crossed),
        }
    }
}

/// Percent of the edges that pass through their own garment, and through another.
#[must_use]
pub fn crossed(outfit: &Outfit, positions: &[Vec3], edges: &[[u32; 2]]) -> (f32, f32) {
    let found = crossings(positions, &outfit.triangles, edges, &garment_of_vertex(outfit));
    let share = |f: fn(&Crossing) -> bool| percent(found.iter().filter(|c| f(c)).count(), edges.len());
    (share(|c| c.own), share(|c| c.other))
}

/// Percent of the triangles that face away in `after` from where they faced in `before`: torn or folded over.
#[must_use]
pub fn turned(outfit: &Outfit, before: &[Vec3], after: &[Vec3]) -> f32 {
    let normal = |positions: &[Vec3], t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| positions.get(i as usize).copied().unwrap_or_default());
        (b - a).cross(c - a)
    };
    let over = |t: &&[u32; 3]| normal(before, t).dot(normal(after, t)) < 0.0;
    percent(outfit.triangles.iter().filter(over).count(), outfit.triangles.len())
}

fn percent(part: usize, whole: usize) -> f32 {
    100.0 * part as f32 / whole.max(1) as f32
}

fn quantile(values: &[f32], share: f32) -> f32 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    let at = (share * sorted.len() as f32) as usize;
    sorted.get(at.min(sorted.len().saturating_sub(1))).copied().unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use crate::outfit::Outfit;
    use crate::posed_body::PosedBody;
    use crate::skin_cells::SkinCells;

    #[test]
    fn a_triangle_turned_over_is_counted_and_a_bent_one_is_not() {
        let outfit = Outfit { triangles: vec![[0, 1, 2], [1, 3, 2]], ..Outfit::default() };
        let flat = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::X + Vec3::Z];
        let bent = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::X + Vec3::Z + Vec3::Y];
        let over = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::Y * 0.1];
        assert_eq!(turned(&outfit, &flat, &bent), 0.0);
        assert_eq!(turned(&outfit, &flat, &over), 50.0);
    }

    #[test]
    fn a_vertex_behind_the_body_plane_counts_as_inside() {
        let outfit = Outfit { triangles: vec![[0, 1, 2]], ..Outfit::default() };
        let posed = PosedBody {
            vertices: vec![Vec3::ZERO, Vec3::X * 0.1, Vec3::Z * 0.1],
            normals: vec![Vec3::Y; 3],
            facing: vec![],
            cells: SkinCells::default(),
            lift: Vec3::ZERO,
        };
        let frame = Frame {
            positions: vec![Vec3::new(0.0, -0.01, 0.0), Vec3::new(0.1, 0.02, 0.0), Vec3::new(0.0, 0.02, 0.1)],
            normals: vec![],
            body: Arc::new(posed),
            penetration: vec![],
            strain: vec![],
        };
        let edges = [[0, 1], [1, 2], [0, 2]];
        let rest = lengths(&frame.positions, &edges).iter().map(|l| l / 1.1).collect::<Vec<_>>();
        let figures = Figures::measure(&outfit, &frame, &edges, &rest);
        assert!((figures.vertices_inside - 100.0 / 3.0).abs() < 1e-3);
        assert!((figures.depth_mm - 10.0).abs() < 1e-3);
        assert!((figures.centroids_inside).abs() < 1e-6);
        assert!((figures.stretch_p999 - 1.1).abs() < 1e-4);
    }
}
