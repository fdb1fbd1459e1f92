//! Cutting UV islands where they lie over themselves, as both legs of trousers do when a file unrolls them alike.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::{Vec2, Vec3};

use super::patch::{Patch, pick};
use super::texels::each_texel;

/// Side of the picture on which triangles are laid.
const SIDE: usize = 512;
/// Share of a triangle's texels that may belong to its chart already.
const MOST_TAKEN: f32 = 0.3;
/// How far within a triangle a texel must lie, of its heights, to count.
const INSIDE: f32 = 0.02;

/// The garment with the vertices along cuts drawn once more, where `uvs` (unit square) lie over themselves within
/// an island. A chart grows along the cloth from an end of it, so that it has one sleeve or leg before the other.
pub(super) fn cut(patch: &Patch, uvs: &[Vec2], most: usize) -> Patch {
    let mut growth = Growth::new(patch, uvs);
    let mut chart = 0;
    while let Some(seed) = growth.seed() {
        growth.grow(seed, chart);
        chart += 1;
        // What is left then is refused for its overlaps.
        if chart as usize > most {
            break;
        }
    }
    separated(patch, &growth.chart_of)
}

/// Charts in the making.
struct Growth<'a> {
    patch: &'a Patch,
    uvs: &'a [Vec2],
    /// Triangles across the edges of each triangle that have the same drawn vertices.
    beside: Vec<[Option<u32>; 3]>,
    /// Chart of each triangle.
    chart_of: Vec<Option<u32>>,
    /// The latest chart that has a texel, counted from 1.
    taken: Vec<u32>,
}

impl<'a> Growth<'a> {
    fn new(patch: &'a Patch, uvs: &'a [Vec2]) -> Self {
        let chart_of = vec![None; patch.triangles.len()];
        Self { patch, uvs, beside: beside(&patch.triangles), chart_of, taken: vec![0; SIDE * SIDE] }
    }

    /// Of the triangles without a chart the one farthest from their middle.
    fn seed(&self) -> Option<u32> {
        let left = || (0..).zip(&self.chart_of).filter(|(_, chart)| chart.is_none()).map(|(index, _)| index);
        let count = left().count().max(1) as f32;
        let middle = left().map(|index| self.centre(index)).sum::<Vec3>() / count;
        let distance = |index: &u32| self.centre(*index).distance_squared(middle);
        left().max_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    fn centre(&self, index: u32) -> Vec3 {
        let [a, b, c] = Patch::corners(&self.patch.positions, pick(&self.patch.triangles, index));
        (a + b + c) / 3.0
    }

    /// Gives a chart the triangles around a seed, the nearest along the cloth first, that find their texels free.
    fn grow(&mut self, seed: u32, chart: u32) {
        let mut reached = BinaryHeap::from([(Reverse(0_u32), seed)]);
        let mut seen = std::collections::HashSet::from([seed]);
        while let Some((Reverse(bits), index)) = reached.pop() {
            if index != seed && !self.is_free(index, chart) {
                continue;
            }
            self.take(index, chart);
            for next in pick(&self.beside, index).into_iter().flatten() {
                if pick(&self.chart_of, next).is_none() && seen.insert(next) {
                    let distance = f32::from_bits(bits) + self.centre(index).distance(self.centre(next));
                    // Floats that are not negative are in the order of their bits.
                    reached.push((Reverse(distance.to_bits()), next));
                }
            }
        }
    }

    fn is_free(&self, index: u32, chart: u32) -> bool {
        let (mut all, mut taken) = (0.0_f32, 0.0_f32);
        each_texel(SIDE, self.places(index), |texel, weights| {
            if weights.min_element() > INSIDE {
                all += 1.0;
                taken += if self.taken.get(texel) == Some(&(chart + 1)) { 1.0 } else { 0.0 };
            }
        });
        taken <= MOST_TAKEN * all
    }

    fn take(&mut self, index: u32, chart: u32) {
        if let Some(slot) = self.chart_of.get_mut(index as usize) {
            *slot = Some(chart);
        }
        let places = self.places(index);
        each_texel(SIDE, places, |texel, weights| {
            if let Some(slot) = self.taken.get_mut(texel).filter(|_| weights.min_element() > INSIDE) {
                *slot = chart + 1;
            }
        });
    }

    fn places(&self, index: u32) -> [Vec2; 3] {
        Patch::corners(self.uvs, pick(&self.patch.triangles, index))
    }
}

/// For each triangle another one across each of its edges, if there is one.
fn beside(triangles: &[[u32; 3]]) -> Vec<[Option<u32>; 3]> {
    let edges = |[a, b, c]: [u32; 3]| [(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b)));
    let mut open = HashMap::new();
    let mut out = vec![[None; 3]; triangles.len()];
    for (index, &triangle) in triangles.iter().enumerate() {
        for (side, edge) in edges(triangle).into_iter().enumerate() {
            match open.remove(&edge) {
                None => drop(open.insert(edge, (index, side))),
                Some((other, other_side)) => {
                    for (from, side, to) in [(index, side, other), (other, other_side, index)] {
                        if let Some(slot) = out.get_mut(from).and_then(|sides| sides.get_mut(side)) {
                            *slot = Some(to as u32);
                        }
                    }
                }
            }
        }
    }
    out
}

/// The garment with a vertex of its own for every chart that has it; the first keeps the vertex as it is.
fn separated(patch: &Patch, chart_of: &[Option<u32>]) -> Patch {
    let mut out = patch.clone();
    let mut first: HashMap<u32, Option<u32>> = HashMap::new();
    let mut twins: HashMap<(u32, Option<u32>), u32> = HashMap::new();
    for (triangle, &chart) in out.triangles.iter_mut().zip(chart_of) {
        for corner in triangle {
            if *first.entry(*corner).or_insert(chart) == chart {
                continue;
            }
            *corner = *twins.entry((*corner, chart)).or_insert_with(|| {
                out.welded.push(pick(&patch.welded, *corner));
                out.positions.push(pick(&patch.positions, *corner));
                out.uvs.push(pick(&patch.uvs, *corner));
                out.welded.len() as u32 - 1
            });
        }
    }
    out
}
