//! Edges drawn towards their rest lengths: those of cloth as it comes from the networks, and those that pushes have
//! stretched far, where in deep folds neighbours are pushed to opposite sides.
//!
//! Projected distance constraints (Müller et al., Position Based Dynamics, 2007, section 3.3; Jakobsen, Advanced Character
//! Physics, 2001, for the form without a root).

use glam::{Mat4, Vec3, Vec3A, Vec4};

/// Sweeps over the edges near the limit, before others are looked at.
const SWEEPS: usize = 10;
/// Share of the limit from which an edge is near it: shortening others may lengthen it.
const NEAR: f32 = 0.7;
/// How much longer a shortened edge may become at once: what lacks much of its length would crumple.
const GROWTH: f32 = 1.05;
/// Of each end's share in it.
const MOST_GROWTH: f32 = 0.5 - 0.5 * GROWTH;
/// Places of the list of edges that are gone through together: edges next to each other share a vertex, and what moves
/// one would wait for what moved the other.
const LANES: usize = 8;

/// How far edges are shortened.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Length over rest length that they have at most.
    pub stretch: f32,
    /// How often all edges are looked at.
    pub rounds: usize,
}

/// Edges in the order in which [`draw_to_rest`] goes through them fastest.
#[must_use]
pub fn interleaved(edges: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    let stride = edges.len().div_ceil(LANES).max(1);
    (0..stride).flat_map(|first| edges.iter().skip(first).step_by(stride)).copied().collect()
}

/// Draws every edge to its rest length, metres, one after the other, some times over. What the networks have shortened
/// or stretched over a few edges gets its length back and buckles as cloth does; what lies farther apart stays. Edges
/// with a `crammed` end are only shortened: in a fold of the body there is no room for more cloth.
pub fn draw_to_rest(
    positions: &mut [Vec3],
    edges: &[[u32; 2]],
    lengths: &[f32],
    crammed: &[bool],
    sweeps: usize,
) {
    let is_crammed = |v: &u32| crammed.get(*v as usize).is_some_and(|c| *c);
    let most = |edge: &[u32; 2]| if edge.iter().any(is_crammed) { 0.0 } else { MOST_GROWTH };
    let each = |(edge, rest): (&[u32; 2], &f32)| (*edge, rest * rest, most(edge));
    let edges: Vec<Drawn> = edges.iter().zip(lengths).map(each).collect();
    let mut points: Vec<Vec3A> = positions.iter().copied().map(Vec3A::from).collect();
    let (fours, left) = edges.as_chunks::<4>();
    for _ in 0..sweeps {
        fours.iter().for_each(|four| draw_four(&mut points, four));
        left.iter().for_each(|one| draw_one(&mut points, one));
    }
    positions.iter_mut().zip(points).for_each(|(p, q)| *p = q.into());
}

/// An edge, the square of its length at rest and the least share of the way between its ends that each of these moves.
type Drawn = ([u32; 2], f32, f32);

/// Jakobsen's first-order form of 0.5 - 0.5 rest / length, without the root.
fn draw_one(points: &mut [Vec3A], (ends, rest, most): &Drawn) {
    let [a, b] = ends.map(|v| v as usize);
    let (Some(&from), Some(&to)) = (points.get(a), points.get(b)) else { return };
    let between = to - from;
    let share = between * (0.5 - rest / (rest + between.length_squared())).max(*most);
    points[a] = from + share;
    points[b] = to - share;
}

/// The same for four edges at once, which share no vertex but by chance: then the last one counts.
fn draw_four(points: &mut [Vec3A], four: &[Drawn; 4]) {
    let at = |v: u32| points.get(v as usize).copied().unwrap_or_default();
    let ends = four.map(|(ends, ..)| ends.map(at));
    let between = ends.map(|[from, to]| to - from);
    let [p, q, r, s] = between.map(|way| way.extend(0.0));
    let by_axis = Mat4::from_cols(p, q, r, s).transpose();
    let [x, y, z] = [by_axis.x_axis, by_axis.y_axis, by_axis.z_axis];
    let square = x * x + y * y + z * z;
    let rest = Vec4::from_array(four.map(|edge| edge.1));
    let shares = (0.5 - rest / (rest + square)).max(Vec4::from_array(four.map(|edge| edge.2)));
    for (((drawn, [from, to]), way), share) in four.iter().zip(ends).zip(between).zip(shares.to_array()) {
        let [a, b] = drawn.0.map(|v| v as usize);
        if a < points.len() && b < points.len() {
            points[a] = from + way * share;
            points[b] = to - way * share;
        }
    }
}

/// What was found and done on the way to a limit.
#[derive(Debug, Default)]
pub struct Shortened {
    /// Vertices that moved.
    pub moved: Vec<usize>,
    /// Edges that were near the limit or beyond it.
    pub near: Vec<[usize; 2]>,
}

/// Shortens edges of the given rest `lengths`, metres, to the limit.
pub fn shorten(positions: &mut [Vec3], edges: &[[u32; 2]], lengths: &[f32], limit: Limit) -> Shortened {
    let (mut moved, mut all_near) = (Vec::new(), Vec::new());
    for round in 0..limit.rounds {
        let before = moved.len();
        let near: Vec<_> = long_edges(positions, edges, lengths, NEAR * limit.stretch).collect();
        if round == 0 {
            all_near.extend(near.iter().map(|(ends, _)| *ends));
        }
        for _ in 0..SWEEPS {
            let before = moved.len();
            for &([a, b], rest) in &near {
                let between = positions[b] - positions[a];
                let most = limit.stretch * rest;
                if between.length_squared() > most * most {
                    let share = between * (0.5 - 0.5 * most / between.length());
                    positions[a] += share;
                    positions[b] -= share;
                    moved.extend([a, b]);
                }
            }
            if moved.len() == before {
                break;
            }
        }
        if moved.len() == before {
            break;
        }
    }
    moved.sort_unstable();
    moved.dedup();
    Shortened { moved, near: all_near }
}

/// Edges beyond `stretch` times their rest lengths, with these.
fn long_edges<'a>(
    positions: &'a [Vec3],
    edges: &'a [[u32; 2]],
    lengths: &'a [f32],
    stretch: f32,
) -> impl Iterator<Item = ([usize; 2], f32)> + 'a {
    edges.iter().zip(lengths).filter_map(move |(edge, rest)| {
        let [a, b] = edge.map(|v| v as usize);
        let most = stretch * rest;
        let long = positions.get(a)?.distance_squared(*positions.get(b)?) > most * most;
        long.then_some(([a, b], *rest))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_come_nearer_to_their_lengths_and_crammed_ones_do_not_grow() {
        let line = |step: f32| (0..30).map(|i| Vec3::X * step * i as f32).collect::<Vec<_>>();
        let edges: Vec<[u32; 2]> = (0..29).map(|i| [i, i + 1]).collect();
        let change = |points: &[Vec3]| {
            points.windows(2).map(|w| (w[0].distance(w[1]) / 0.01 - 1.0).abs()).sum::<f32>() / 29.0
        };
        let mut uneven = line(0.01);
        uneven.iter_mut().step_by(3).for_each(|p| p.x += 0.002);
        let before = change(&uneven);
        draw_to_rest(&mut uneven, &edges, &[0.01; 29], &[], 5);
        assert!(change(&uneven) < 0.3 * before, "{} {before}", change(&uneven));
        let mut short = line(0.002);
        draw_to_rest(&mut short, &edges, &[0.01; 29], &[], 1);
        assert!(short.windows(2).all(|w| w[0].distance(w[1]) < 0.0023));
        draw_to_rest(&mut short, &[[0, 99]], &[0.01], &[], 1);
        let mut crammed = line(0.002);
        draw_to_rest(&mut crammed, &edges, &[0.01; 29], &[true; 30], 5);
        assert_eq!(crammed, line(0.002));
        draw_to_rest(&mut crammed, &edges, &[0.001; 29], &[true; 30], 5);
        assert!(change(&crammed) > change(&line(0.002)));
    }

    #[test]
    fn a_spike_comes_back_and_the_rest_stays() {
        let mut line: Vec<Vec3> = (0..30).map(|i| Vec3::X * 0.01 * i as f32).collect();
        let edges: Vec<[u32; 2]> = (0..29).map(|i| [i, i + 1]).collect();
        let still = line.clone();
        let limit = Limit { stretch: 1.8, rounds: 1 };
        assert!(shorten(&mut line, &edges, &[0.01; 29], limit).moved.is_empty());
        line[15].y += 0.1;
        for _ in 0..4 {
            shorten(&mut line, &edges, &[0.01; 29], limit);
        }
        let longest = line.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, f32::max);
        assert!(longest < 0.0185, "{longest}");
        assert_eq!(line[0], still[0]);
        assert_eq!(line[29], still[29]);
    }
}
