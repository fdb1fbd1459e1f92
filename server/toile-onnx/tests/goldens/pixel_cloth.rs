//! Pixel-based cloth.

use std::sync::Arc;

use glam::{Quat, Vec3};
use toile_drape::error::DrapeError;
use toile_drape::hero::Hero;
use toile_drape::methods::MethodKind;
use toile_drape::pipeline::{Drape, DrapeRequest, Frame, Motion, drape};
use toile_drape::studio::Studio;
use toile_geometry::body::BodyShape;
use toile_onnx::OnnxNetworks;

use crate::support::{Golden, body, differences_about_means, motion, networks, repository};

fn tables() -> Vec<u8> {
    std::fs::read(repository().join("model/artifacts/pixel_cloth/tee.safetensors")).unwrap()
}

fn studio() -> Arc<Studio> {
    let body = body();
    let hero = Hero::from_safetensors(&tables(), body.vertex_count()).unwrap();
    Studio::new(body, vec![hero]).unwrap()
}

/// The same on the reference body with legs that stand, as in training.
fn as_in_training(studio: &Studio, mut motion: Motion) -> Motion {
    motion.shape = BodyShape::default();
    for pose in &mut motion.poses {
        for name in ["leftUpperLeg", "leftLowerLeg", "rightUpperLeg", "rightLowerLeg"] {
            assert!(studio.body.skeleton().set_humanoid(&mut pose.rotations, name, Quat::IDENTITY));
        }
    }
    motion
}

/// The golden's garment in every frame of a motion, before any resolve.
fn draped(studio: &Studio, networks: &mut OnnxNetworks, motion: &Motion, method: MethodKind) -> Drape {
    let outfit = Golden::read("pixel_cloth.safetensors").outfit();
    let statics = studio.static_pass(&outfit, &BodyShape::default(), networks).unwrap();
    let (outfit, statics) = (&outfit, &statics);
    let request = DrapeRequest {
        outfit,
        statics,
        motion,
        method,
        kinds: &[],
        hero: None,
        simulated: &[],
        resolve: false,
    };
    drape(studio, &request, networks).unwrap()
}

#[test]
fn draped_cloth_agrees_with_the_training_code() {
    let golden = Golden::read("pixel_cloth.safetensors");
    let (studio, outfit) = (studio(), golden.outfit());
    let motion = as_in_training(&studio, motion(&studio));
    let draped = draped(&studio, &mut networks(), &motion, MethodKind::PixelCloth);
    let (expected, tight) = (golden.points("posed"), golden.points("tight"));
    let vertices = outfit.positions.len();
    let frames = draped.frames.iter().zip(expected.chunks_exact(vertices).zip(tight.chunks_exact(vertices)));
    assert_eq!(frames.len(), 2);
    for (frame, (expected, tight)) in frames {
        let (mean, largest) = differences_about_means(&frame.positions, expected);
        assert!(mean < 2e-4 && largest < 4e-3, "draped cloth differs by {mean} m, {largest} m at most");
        let (moved, _) = differences_about_means(tight, expected);
        assert!(moved > 20.0 * mean, "the network moves the cloth by {moved} m only");
    }
    let [cloth] = draped.images.as_slice() else { panic!("one garment has images") };
    assert_eq!(cloth.values.len(), 6 * 256 * 256);
    assert_eq!(cloth.mask.len(), 2 * 256 * 256);
}

#[test]
fn legs_and_another_body_change_the_cloth_as_they_do_by_deepsd() {
    let (studio, mut networks) = (studio(), networks());
    let moving = motion(&studio);
    let standing = as_in_training(&studio, moving.clone());
    let [by_pixels, by_deepsd] = [MethodKind::PixelCloth, MethodKind::Deepsd].map(|method| {
        let [there, here] = [&moving, &standing].map(|m| draped(&studio, &mut networks, m, method));
        let change = |(a, b): (&Frame, &Frame)| -> Vec<Vec3> {
            a.positions.iter().zip(&b.positions).map(|(a, b)| *a - *b).collect()
        };
        there.frames.iter().zip(&here.frames).map(change).collect::<Vec<_>>()
    });
    for (by_pixels, by_deepsd) in by_pixels.iter().zip(&by_deepsd) {
        let (mean, largest) = differences_about_means(by_pixels, by_deepsd);
        assert!(largest < 1e-4, "differs by {mean} m, {largest} m at most");
    }
    let spread = |x: &[Vec3]| differences_about_means(x, &vec![Vec3::ZERO; x.len()]).1;
    assert!(
        spread(&by_deepsd[1]) > 0.1,
        "sitting on another body moves the hem by {} m only",
        spread(&by_deepsd[1])
    );
}

#[test]
fn poses_are_seen_as_in_training_whichever_way_the_body_faces() {
    let golden = Golden::read("pixel_cloth.safetensors");
    let body = body();
    let hero = Hero::from_safetensors(&tables(), body.vertex_count()).unwrap();
    let studio = Studio::new(body, Vec::new()).unwrap();
    let motion = motion(&studio);
    let shaped = studio.body.shape(&BodyShape::default());
    let expected = golden.floats("pose");
    for (pose, expected) in motion.poses.iter().zip(expected.chunks_exact(90)) {
        let transforms = studio.body.garment_transforms(&shaped, &studio.body.world_joints(&shaped, pose));
        for angle in [0.0, 2.0] {
            let turn = glam::Affine3A::from_rotation_y(angle);
            let turned: Vec<_> = transforms.iter().map(|t| turn * *t).collect();
            let seen = hero.pose(&turned);
            assert!(seen.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4));
        }
    }
}

#[test]
fn a_garment_without_a_network_and_spoilt_tables_are_told() {
    let golden = Golden::read("pixel_cloth.safetensors");
    let body = body();
    let count = body.vertex_count();
    let hero = Hero::from_safetensors(&tables(), count).unwrap();
    assert!(Hero::from_safetensors(&tables(), 100).is_err(), "corners outside of the body");
    assert!(Hero::from_safetensors(&tables()[..1000], count).is_err());
    let mut outfit = golden.outfit();
    assert_eq!(toile_drape::hero::known(&[&hero], &outfit), [true]);
    outfit.positions.reverse();
    let worn = toile_drape::hero::worn(&[&hero], &outfit).unwrap();
    assert_eq!(worn[0].vertex[0], outfit.positions.len() - 1, "the order of the vertices does not matter");
    outfit.positions[7].x += 0.02;
    let error = toile_drape::hero::worn(&[&hero], &outfit).unwrap_err();
    assert!(matches!(error, DrapeError::NoHero { garment } if garment == "garment"));
}
