//! Preset poses on bodies wider than the one they were drawn on.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use glam::{Quat, Vec3};
use toile_drape::studio::Studio;
use toile_geometry::body::{Body, BodyShape};
use toile_geometry::pose::Pose;

static STUDIO: LazyLock<Arc<Studio>> = LazyLock::new(|| {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../model/artifacts/body.safetensors");
    Studio::new(Body::from_safetensors(&std::fs::read(path).unwrap()).unwrap(), Vec::new()).unwrap()
});

const WIDE: [(&str, f32); 3] =
    [("weight", 1.0), ("measure-hips-circ-incr", 1.0), ("measure-waist-circ-incr", 1.0)];

/// Upper arms turned down by `degrees` from the A-pose.
fn lowered(degrees: f32) -> Pose {
    let turn = |sign: f32| Quat::from_rotation_z(sign * degrees.to_radians());
    let rotations = [("leftUpperArm".to_owned(), turn(-1.0)), ("rightUpperArm".to_owned(), turn(1.0))];
    Pose::from_humanoid(&STUDIO.body, &BTreeMap::from(rotations)).unwrap()
}

fn shape(values: &[(&str, f32)]) -> BodyShape {
    let values = values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    BodyShape::from_values(&STUDIO.body, &values).unwrap()
}

/// How far the left wrist moves out when the arms get room, metres.
fn moved_out(shape: &BodyShape, pose: &Pose) -> f32 {
    let shaped = STUDIO.body.shape(shape);
    let wrist = STUDIO.body.skeleton().index("wrist.L").unwrap();
    let at = |pose: &Pose| Vec3::from(STUDIO.body.world_joints(&shaped, pose)[wrist].translation);
    at(&STUDIO.arm_room.given(&STUDIO.body, &shaped, pose.clone())).x - at(pose).x
}

#[test]
fn hanging_arms_of_a_wide_body_get_room() {
    let moved = moved_out(&shape(&WIDE), &lowered(35.0));
    assert!((0.03..0.3).contains(&moved), "{moved} m");
}

#[test]
fn the_reference_body_and_slimmer_ones_keep_the_pose_as_it_is_drawn() {
    for values in [&[][..], &[("weight", 0.1)]] {
        assert_eq!(moved_out(&shape(values), &lowered(35.0)), 0.0);
    }
}

#[test]
fn arms_that_do_not_hang_stay() {
    for degrees in [0.0, -50.0, -110.0] {
        assert!(moved_out(&shape(&WIDE), &lowered(degrees)).abs() < 1e-4, "{degrees}");
    }
}
