//! Shapes, poses and measurements against goldens computed by Anny itself (`model/body/goldens.py`).

use std::collections::BTreeMap;

use glam::{Affine3A, Quat, Vec3};
use safetensors::SafeTensors;
use serde::Deserialize;
use toile_geometry::body::{BodyShape, ShapedBody};
use toile_geometry::measurements::measure;
use toile_geometry::pose::Pose;

use super::{artifact, body};

/// A tenth of a millimetre.
const PARITY: f32 = 1e-4;

#[derive(Deserialize)]
struct Golden {
    cases: Vec<Case>,
    stride: usize,
    split_names: Vec<String>,
    #[serde(skip)]
    bytes: Vec<u8>,
}

#[derive(Deserialize)]
struct Case {
    phenotypes: BTreeMap<String, f32>,
    local_changes: BTreeMap<String, f32>,
    rotations: BTreeMap<String, Quat>,
}

impl Golden {
    fn read() -> Self {
        let bytes = artifact("golden/body.safetensors");
        let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
        let golden: Self = serde_json::from_str(&header.metadata().as_ref().unwrap()["toile"]).unwrap();
        Self { bytes, ..golden }
    }

    /// The values of one case (or row) of a tensor.
    fn row(&self, name: &str, row: usize) -> Vec<f32> {
        let tensors = SafeTensors::deserialize(&self.bytes).unwrap();
        let tensor = tensors.tensor(name).unwrap();
        let width = tensor.data().len() / 4 / tensor.shape()[0];
        let values = tensor.data().as_chunks::<4>().0.iter().map(|&b| f32::from_le_bytes(b));
        values.skip(row * width).take(width).collect()
    }

    fn points(&self, name: &str, row: usize) -> Vec<Vec3> {
        self.row(name, row).chunks_exact(3).map(Vec3::from_slice).collect()
    }
}

impl Case {
    fn shaped(&self) -> ShapedBody {
        let values =
            self.phenotypes.iter().chain(&self.local_changes).map(|(n, &v)| (n.clone(), v)).collect();
        body().shape(&BodyShape::from_values(body(), &values).unwrap())
    }

    fn world(&self, shaped: &ShapedBody) -> Vec<Affine3A> {
        let pose = body().grounded(shaped, Pose::from_humanoid(body(), &self.rotations).unwrap());
        body().world_joints(shaped, &pose)
    }
}

/// Largest difference of a coordinate.
fn difference(found: impl ExactSizeIterator<Item = Vec3>, expected: &[Vec3]) -> f32 {
    assert_eq!(found.len(), expected.len());
    found.zip(expected).map(|(a, b)| (a - b).abs().max_element()).fold(0.0, f32::max)
}

/// Row-major 3×4 matrices as rows of x, y, z and the translations.
fn rows(transforms: &[Affine3A]) -> Vec<f32> {
    let row = |m: &Affine3A, k: usize| {
        [m.matrix3.row(k).x, m.matrix3.row(k).y, m.matrix3.row(k).z, m.translation[k]]
    };
    transforms.iter().flat_map(|m| [0, 1, 2].map(|k| row(m, k))).flatten().collect()
}

#[test]
fn a_pose_vertices_and_joints_agree_with_anny() {
    let golden = Golden::read();
    for (k, case) in golden.cases.iter().enumerate() {
        let shaped = case.shaped();
        let sampled: Vec<Vec3> = shaped.apose_vertices.iter().step_by(golden.stride).copied().collect();
        let vertices = difference(sampled.into_iter(), &golden.points("apose_vertices", k));
        let joints = difference(shaped.joints.iter().copied(), &golden.points("joints", k));
        assert!(vertices < PARITY && joints < PARITY, "case {k}: vertices {vertices} m, joints {joints} m");
    }
}

#[test]
fn posed_vertices_and_garment_transforms_agree_with_anny() {
    let golden = Golden::read();
    for (k, case) in golden.cases.iter().enumerate() {
        let shaped = case.shaped();
        let world = case.world(&shaped);
        let posed: Vec<Vec3> =
            body().posed_vertices(&shaped, &world).into_iter().step_by(golden.stride).collect();
        let vertices = difference(posed.into_iter(), &golden.points("posed_vertices", k));
        assert!(vertices < PARITY, "case {k}: {vertices} m");
        let found = rows(&body().garment_transforms(&shaped, &world));
        let expected = golden.row("garment_transforms", k);
        let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(found.len() == expected.len() && worst < PARITY, "case {k}: garment transforms {worst}");
    }
}

#[test]
fn measurements_agree_with_the_reference_implementation() {
    let golden = Golden::read();
    for (k, case) in golden.cases.iter().enumerate() {
        let found = measure(body(), &case.shaped());
        for ((name, found), expected) in found.iter().zip(golden.row("measurements", k)) {
            assert!((found - expected).abs() < 0.01, "case {k}: {name} is {found}, not {expected}");
        }
    }
}

#[test]
fn a_humanoid_rotation_is_shared_as_the_reference_shares_it() {
    let golden = Golden::read();
    let named = golden.split_names.iter().enumerate();
    let rotations =
        named.map(|(k, name)| (name.clone(), Quat::from_slice(&golden.row("split_quaternions", k))));
    let pose = Pose::from_humanoid(body(), &rotations.collect()).unwrap();
    for (j, rotation) in pose.rotations.iter().enumerate() {
        let expected = golden.row("split_rotations", j);
        let found = glam::Mat3::from_quat(*rotation).transpose().to_cols_array();
        let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-5, "{}: {worst}", body().joint_names()[j]);
    }
}
