//! Pixel-based cloth (Jin et al. 2020): a garment of its own network, whose decoder turns a pose into cloth images.
//!
//! The body carries the garment's pixels, held by its triangles; the images say how far the cloth is from there.

use glam::{Quat, Vec3};
use toile_geometry::normals::vertex_normals;
use toile_geometry::pose::Pose;

use super::{ClothImages, Method, Placement, Wearer};
use crate::error::DrapeError;
use crate::hero::{POSE, worn};
use crate::methods::deepsd::only;
use crate::network::{Networks, TensorRef};

/// Joints that stood still in training (`model/pixel_poses.py`).
const LEGS: [&str; 4] = ["leftUpperLeg", "leftLowerLeg", "rightUpperLeg", "rightLowerLeg"];

/// Pixel-based cloth.
pub struct PixelCloth;

impl Method for PixelCloth {
    fn dynamic_pass<'s>(
        &self,
        wearer: &Wearer<'s>,
        networks: &mut dyn Networks,
    ) -> Result<Placement<'s>, DrapeError> {
        let garments = worn(wearer.heroes, wearer.outfit)?;
        let (mut frames, mut first) = (Vec::with_capacity(wearer.transforms.len()), Vec::new());
        let bodies = wearer.poses.iter().zip(wearer.bodies);
        for (transforms, (pose, body)) in wearer.transforms.iter().zip(bodies) {
            let (vertices, normals) = with_still_legs(wearer, pose, body.lift);
            let mut frame = vec![Vec3::ZERO; wearer.outfit.positions.len()];
            for (garment, worn) in wearer.outfit.garments.iter().zip(&garments) {
                let hero = worn.hero;
                let seen = hero.pose(transforms);
                let answer = networks.run(&hero.graph, &[("pose", TensorRef::F32(&[1, POSE], &seen))])?;
                let images = only(&hero.graph, answer, 3 * hero.images * hero.side * hero.side)?;
                let cloth = hero.cloth(&images, (&vertices, &normals));
                let places = frame.iter_mut().skip(garment.vertices.start as usize);
                places.zip(&worn.vertex).for_each(|(place, &v)| *place = cloth[v]);
                if frames.is_empty() {
                    let mask = hero.mask.clone();
                    first.push(ClothImages {
                        garment: garment.name.clone(),
                        side: hero.side,
                        values: images,
                        mask,
                    });
                }
            }
            frames.push(frame);
        }
        Ok(Placement::Pixels { frames, first })
    }
}

/// Vertices and normals of the body as the networks know it: its legs stand still whatever they do, `lift`ed as it is.
///
/// The resolve moves cloth off legs that do move; carried by them, a hem would be torn apart.
fn with_still_legs(wearer: &Wearer<'_>, pose: &Pose, lift: Vec3) -> (Vec<Vec3>, Vec<Vec3>) {
    let (body, mut still) = (wearer.body, pose.clone());
    for name in LEGS {
        let is_there = body.skeleton().set_humanoid(&mut still.rotations, name, Quat::IDENTITY);
        debug_assert!(is_there, "{name} is a joint of every humanoid");
    }
    let mut vertices = body.posed_vertices(wearer.shaped, &body.world_joints(wearer.shaped, &still));
    vertices.iter_mut().for_each(|p| *p += lift);
    let normals = vertex_normals(&vertices, body.triangles());
    (vertices, normals)
}
