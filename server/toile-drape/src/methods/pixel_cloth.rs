//! Pixel-based cloth (Jin et al. 2020): a garment of its own network, whose decoder turns a pose into cloth images.
//!
//! The body carries the garment's pixels, held by its triangles; the images say how far the cloth is from there. What
//! legs do to it, which the networks never saw, is what they do to it by `DeePSD`.

use glam::{Affine3A, Quat, Vec3};
use toile_geometry::normals::vertex_normals;
use toile_geometry::pose::Pose;

use super::deepsd::{Deepsd, only};
use super::{ClothImages, Method, Placement, Wearer};
use crate::error::DrapeError;
use crate::hero::{POSE, worn};
use crate::network::{Networks, TensorRef};
use crate::skinning::place;

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
        let bodies = wearer.poses.iter().zip(wearer.bodies);
        let still: Vec<StillLegs> =
            bodies.map(|(pose, body)| StillLegs::of(wearer, pose, body.lift)).collect();
        let (mut frames, mut first) = (by_legs(wearer, &still, networks)?, Vec::new());
        for (index, (frame, still)) in frames.iter_mut().zip(&still).enumerate() {
            for (garment, worn) in wearer.outfit.garments.iter().zip(&garments) {
                let hero = worn.hero;
                let seen = hero.pose(&still.transforms);
                let answer = networks.run(&hero.graph, &[("pose", TensorRef::F32(&[1, POSE], &seen))])?;
                let images = only(&hero.graph, answer, 3 * hero.images * hero.side * hero.side)?;
                let cloth = hero.cloth(&images, (&still.vertices, &still.normals));
                let places = frame.iter_mut().skip(garment.vertices.start as usize);
                places.zip(&worn.vertex).for_each(|(place, &v)| *place += cloth[v]);
                if index == 0 {
                    let (garment, mask) = (garment.name.clone(), hero.mask.clone());
                    first.push(ClothImages { garment, side: hero.side, values: images, mask });
                }
            }
        }
        Ok(Placement::Pixels { frames, first })
    }
}

/// A body whose legs stand still whatever they do, lifted as it is. Carried by legs that move, a hem would be torn.
struct StillLegs {
    vertices: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// World from A-pose of the garment joints.
    transforms: Vec<Affine3A>,
    /// Whether that is how the legs are.
    is_as_posed: bool,
}

impl StillLegs {
    fn of(wearer: &Wearer<'_>, pose: &Pose, lift: Vec3) -> Self {
        let (body, mut still) = (wearer.body, pose.clone());
        for name in LEGS {
            let is_there = body.skeleton().set_humanoid(&mut still.rotations, name, Quat::IDENTITY);
            debug_assert!(is_there, "{name} is a joint of every humanoid");
        }
        let world = body.world_joints(wearer.shaped, &still);
        let mut vertices = body.posed_vertices(wearer.shaped, &world);
        vertices.iter_mut().for_each(|p| *p += lift);
        let normals = vertex_normals(&vertices, body.triangles());
        let lift = Affine3A::from_translation(lift);
        let transforms = body.garment_transforms(wearer.shaped, &world).iter().map(|t| lift * *t).collect();
        Self { vertices, normals, transforms, is_as_posed: still == *pose }
    }
}

/// How far legs move the cloth of every frame, world, by `DeePSD` with and without them.
fn by_legs(
    wearer: &Wearer<'_>,
    still: &[StillLegs],
    networks: &mut dyn Networks,
) -> Result<Vec<Vec<Vec3>>, DrapeError> {
    if still.iter().all(|s| s.is_as_posed) {
        return Ok(vec![vec![Vec3::ZERO; wearer.outfit.positions.len()]; still.len()]);
    }
    let transforms: Vec<Vec<Affine3A>> = still.iter().map(|s| s.transforms.clone()).collect();
    let moving = Deepsd.dynamic_pass(wearer, networks)?;
    let standing = Deepsd.dynamic_pass(&Wearer { transforms: &transforms, ..*wearer }, networks)?;
    let frame = |(index, (moved, still)): (usize, (&Vec<Affine3A>, &Vec<Affine3A>))| {
        let there = place(&moving, index, wearer.rest, moved);
        let here = place(&standing, index, wearer.rest, still);
        there.iter().zip(here).map(|(there, here)| *there - here).collect()
    };
    Ok(wearer.transforms.iter().zip(&transforms).enumerate().map(frame).collect())
}
