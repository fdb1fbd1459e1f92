//! Python's numbers against Rust's, from the graph to posed cloth, through the shipped networks.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use safetensors::SafeTensors;
use toile_drape::binding::node_prior;
use toile_drape::features::{FEATURES, node_features};
use toile_drape::graph::OutfitGraph;
use toile_drape::methods::MethodKind;
use toile_drape::network::{Networks, TensorRef};
use toile_drape::outfit::{Garment, Material, Outfit, Part, Surface};
use toile_drape::pipeline::{DrapeRequest, Motion, drape};
use toile_drape::refine::Refined;
use toile_drape::static_pass::StaticPass;
use toile_drape::studio::Studio;
use toile_geometry::body::{Body, BodyShape};
use toile_geometry::normals::vertex_normals;
use toile_geometry::poses::PoseLibrary;
use toile_onnx::OnnxNetworks;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn library() -> PathBuf {
    if let Some(path) = std::env::var_os("ORT_DYLIB_PATH") {
        return path.into();
    }
    let lib = repository().join(".venv/lib");
    let python =
        std::fs::read_dir(&lib).expect("run `make build` first: .venv is missing").next().unwrap().unwrap();
    let capi = python.path().join("site-packages/onnxruntime/capi");
    let found = std::fs::read_dir(capi).unwrap().map(|e| e.unwrap().path());
    found.into_iter().find(|p| p.to_string_lossy().contains("libonnxruntime.so")).unwrap()
}

fn networks() -> OnnxNetworks {
    OnnxNetworks::load(&repository().join("model/artifacts"), &library()).unwrap()
}

struct Golden {
    bytes: Vec<u8>,
}

impl Golden {
    fn read() -> Self {
        Self { bytes: std::fs::read(repository().join("model/artifacts/golden/deepsd.safetensors")).unwrap() }
    }

    fn floats(&self, name: &str) -> Vec<f32> {
        let file = SafeTensors::deserialize(&self.bytes).unwrap();
        let data = file.tensor(name).unwrap().data().to_vec();
        data.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
    }

    fn points(&self, name: &str) -> Vec<Vec3> {
        self.floats(name).as_chunks::<3>().0.iter().map(|p| Vec3::from_array(*p)).collect()
    }

    fn outfit(&self) -> Outfit {
        let file = SafeTensors::deserialize(&self.bytes).unwrap();
        let data = file.tensor("triangles").unwrap().data().to_vec();
        let indices: Vec<u32> = data.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect();
        let triangles = indices.as_chunks::<3>().0.to_vec();
        let positions = self.points("vertices");
        let (vertices, faces) = (0..positions.len() as u32, 0..triangles.len() as u32);
        let surface =
            Surface { vertex_of: vertices.clone().collect(), uvs: vec![], triangles: triangles.clone() };
        let garment = Garment {
            name: "tank".to_owned(),
            layer: 0,
            vertices: vertices.clone(),
            drawn_vertices: vertices,
            parts: vec![Part { material: 0, triangles: faces }],
        };
        Outfit {
            positions,
            triangles,
            garments: vec![garment],
            surface,
            materials: vec![Material::default()],
            ..Outfit::default()
        }
    }
}

fn body() -> Body {
    Body::from_safetensors(&std::fs::read(repository().join("model/artifacts/body.safetensors")).unwrap())
        .unwrap()
}

/// Mean and largest distance.
fn differences(a: &[Vec3], b: &[Vec3]) -> (f32, f32) {
    let sum: f32 = a.iter().zip(b).map(|(a, b)| a.distance(*b)).sum();
    (sum / a.len() as f32, largest_difference(a, b))
}

fn largest_difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn graph_prior_and_features_agree_with_the_training_code() {
    let (golden, body) = (Golden::read(), body());
    let studio = Studio::new(body).unwrap();
    let outfit = golden.outfit();
    let fine = Refined::new(&outfit.positions, &outfit.triangles);
    let layers = vec![0; fine.positions.len()];
    let graph = OutfitGraph::new(&fine.positions, &fine.triangles, &layers);
    assert!(largest_difference(&graph.nodes.positions, &golden.points("node_positions")) < 1e-5);
    let prior = node_prior(&graph, &studio.reference);
    let expected = golden.floats("prior");
    let worst = prior.as_flattened().iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-3, "prior differs by {worst}");
    let normals = vertex_normals(&fine.positions, &fine.triangles);
    let features = node_features(&graph, &normals, &prior, &layers, &studio.reference);
    let expected = golden.floats("features");
    assert_eq!(features.len(), expected.len());
    for (i, (a, b)) in features.iter().zip(&expected).enumerate() {
        assert!(
            (a - b).abs() < 5e-3,
            "feature {} of node {}: {a} instead of {b}",
            i % FEATURES,
            i / FEATURES
        );
    }
}

#[test]
fn carried_rest_and_posed_cloth_agree_with_the_training_code() {
    let golden = Golden::read();
    let studio = Studio::new(body()).unwrap();
    let mut networks = networks();
    let outfit = golden.outfit();
    let statics = studio.static_pass(&outfit, &BodyShape::default(), &mut networks).unwrap();
    let values = [("gender", 1.0), ("weight", 0.7), ("height", 0.4)];
    let values: BTreeMap<String, f32> = values.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect();
    let shape = BodyShape::from_values(&studio.body, &values).unwrap();
    let shaped = studio.body.shape(&shape);
    let fitted = statics.fitted(&studio, &shape, &shaped);
    // The server first moves the rest pose off the skin and binds nodes, not vertices: not the same, but near.
    let (mean, largest) = differences(&fitted.rest, &golden.points("rest"));
    assert!(mean < 1.5e-3 && largest < 8e-3, "carried rest pose differs by {mean} m, {largest} m at most");

    let poses = std::fs::read(repository().join("model/artifacts/poses.json")).unwrap();
    let library = PoseLibrary::from_json(&poses, &studio.body).unwrap();
    let poses = ["walk-2", "sitting"]
        .map(|id| library.preset(id).unwrap().pose.to_pose(&studio.body).unwrap())
        .to_vec();
    let motion = Motion { shape, poses, frame_rate: 24.0 };
    let request = DrapeRequest {
        outfit: &outfit,
        statics: &statics,
        motion: &motion,
        method: MethodKind::Deepsd,
        resolve: false,
    };
    let draped = drape(&studio, &request, &mut networks).unwrap();
    let expected = golden.points("posed");
    for (frame, expected) in draped.frames.iter().zip(expected.chunks_exact(outfit.positions.len())) {
        // The presets' root may stand elsewhere on the floor: compare about the means.
        let centre = |x: &[Vec3]| x.iter().sum::<Vec3>() / x.len() as f32;
        let shift = centre(expected) - centre(&frame.positions);
        let moved: Vec<Vec3> = frame.positions.iter().map(|p| *p + shift).collect();
        let (mean, largest) = differences(&moved, expected);
        assert!(mean < 2e-3 && largest < 1.5e-2, "posed cloth differs by {mean} m, {largest} m at most");
    }
}

#[test]
fn a_static_pass_survives_being_stored() {
    let golden = Golden::read();
    let studio = Studio::new(body()).unwrap();
    let statics = studio.static_pass(&golden.outfit(), &BodyShape::default(), &mut networks()).unwrap();
    let bytes = statics.to_bytes().unwrap();
    assert!(StaticPass::from_bytes(&bytes).unwrap() == statics);
    assert!(StaticPass::from_bytes(&bytes[..bytes.len() / 2]).is_err());
}

#[test]
fn the_a_pose_of_the_reference_body_is_the_rest_pose() {
    let golden = Golden::read();
    let studio = Studio::new(body()).unwrap();
    let mut networks = networks();
    let outfit = golden.outfit();
    let statics = studio.static_pass(&outfit, &BodyShape::default(), &mut networks).unwrap();
    let poses = vec![toile_geometry::pose::Pose::identity(&studio.body)];
    let motion = Motion { shape: BodyShape::default(), poses, frame_rate: 24.0 };
    for method in MethodKind::ALL {
        let request =
            DrapeRequest { outfit: &outfit, statics: &statics, motion: &motion, method, resolve: false };
        let draped = drape(&studio, &request, &mut networks).unwrap();
        let difference = largest_difference(&draped.frames[0].positions, statics.rest_positions());
        // Only the basis form is zero at rest by construction; the printed form learns to be nearly so.
        let bound = if method == MethodKind::DeepsdConcat { 2e-2 } else { 1e-4 };
        assert!(difference < bound, "{method}: {difference} m");
    }
}

#[test]
fn a_run_with_a_wrong_extent_is_refused_before_it_reaches_the_runtime() {
    let mut networks = networks();
    let error = networks.run("deepsd/dynamic", &[("pose", TensorRef::F32(&[1, 3], &[0.0; 3]))]).unwrap_err();
    assert!(error.to_string().contains("1 inputs instead of 3"), "{error}");
    assert!(networks.run("deepsd/missing", &[]).is_err());
}
