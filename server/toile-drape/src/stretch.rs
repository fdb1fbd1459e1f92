//! Edges that pushes have stretched far, shortened again: in deep folds neighbours are pushed to opposite sides.
//!
//! Projected distance constraints (Müller et al., Position Based Dynamics, 2007, section 3.3).

use glam::Vec3;

/// Sweeps over the edges at most.
const SWEEPS: usize = 40;

/// Shortens edges to `limit` times their rest `lengths`, metres; tells which vertices moved.
pub fn shorten(positions: &mut [Vec3], edges: &[[u32; 2]], lengths: &[f32], limit: f32) -> Vec<usize> {
    let mut moved = Vec::new();
    for _ in 0..SWEEPS {
        let before = moved.len();
        for ([a, b], rest) in edges.iter().zip(lengths) {
            let (a, b) = (*a as usize, *b as usize);
            let (Some(&p), Some(&q)) = (positions.get(a), positions.get(b)) else { continue };
            let (between, most) = (q - p, limit * rest);
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
    moved.sort_unstable();
    moved.dedup();
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_comes_back_and_the_rest_stays() {
        let mut line: Vec<Vec3> = (0..30).map(|i| Vec3::X * 0.01 * i as f32).collect();
        let edges: Vec<[u32; 2]> = (0..29).map(|i| [i, i + 1]).collect();
        let still = line.clone();
        assert!(shorten(&mut line, &edges, &[0.01; 29], 1.8).is_empty());
        line[15].y += 0.1;
        for _ in 0..4 {
            shorten(&mut line, &edges, &[0.01; 29], 1.8);
        }
        let longest = line.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, f32::max);
        assert!(longest < 0.0185, "{longest}");
        assert_eq!(line[0], still[0]);
        assert_eq!(line[29], still[29]);
    }
}
