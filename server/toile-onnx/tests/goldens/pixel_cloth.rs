//! Pixel-based cloth.

use std::sync::Arc;

use glam::{Quat, Vec3};
use safetensors::SafeTensors;
use safetensors::tensor::TensorView;
use toile_drape::error::DrapeError;
use toile_drape::hero::{Hero, SIDE};
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

/// The tables with every site held twice by its triangle, by shares of a quarter and three quarters.
fn held_by_two() -> Vec<u8> {
    let bytes = tables();
    let file = SafeTensors::deserialize(&bytes).unwrap();
    let twice = |name: &str, shares: [f32; 2]| -> Vec<u8> {
        let rows = file.tensor(name).unwrap().data().as_chunks::<12>().0.iter();
        let scaled = |word: &[u8; 4], share: f32| match name {
            "corner" => *word,
            _ => (share * f32::from_le_bytes(*word)).to_le_bytes(),
        };
        let of_row = |row: &[u8; 12]| {
            shares.map(|share| row.as_chunks().0.iter().flat_map(|w| scaled(w, share)).collect::<Vec<_>>())
        };
        rows.flat_map(|row| of_row(row).concat()).collect()
    };
    let changed = ["corner", "corner_weight"].map(|name| (name.to_owned(), twice(name, [0.25, 0.75])));
    let views = file.tensors().into_iter().map(|(name, kept)| {
        let found = changed.iter().find(|(other, _)| *other == name);
        let wider = |data| TensorView::new(kept.dtype(), vec![kept.shape()[0], 6], data).unwrap();
        let view = found.map(|(_, data)| wider(data));
        (name, view.unwrap_or(kept))
    });
    safetensors::serialize(views.collect::<Vec<_>>(), None).unwrap()
}

#[test]
fn cloth_may_lie_on_several_triangles() {
    let body = body();
    let (once, twice) = (tables(), held_by_two());
    let [once, twice] =
        [once, twice].map(|bytes| Hero::from_safetensors(&bytes, body.vertex_count()).unwrap());
    let rest = body.shape(&BodyShape::default()).apose_vertices;
    let images = vec![0.01; 6 * SIDE * SIDE];
    let cloth = [once, twice].map(|hero| hero.cloth(&images, (&rest, &rest)));
    assert!(cloth[0].iter().zip(&cloth[1]).all(|(a, b)| a.distance(*b) < 1e-5));
    assert!(cloth[0].iter().all(|p| p.y > 0.5), "on the trunk");
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
