//! From a method's placement to world positions.

use glam::{Affine3A, Vec3};

use crate::methods::Placement;
use crate::static_pass::INFLUENCES;

/// World positions of frame `frame`: rest positions plus offsets, skinned.
#[must_use]
pub fn place(placement: &Placement<'_>, frame: usize, rest: &[Vec3], transforms: &[Affine3A]) -> Vec<Vec3> {
    match placement {
        Placement::Rest { offsets, joints, weights } => {
            let of_frame = offsets.get(frame * rest.len() * 3..).unwrap_or(&[]);
            let mut offset = of_frame.as_chunks::<3>().0.iter().map(|o| Vec3::from_array(*o));
            rest.iter()
                .zip(joints.iter().zip(*weights))
                .map(|(p, (j, w))| {
                    blend(transforms, j, w).transform_point3(*p + offset.next().unwrap_or_default())
                })
                .collect()
        }
        Placement::World(frames) | Placement::Finished(frames) | Placement::Pixels { frames, .. } => {
            frames.get(frame).cloned().unwrap_or_default()
        }
    }
}

fn blend(transforms: &[Affine3A], joints: &[u8; INFLUENCES], weights: &[f32; INFLUENCES]) -> Affine3A {
    let mut out = Affine3A::ZERO;
    for (&joint, &weight) in joints.iter().zip(weights) {
        if let Some(t) = transforms.get(joint as usize) {
            out.matrix3 += t.matrix3 * weight;
            out.translation += t.translation * weight;
        }
    }
    out
}
