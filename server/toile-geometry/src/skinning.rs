//! Linear blend skinning.

use glam::{Affine3A, Mat3A, Vec3, Vec3A, Vec4};

/// Skin weights, only what is not zero, one row a vertex; every row sums to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinWeights {
    starts: Vec<u32>,
    joints: Vec<u16>,
    weights: Vec<f32>,
    joint_count: usize,
}

impl SkinWeights {
    /// Packs (vertices, influences) joints and weights; rows are scaled to sum to 1.
    ///
    /// `None` when sizes do not fit, a joint is out of range, a weight negative or a row all zero.
    #[must_use]
    pub fn from_dense(
        joints: &[u16],
        weights: &[f32],
        influences: usize,
        joint_count: usize,
    ) -> Option<Self> {
        if influences == 0 || joints.len() != weights.len() || !weights.len().is_multiple_of(influences) {
            return None;
        }
        let rows = joints.chunks_exact(influences).zip(weights.chunks_exact(influences));
        Self::from_rows(rows.map(|(j, w)| j.iter().copied().zip(w.iter().copied())), joint_count)
    }

    /// Packs one row of (joint, weight) a vertex; a joint may repeat. `None` as in [`Self::from_dense`].
    #[must_use]
    pub fn from_rows<Row>(rows: impl Iterator<Item = Row>, joint_count: usize) -> Option<Self>
    where
        Row: Iterator<Item = (u16, f32)>,
    {
        let mut out = Self { starts: vec![0], joint_count, ..Self::default() };
        for row in rows {
            let start = out.joints.len();
            for (joint, weight) in row.filter(|(_, w)| *w != 0.0) {
                if usize::from(joint) >= joint_count || weight.is_nan() || weight < 0.0 {
                    return None;
                }
                match out.joints[start..].iter().position(|&j| j == joint) {
                    Some(k) => out.weights[start + k] += weight,
                    None => {
                        out.joints.push(joint);
                        out.weights.push(weight);
                    }
                }
            }
            let sum: f32 = out.weights[start..].iter().sum();
            if !(sum > 0.0 && sum.is_finite()) {
                return None;
            }
            out.weights[start..].iter_mut().for_each(|w| *w /= sum);
            out.starts.push(u32::try_from(out.joints.len()).ok()?);
        }
        Some(out)
    }

    /// The weights with each joint replaced by `target[joint]`. `None` when a joint has no target.
    #[must_use]
    pub fn folded(&self, target: &[u32]) -> Option<Self> {
        let target: Option<Vec<u16>> = target.iter().map(|&t| u16::try_from(t).ok()).collect();
        let target = target?;
        let joint_count = target.iter().max().map_or(0, |&t| usize::from(t) + 1);
        if target.len() < self.joint_count {
            return None;
        }
        let row = |v| {
            let (joints, weights) = self.row(v);
            joints.iter().zip(weights).filter_map(|(&j, &w)| target.get(usize::from(j)).map(|&t| (t, w)))
        };
        Self::from_rows((0..self.vertex_count()).map(row), joint_count)
    }

    /// Joints and weights of vertex `v`; empty when there is no such vertex.
    #[must_use]
    pub fn row(&self, v: usize) -> (&[u16], &[f32]) {
        let range = match (self.starts.get(v), self.starts.get(v + 1)) {
            (Some(&a), Some(&b)) => a as usize..b as usize,
            _ => 0..0,
        };
        (self.joints.get(range.clone()).unwrap_or(&[]), self.weights.get(range).unwrap_or(&[]))
    }

    /// Adds `scale` × the weights of vertex `v` to a dense row, (joints,).
    pub fn add_row(&self, v: usize, scale: f32, dense: &mut [f32]) {
        let (joints, weights) = self.row(v);
        for (&joint, &weight) in joints.iter().zip(weights) {
            if let Some(slot) = dense.get_mut(usize::from(joint)) {
                *slot += scale * weight;
            }
        }
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Number of joints that rows may name.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.joint_count
    }

    /// Skins `vertices` with one transform a joint (`to_from`, such as world from rest).
    ///
    /// As many positions come back as there are both vertices and rows; a joint without a transform
    /// counts as not moving its vertices.
    #[must_use]
    pub fn skin(&self, vertices: &[Vec3], transforms: &[Affine3A]) -> Vec<Vec3> {
        let rows = self.starts.windows(2).map(|w| w[0] as usize..w[1] as usize);
        rows.zip(vertices).map(|(row, &v)| self.blend(row, transforms).transform(v)).collect()
    }

    /// Skins some of `vertices`, in the order of `subset`; NaN where there is no such vertex.
    #[must_use]
    pub fn skin_subset(&self, vertices: &[Vec3], transforms: &[Affine3A], subset: &[u32]) -> Vec<Vec3> {
        let place = |&v: &u32| {
            let v = v as usize;
            let (start, end) = (*self.starts.get(v)? as usize, *self.starts.get(v + 1)? as usize);
            Some(self.blend(start..end, transforms).transform(*vertices.get(v)?))
        };
        subset.iter().map(|v| place(v).unwrap_or(Vec3::NAN)).collect()
    }

    /// Smallest y of the skinned vertices, infinite when there are none.
    #[must_use]
    pub fn lowest(&self, vertices: &[Vec3], transforms: &[Affine3A]) -> f32 {
        let up: Vec<Vec4> = transforms
            .iter()
            .map(|m| Vec4::new(m.matrix3.x_axis.y, m.matrix3.y_axis.y, m.matrix3.z_axis.y, m.translation.y))
            .collect();
        let rows = self.starts.windows(2).map(|w| w[0] as usize..w[1] as usize);
        rows.zip(vertices).fold(f32::INFINITY, |lowest, (row, &v)| {
            let influences = self.joints[row.clone()].iter().zip(&self.weights[row]);
            let blended = influences.fold(Vec4::ZERO, |sum, (&joint, &weight)| {
                sum + up.get(usize::from(joint)).copied().unwrap_or(Vec4::Y) * weight
            });
            lowest.min(blended.dot(v.extend(1.0)))
        })
    }

    #[inline]
    fn blend(&self, row: std::ops::Range<usize>, transforms: &[Affine3A]) -> Blend {
        let mut out = Blend(Affine3A { matrix3: Mat3A::ZERO, translation: Vec3A::ZERO });
        for (&joint, &weight) in self.joints[row.clone()].iter().zip(&self.weights[row]) {
            let m = transforms.get(usize::from(joint)).unwrap_or(&Affine3A::IDENTITY);
            out.0.matrix3 += m.matrix3 * weight;
            out.0.translation += m.translation * weight;
        }
        out
    }
}

/// A weighted sum of transforms.
struct Blend(Affine3A);

impl Blend {
    #[inline]
    fn transform(&self, v: Vec3) -> Vec3 {
        self.0.transform_point3a(v.into()).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> SkinWeights {
        SkinWeights::from_dense(&[0, 1, 1, 0, 1, 1], &[0.5, 0.5, 2.0, 0.0, 0.25, 0.75], 2, 2).unwrap()
    }

    #[test]
    fn half_of_two_translations_is_half_way() {
        let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let transforms = [Affine3A::IDENTITY, Affine3A::from_translation(Vec3::Z)];
        let half = Vec3::Z * 0.5;
        let expected = vec![half, Vec3::X + Vec3::Z, Vec3::Y + Vec3::Z];
        assert_eq!(sample().skin(&vertices, &transforms), expected);
        let subset = sample().skin_subset(&vertices, &transforms, &[2, 0]);
        assert_eq!(subset, vec![expected[2], half]);
        assert!(sample().skin_subset(&vertices, &transforms, &[3])[0].is_nan());
    }

    #[test]
    fn the_lowest_vertex_is_that_of_skinning() {
        let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let turn = Affine3A::from_rotation_translation(glam::Quat::from_rotation_z(-1.0), Vec3::Y);
        let transforms = [Affine3A::IDENTITY, turn];
        let expected =
            sample().skin(&vertices, &transforms).iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
        assert!((sample().lowest(&vertices, &transforms) - expected).abs() < 1e-6);
    }

    #[test]
    fn rows_are_packed_normalised_and_checked() {
        assert_eq!(sample().row(1), (&[1_u16][..], &[1.0_f32][..]));
        assert_eq!(sample().row(2), (&[1_u16][..], &[1.0_f32][..]));
        assert_eq!(sample().row(3), (&[][..], &[][..]));
        assert_eq!(sample().folded(&[0, 0]).unwrap().row(0), (&[0_u16][..], &[1.0_f32][..]));
        assert!(sample().folded(&[0]).is_none());
        assert!(SkinWeights::from_dense(&[2], &[1.0], 1, 2).is_none());
        assert!(SkinWeights::from_dense(&[0], &[0.0], 1, 2).is_none());
        assert!(SkinWeights::from_dense(&[0], &[f32::NAN], 1, 2).is_none());
        assert!(SkinWeights::from_dense(&[0], &[-1.0], 1, 2).is_none());
    }
}
