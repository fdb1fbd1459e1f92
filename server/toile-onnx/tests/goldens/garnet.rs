//! `GarNet++`.

use std::collections::BTreeSet;

use toile_drape::methods::{GarmentKind, MethodKind};
use toile_drape::pipeline::{DrapeRequest, drape};
use toile_drape::studio::Studio;
use toile_geometry::body::BodyShape;

use crate::support::{Golden, body, differences_about_means, motion, networks};

#[test]
fn what_it_sees_of_the_body_agrees_with_the_training_code() {
    let golden = Golden::read("garnet.safetensors");
    let studio = Studio::new(body(), Vec::new()).unwrap();
    let seen = &studio.seen;
    let set = |points: &[u32]| points.iter().copied().collect::<BTreeSet<_>>();
    // Rounding may decide which of two equally central points stands for a cell.
    let (here, there) = (set(&seen.points), set(&golden.indices("points")));
    assert!(here.intersection(&there).count() * 1000 > 995 * there.len());
    assert!(seen.thinned.len().abs_diff(golden.indices("thinned").len() / 16) <= 4);
}

#[test]
fn warped_and_draped_cloth_agree_with_the_training_code() {
    let golden = Golden::read("garnet.safetensors");
    let studio = Studio::new(body(), Vec::new()).unwrap();
    let mut networks = networks();
    let outfit = golden.outfit();
    let statics = studio.static_pass(&outfit, &BodyShape::default(), &mut networks).unwrap();
    let motion = motion(&studio);
    let request = DrapeRequest {
        outfit: &outfit,
        statics: &statics,
        motion: &motion,
        method: MethodKind::Garnet,
        kinds: &[GarmentKind::Tee],
        hero: None,
        simulated: &[],
        resolve: false,
    };
    let draped = drape(&studio, &request, &mut networks).unwrap();
    let (expected, warped) = (golden.points("posed"), golden.points("warped"));
    let vertices = outfit.positions.len();
    let frames = draped.frames.iter().zip(expected.chunks_exact(vertices).zip(warped.chunks_exact(vertices)));
    for (frame, (expected, warped)) in frames {
        let (mean, largest) = differences_about_means(&frame.positions, expected);
        assert!(mean < 2e-3 && largest < 1.5e-2, "draped cloth differs by {mean} m, {largest} m at most");
        let (moved, _) = differences_about_means(warped, expected);
        assert!(moved > 2.0 * mean, "the network moves the cloth by {moved} m only");
    }
    let none = DrapeRequest { kinds: &[], ..request };
    assert!(drape(&studio, &none, &mut networks).is_err());
}
