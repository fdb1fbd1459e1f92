//! Poses, the humanoid skeleton and the pose library.

use std::collections::BTreeMap;

use glam::{Quat, Vec3};
use toile_geometry::body::{BodyError, BodyShape};
use toile_geometry::pose::{Pose, PoseError};
use toile_geometry::poses::{PoseLibrary, PoseLibraryError};

use super::{artifact, body};

fn library() -> PoseLibrary {
    PoseLibrary::from_json(&artifact("poses.json"), body()).unwrap()
}

#[test]
fn the_identity_pose_is_the_a_pose_on_the_floor() {
    let shaped = body().shape(&BodyShape::default());
    let pose = body().grounded(&shaped, Pose::identity(body()));
    assert!(pose.root_translation.length() < 1e-6);
    let posed = body().posed_vertices(&shaped, &body().world_joints(&shaped, &pose));
    assert_eq!(posed.len(), body().vertex_count());
    for (found, expected) in posed.iter().zip(&shaped.apose_vertices) {
        assert!(found.abs_diff_eq(*expected, 1e-5), "{found}, not {expected}");
    }
}

#[test]
fn every_preset_stands_on_the_floor_on_another_body() {
    let shape = BodyShape { phenotypes: [0.9, 0.7, 0.2, 0.8, 0.3, 0.6], ..BodyShape::default() };
    let shaped = body().shape(&shape);
    let library = library();
    assert!(library.presets().len() >= 14);
    for preset in library.presets() {
        let pose = body().grounded(&shaped, preset.pose.to_pose(body()).unwrap());
        let posed = body().posed_vertices(&shaped, &body().world_joints(&shaped, &pose));
        let lowest = posed.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
        assert!(lowest.abs() < 1e-5, "{} stands at {lowest} m", preset.id);
    }
}

#[test]
fn a_subset_is_posed_as_the_whole_body_is() {
    let shaped = body().shape(&BodyShape::default());
    let pose = library().preset("squat").unwrap().pose.to_pose(body()).unwrap();
    let world = body().world_joints(&shaped, &pose);
    let all = body().posed_vertices(&shaped, &world);
    let found = body().posed_subset(&shaped, &world, &[13_717, 0, 4_000, 13_718]);
    assert_eq!(found[..3], [all[13_717], all[0], all[4_000]]);
    assert!(found[3].is_nan());
}

#[test]
fn garment_transforms_follow_the_joints_that_others_fold_into() {
    let shaped = body().shape(&BodyShape::default());
    let rotations = BTreeMap::from([("leftUpperLeg".to_owned(), Quat::from_rotation_x(-0.5))]);
    let pose = Pose::from_humanoid(body(), &rotations).unwrap();
    let world = body().world_joints(&shaped, &pose);
    let transforms = body().garment_transforms(&shaped, &world);
    let garment_joints = body().skeleton().garment_joints();
    assert_eq!(transforms.len(), 36);
    assert_eq!(body().garment_skin().joint_count(), 36);
    for (transform, &joint) in transforms.iter().zip(garment_joints) {
        let moved = transform.transform_point3(shaped.joints[joint]);
        let expected = Vec3::from(world[joint].translation);
        assert!(moved.abs_diff_eq(expected, 1e-5), "{}", body().joint_names()[joint]);
    }
    let name = |g: usize| body().joint_names()[garment_joints[g]].as_str();
    let foot = (0..36).find(|&g| name(g) == "foot.L").unwrap();
    assert_eq!(body().skeleton().garment_parents()[foot].map(name), Some("lowerleg02.L"));
}

#[test]
fn humanoid_joints_form_a_tree_from_the_hips() {
    let joints: Vec<_> = body().humanoid_joints().collect();
    assert_eq!(joints[0], ("hips", None));
    for (k, (name, parent)) in joints.iter().enumerate().skip(1) {
        let parent = parent.unwrap_or_else(|| panic!("{name} has no parent"));
        assert!(joints[..k].iter().any(|(other, _)| *other == parent), "{name} before {parent}");
    }
    let parent_of = |name: &str| joints.iter().find(|(n, _)| *n == name).and_then(|(_, p)| *p);
    assert_eq!(parent_of("leftLowerArm"), Some("leftUpperArm"));
    assert_eq!(parent_of("head"), Some("neck"));
    assert_eq!(parent_of("rightUpperLeg"), Some("hips"));
}

#[test]
fn unknown_joints_and_quaternions_that_are_no_rotation_are_refused() {
    let pose = |name: &str, q: [f32; 4]| {
        Pose::from_humanoid(body(), &BTreeMap::from([(name.to_owned(), Quat::from_array(q))]))
    };
    let expected = PoseError::UnknownJoint { name: "tail".to_owned() };
    assert_eq!(pose("tail", [0.0, 0.0, 0.0, 1.0]), Err(expected));
    assert!(
        matches!(pose("head", [0.0, 0.0, 0.0, 2.0]), Err(PoseError::NonUnit { length, .. }) if length == 2.0)
    );
    assert!(matches!(pose("head", [f32::NAN, 0.0, 0.0, 1.0]), Err(PoseError::NonUnit { .. })));
    let rounded = pose("head", [0.0, 0.707, 0.0, 0.707]).unwrap();
    assert!(rounded.rotations.iter().all(|q| q.is_normalized()));
}

#[test]
fn a_library_with_a_wrong_pose_is_refused() {
    let read = |text: &str| PoseLibrary::from_json(text.as_bytes(), body());
    let preset = |id: &str, joint: &str| {
        format!(r#"{{"id": "{id}", "label": "", "group": "", "rotations": {{"{joint}": [0, 0, 0, 1]}}}}"#)
    };
    let poses = |list: &str| format!(r#"{{"poses": [{list}], "motions": []}}"#);
    assert_eq!(read(&poses(&preset("a", "head"))).unwrap().presets().len(), 1);
    assert!(
        matches!(read(&poses(&preset("a", "tail"))), Err(PoseLibraryError::Pose { id, .. }) if id == "a")
    );
    let twice = format!("{}, {}", preset("a", "head"), preset("a", "head"));
    assert!(matches!(read(&poses(&twice)), Err(PoseLibraryError::Invalid { .. })));
    let motion = r#"{"poses": [], "motions": [{"id": "m", "label": "", "frame_rate": 24, "frames": []}]}"#;
    assert!(matches!(read(motion), Err(PoseLibraryError::Invalid { .. })));
    assert!(matches!(read("{}"), Err(PoseLibraryError::Json(_))));
}

#[test]
fn a_preset_serialises_as_the_api_shows_it() {
    let library = library();
    let json = serde_json::to_value(library.preset("contrapposto").unwrap()).unwrap();
    assert_eq!(json["id"], "contrapposto");
    assert_eq!(json["rotations"]["leftUpperArm"].as_array().unwrap().len(), 4);
    assert_eq!(library.motion("walk").unwrap().frames.len(), 28);
}

#[test]
fn shape_values_round_trip_and_are_checked() {
    let values = BTreeMap::from([("gender".to_owned(), 1.0), ("measure-waist-circ-incr".to_owned(), -0.5)]);
    let shape = BodyShape::from_values(body(), &values).unwrap();
    assert_eq!(BodyShape::from_values(body(), &shape.values(body())).unwrap(), shape);
    assert_eq!(BodyShape::from_values(body(), &BTreeMap::new()).unwrap(), BodyShape::default());
    let refused = |name: &str, value: f32| {
        BodyShape::from_values(body(), &BTreeMap::from([(name.to_owned(), value)])).unwrap_err()
    };
    assert!(matches!(refused("cup", 0.5), BodyError::UnknownPhenotype { name } if name == "cup"));
    assert!(matches!(refused("age", -0.1), BodyError::PhenotypeOutOfRange { min: 0.0, .. }));
    assert!(matches!(refused("age", f32::NAN), BodyError::PhenotypeOutOfRange { .. }));
    assert!(matches!(
        refused("measure-waist-circ-incr", 1.1),
        BodyError::PhenotypeOutOfRange { min: -1.0, .. }
    ));
}
