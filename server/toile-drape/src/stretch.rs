//! Edges that pushes have stretched far, shortened again: in deep folds neighbours are pushed to opposite sides.
//!
//! Projected distance constraints (Müller et al., Position Based Dynamics, 2007, section 3.3).

use glam::Vec3;

/// Sweeps over the edges near the limit, before others are looked at.
const SWEEPS: usize = 10;
/// Share of the limit from which an edge is near it: shortening others may lengthen it.
const NEAR: f32 = 0.7;

/// How far edges are shortened.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Length over rest length that they have at most.
    pub stretch: f32,
    /// How often all edges are looked at.
    pub rounds: usize,
}

/// Shortens edges of the given rest `lengths`, metres, to the limit; tells which vertices moved.
pub fn shorten(positions: &mut [Vec3], edges: &[[u32; 2]], lengths: &[f32], limit: Limit) -> Vec<usize> {
    let mut moved = Vec::new();
    for _ in 0..limit.rounds {
        let before = moved.len();
        let near: Vec<_> = long_edges(positions, edges, lengths, NEAR * limit.stretch).collect();
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
    moved
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
    fn a_spike_comes_back_and_the_rest_stays() {
        let mut line: Vec<Vec3> = (0..30).map(|i| Vec3::X * 0.01 * i as f32).collect();
        let edges: Vec<[u32; 2]> = (0..29).map(|i| [i, i + 1]).collect();
        let still = line.clone();
        let limit = Limit { stretch: 1.8, rounds: 1 };
        assert!(shorten(&mut line, &edges, &[0.01; 29], limit).is_empty());
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
