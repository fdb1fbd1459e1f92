//! The `_STRAIN` attribute.

use glam::Vec3;

/// Mean over a vertex's edges of (length ÷ reference length − 1), one value per vertex.
///
/// `reference` and `positions` are in metres and parallel; an edge of two triangles counts twice. Edges
/// shorter than a micrometre in the reference say nothing and are left out.
#[must_use]
pub fn vertex_strain(triangles: &[[u32; 3]], reference: &[Vec3], positions: &[Vec3]) -> Vec<f32> {
    const SHORTEST: f32 = 1e-6;
    let mut sums = vec![(0.0_f32, 0_u32); reference.len().min(positions.len())];
    let length =
        |points: &[Vec3], a: u32, b: u32| Some(points.get(a as usize)?.distance(*points.get(b as usize)?));
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (Some(rest), Some(now)) = (length(reference, from, to), length(positions, from, to)) else {
                continue;
            };
            if rest > SHORTEST {
                for end in [from, to] {
                    if let Some((sum, count)) = sums.get_mut(end as usize) {
                        *sum += now / rest - 1.0;
                        *count += 1;
                    }
                }
            }
        }
    }
    sums.into_iter().map(|(sum, count)| if count == 0 { 0.0 } else { sum / count as f32 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_stretched_by_a_fifth_has_that_strain_everywhere() {
        let rest = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let strain = vertex_strain(&[[0, 1, 2]], &rest, &rest.map(|p| p * 1.2));
        assert!(strain.iter().all(|s| (s - 0.2).abs() < 1e-6), "{strain:?}");
    }
}
