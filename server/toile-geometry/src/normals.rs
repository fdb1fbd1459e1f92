//! Vertex normals.

use glam::Vec3;

/// Area-weighted unit vertex normals; a vertex of no (or only degenerate) triangles gets +Y.
#[must_use]
pub fn vertex_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for t in triangles {
        let corner = |k: usize| positions.get(t[k] as usize).copied();
        if let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) {
            let area = (b - a).cross(c - a);
            for &i in t {
                sums[i as usize] += area;
            }
        }
    }
    for n in &mut sums {
        *n = n.try_normalize().unwrap_or(Vec3::Y);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_triangle_in_the_ground_plane_points_up() {
        let positions = [Vec3::ZERO, Vec3::Z, Vec3::X];
        assert_eq!(vertex_normals(&positions, &[[0, 1, 2]]), vec![Vec3::Y; 3]);
    }
}
