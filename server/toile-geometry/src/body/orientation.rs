//! The nearest rotation to a matrix.

use glam::{DQuat, Mat3A};

/// Rotation R that is nearest to `m` in the Frobenius norm (orthogonal Procrustes with det R = 1).
///
/// R maximises trace(Rᵀ m), and that is the quadratic form of Davenport's 4×4 matrix in R's quaternion:
/// its eigenvector of the largest eigenvalue is the answer (Horn, *Closed-form solution of absolute
/// orientation using unit quaternions*, 1987, §4). Unlike a polar iteration it needs no care with
/// singular or reflecting matrices. A matrix that is not finite gives the identity.
#[must_use]
pub fn nearest_rotation(m: Mat3A) -> Mat3A {
    if !m.is_finite() {
        return Mat3A::IDENTITY;
    }
    let (values, vectors) = eigen_symmetric(davenport(m));
    let largest = (1..4).fold(0, |best, k| if values[k] > values[best] { k } else { best });
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| vectors[row][largest]);
    Mat3A::from_quat(DQuat::from_xyzw(x, y, z, w).normalize().as_quat())
}

/// Davenport's matrix over (x, y, z, w).
fn davenport(m: Mat3A) -> [[f64; 4]; 4] {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = m.to_cols_array_2d().map(|c| c.map(f64::from));
    [
        [xx - yy - zz, xy + yx, xz + zx, zy - yz],
        [xy + yx, yy - xx - zz, yz + zy, xz - zx],
        [xz + zx, yz + zy, zz - xx - yy, yx - xy],
        [zy - yz, xz - zx, yx - xy, xx + yy + zz],
    ]
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix by cyclic Jacobi rotations.
fn eigen_symmetric(mut a: [[f64; 4]; 4]) -> ([f64; 4], [[f64; 4]; 4]) {
    let mut vectors =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let scale: f64 = a.iter().flatten().map(|v| v * v).sum();
    for _sweep in 0..12 {
        let off: f64 =
            (0..4).flat_map(|p| (p + 1..4).map(move |q| (p, q))).map(|(p, q)| a[p][q] * a[p][q]).sum();
        if off <= scale * 1e-18 {
            break;
        }
        for p in 0..3 {
            for q in p + 1..4 {
                rotate(&mut a, &mut vectors, p, q);
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2], a[3][3]], vectors)
}

/// One Jacobi rotation that makes `a[p][q]` zero (Golub & Van Loan, *Matrix Computations*, §8.5).
fn rotate(a: &mut [[f64; 4]; 4], vectors: &mut [[f64; 4]; 4], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    for row in a.iter_mut().chain(vectors.iter_mut()) {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    let (row_p, row_q) = (a[p], a[q]);
    a[p] = std::array::from_fn(|k| c * row_p[k] - s * row_q[k]);
    a[q] = std::array::from_fn(|k| s * row_p[k] + c * row_q[k]);
}

#[cfg(test)]
mod tests {
    use glam::{EulerRot, Mat3, Quat, Vec3};

    use super::*;

    /// Numbers in [-1, 1) from a linear congruential generator (Knuth's MMIX constants).
    fn noise(state: &mut u64) -> f32 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn random_rotation(state: &mut u64) -> Mat3A {
        let [a, b, c] = [0, 1, 2].map(|_| noise(state) * std::f32::consts::PI);
        Mat3A::from_quat(Quat::from_euler(EulerRot::XYZ, a, b, c))
    }

    #[test]
    fn a_stretched_rotation_gives_the_rotation_back() {
        let mut state = 1;
        for _ in 0..1000 {
            let rotation = random_rotation(&mut state);
            let axes = random_rotation(&mut state);
            let stretch =
                Vec3::new(1.05 + noise(&mut state), 1.05 + noise(&mut state), 1.05 + noise(&mut state));
            let spd = axes * Mat3A::from(Mat3::from_diagonal(stretch)) * axes.transpose();
            let found = nearest_rotation(rotation * spd);
            assert!(found.abs_diff_eq(rotation, 2e-5), "{found:?} is not {rotation:?}");
        }
    }

    #[test]
    fn any_matrix_gives_a_proper_rotation_that_no_neighbour_beats() {
        let mut state = 7;
        let fit = |r: Mat3A, m: Mat3A| {
            (r.transpose() * m).to_cols_array_2d().iter().enumerate().map(|(k, c)| c[k]).sum::<f32>()
        };
        for _ in 0..500 {
            let m = Mat3A::from_cols_array(&[0; 9].map(|_| noise(&mut state)));
            let found = nearest_rotation(m);
            assert!((found.determinant() - 1.0).abs() < 1e-5);
            assert!((found * found.transpose()).abs_diff_eq(Mat3A::IDENTITY, 1e-5));
            for _ in 0..20 {
                let axis =
                    Vec3::new(noise(&mut state), noise(&mut state), noise(&mut state)).normalize_or(Vec3::X);
                let near = found * Mat3A::from_axis_angle(axis, 0.05 * noise(&mut state));
                assert!(fit(near, m) <= fit(found, m) + 1e-5);
            }
        }
    }

    #[test]
    fn singular_reflecting_and_non_finite_matrices_give_rotations() {
        for m in [
            Mat3A::ZERO,
            Mat3A::from_diagonal(Vec3::new(1.0, 0.0, 0.0)),
            Mat3A::from_diagonal(Vec3::new(-1.0, 2.0, 3.0)),
            Mat3A::from_diagonal(Vec3::splat(-1.0)),
            Mat3A::from_diagonal(Vec3::splat(f32::NAN)),
        ] {
            assert!((nearest_rotation(m).determinant() - 1.0).abs() < 1e-6, "{m:?}");
        }
    }
}
