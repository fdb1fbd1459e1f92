//! `DeePSD`.

use toile_drape::binding::node_prior;
use toile_drape::features::{FEATURES, node_features};
use toile_drape::graph::OutfitGraph;
use toile_drape::methods::{GarmentKind, MethodKind};
use toile_drape::network::{Networks, TensorRef};
use toile_drape::pipeline::{DrapeRequest, Motion, drape};
use toile_drape::refine::Refined;
use toile_drape::static_pass::StaticPass;
use toile_drape::studio::Studio;
use toile_geometry::body::BodyShape;
use toile_geometry::normals::vertex_normals;

use crate::support::{
    Golden, body, differences, differences_about_means, largest_difference, motion, networks,
};

#[test]
fn graph_prior_and_features_agree_with_the_training_code() {
    let (golden, body) = (Golden::read("deepsd.safetensors"), body());
    let studio = Studio::new(body, Vec::new()).unwrap();
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
    let golden = Golden::read("deepsd.safetensors");
    let studio = Studio::new(body(), Vec::new()).unwrap();
    let mut networks = networks();
    let outfit = golden.outfit();
    let statics = studio.static_pass(&outfit, &BodyShape::default(), &mut networks).unwrap();
    let motion = motion(&studio);
    let shaped = studio.body.shape(&motion.shape);
    let fitted = statics.fitted(&studio, &outfit, &motion.shape, &shaped);
    // The server first moves the rest pose off the skin and binds nodes, not vertices: not the same, but near.
    let (mean, largest) = differences(&fitted.rest, &golden.points("rest"));
    assert!(mean < 1.5e-3 && largest < 8e-3, "carried rest pose differs by {mean} m, {largest} m at most");

    let request = DrapeRequest {
        outfit: &outfit,
        statics: &statics,
        motion: &motion,
        method: MethodKind::Deepsd,
        kinds: &[],
        hero: None,
        simulated: &[],
        resolve: false,
    };
    let draped = drape(&studio, &request, &mut networks).unwrap();
    let expected = golden.points("posed");
    for (frame, expected) in draped.frames.iter().zip(expected.chunks_exact(outfit.positions.len())) {
        let (mean, largest) = differences_about_means(&frame.positions, expected);
        assert!(mean < 2e-3 && largest < 1.5e-2, "posed cloth differs by {mean} m, {largest} m at most");
    }
}

#[test]
fn a_static_pass_survives_being_stored() {
    let golden = Golden::read("deepsd.safetensors");
    let studio = Studio::new(body(), Vec::new()).unwrap();
    let statics = studio.static_pass(&golden.outfit(), &BodyShape::default(), &mut networks()).unwrap();
    let bytes = statics.to_bytes().unwrap();
    assert!(StaticPass::from_bytes(&bytes).unwrap() == statics);
    assert!(StaticPass::from_bytes(&bytes[..bytes.len() / 2]).is_err());
}

#[test]
fn the_a_pose_of_the_reference_body_is_the_rest_pose() {
    let golden = Golden::read("deepsd.safetensors");
    let studio = Studio::new(body(), Vec::new()).unwrap();
    let mut networks = networks();
    let outfit = golden.outfit();
    let statics = studio.static_pass(&outfit, &BodyShape::default(), &mut networks).unwrap();
    let poses = vec![toile_geometry::pose::Pose::identity(&studio.body)];
    let motion = Motion { shape: BodyShape::default(), poses, frame_rate: 24.0 };
    // Pixel cloth drapes the garments that it was trained on alone, a simulation those that were simulated.
    let of_few = [MethodKind::PixelCloth, MethodKind::Simulation];
    for method in MethodKind::ALL.into_iter().filter(|method| !of_few.contains(method)) {
        let request = DrapeRequest {
            outfit: &outfit,
            statics: &statics,
            motion: &motion,
            method,
            kinds: &[GarmentKind::Tee],
            hero: None,
            simulated: &[],
            resolve: false,
        };
        let draped = drape(&studio, &request, &mut networks).unwrap();
        let difference = largest_difference(&draped.frames[0].positions, statics.rest_positions());
        // Only the basis form is zero at rest by construction; the printed form learns to be nearly so, and GarNet
        // drapes what was drawn.
        let bound = match method {
            MethodKind::Garnet => 5e-2,
            MethodKind::DeepsdConcat => 2e-2,
            _ => 1e-4,
        };
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
