//! Drapes that a simulation brought to rest, to hold the methods against: kept, not computed (`model/teacher/shown.py`).

use glam::Vec3;
use toile_geometry::body::BodyShape;
use toile_geometry::pose::Pose;

use super::{Method, Placement, Wearer};
use crate::error::DrapeError;
use crate::network::Networks;

/// Largest difference of two quaternions' components in the same pose.
const SAME: f32 = 1e-4;

/// An outfit at rest on a body in a pose.
#[derive(Clone, Debug)]
pub struct SimulatedDrape {
    /// The body.
    pub shape: BodyShape,
    /// Its pose.
    pub pose: Pose,
    /// Vertices of the outfit, welded order, world, metres.
    pub cloth: Vec<Vec3>,
}

impl SimulatedDrape {
    fn is_of(&self, shape: &BodyShape, pose: &Pose, vertices: usize) -> bool {
        let pairs = || self.pose.rotations.iter().zip(&pose.rotations);
        *shape == self.shape
            && self.pose.rotations.len() == pose.rotations.len()
            && pairs().all(|(a, b)| a.abs_diff_eq(*b, SAME) || a.abs_diff_eq(-*b, SAME))
            && self.cloth.len() == vertices
    }
}

/// What a simulation left at rest.
pub struct Simulation;

impl Method for Simulation {
    fn dynamic_pass<'s>(
        &self,
        wearer: &Wearer<'s>,
        _networks: &mut dyn Networks,
    ) -> Result<Placement<'s>, DrapeError> {
        let find = |pose: &Pose| {
            let mut drapes = wearer.simulated.iter();
            let found = drapes.find(|drape| drape.is_of(wearer.shape, pose, wearer.outfit.positions.len()));
            found.map(|drape| drape.cloth.clone()).ok_or(DrapeError::NotSimulated)
        };
        Ok(Placement::Finished(wearer.poses.iter().map(find).collect::<Result<_, _>>()?))
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    #[test]
    fn a_drape_is_of_its_body_its_pose_and_its_outfit_alone() {
        let pose = |angle: f32| Pose {
            rotations: vec![Quat::IDENTITY, Quat::from_rotation_x(angle)],
            root_translation: Vec3::ZERO,
        };
        let shape = BodyShape::default();
        let drape = SimulatedDrape { shape: shape.clone(), pose: pose(0.5), cloth: vec![Vec3::ZERO; 3] };
        assert!(drape.is_of(&shape, &pose(0.5), 3));
        let mut turned = pose(0.5);
        turned.rotations[1] = -turned.rotations[1];
        assert!(drape.is_of(&shape, &turned, 3), "the same rotation by its other quaternion");
        assert!(!drape.is_of(&shape, &pose(0.51), 3));
        assert!(!drape.is_of(&shape, &pose(0.5), 4));
        let mut wide = shape;
        wide.phenotypes[2] += 0.1;
        assert!(!drape.is_of(&wide, &pose(0.5), 3));
    }
}
