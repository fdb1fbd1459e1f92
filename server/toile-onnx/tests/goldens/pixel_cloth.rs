//! Pixel-based cloth.

use toile_drape::error::DrapeError;
use toile_drape::hero::{Hero, POSE};
use toile_drape::methods::MethodKind;
use toile_drape::pipeline::{DrapeRequest, drape};
use toile_drape::studio::Studio;
use toile_geometry::body::BodyShape;

use crate::support::{Golden, body, differences_about_means, motion, networks, repository};

fn tables() -> Vec<u8> {
    std::fs::read(repository().join("model/artifacts/pixel_cloth/tee.safetensors")).unwrap()
}

#[test]
fn draped_cloth_agrees_with_the_training_code() {
    let golden = Golden::read("pixel_cloth.safetensors");
    let body = body();
    let hero = Hero::from_safetensors("tee", &tables(), body.vertex_count()).unwrap();
    let studio = Studio::new(body, vec![hero]).unwrap();
    let mut networks = networks();
    let outfit = golden.outfit();
    let statics = studio.static_pass(&outfit, &BodyShape::default(), &mut networks).unwrap();
    let motion = motion(&studio);
    let request = DrapeRequest {
        outfit: &outfit,
        statics: &statics,
        motion: &motion,
        method: MethodKind::PixelCloth,
        kinds: &[],
        resolve: false,
    };
    let draped = drape(&studio, &request, &mut networks).unwrap();
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
fn poses_are_seen_as_in_training_whichever_way_the_body_faces() {
    let golden = Golden::read("pixel_cloth.safetensors");
    let body = body();
    let hero = Hero::from_safetensors("tee", &tables(), body.vertex_count()).unwrap();
    let studio = Studio::new(body, Vec::new()).unwrap();
    let motion = motion(&studio);
    let shaped = studio.body.shape(&motion.shape);
    let expected = golden.floats("pose");
    for (pose, expected) in motion.poses.iter().zip(expected.chunks_exact(POSE)) {
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
    let hero = Hero::from_safetensors("tee", &tables(), count).unwrap();
    assert!(Hero::from_safetensors("tee", &tables(), 100).is_err(), "corners outside of the body");
    assert!(Hero::from_safetensors("tee", &tables()[..1000], count).is_err());
    let heroes = [hero];
    let mut outfit = golden.outfit();
    assert_eq!(toile_drape::hero::known(&heroes, &outfit), [true]);
    outfit.positions.reverse();
    let worn = toile_drape::hero::worn(&heroes, &outfit).unwrap();
    assert_eq!(worn[0].vertex[0], outfit.positions.len() - 1, "the order of the vertices does not matter");
    outfit.positions[7].x += 0.02;
    let error = toile_drape::hero::worn(&heroes, &outfit).unwrap_err();
    assert!(matches!(error, DrapeError::NoHero { garment } if garment == "garment"));
}
