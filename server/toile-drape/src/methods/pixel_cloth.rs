//! Pixel-based cloth (Jin et al. 2020): a garment of its own network, whose decoder turns a pose into cloth images.
//!
//! The body carries the garment's pixels, held by its triangles; the images say how far the cloth is from there. What
//! legs do to a garment whose network never saw them is what they
//! do to it by `DeePSD`.

use glam::{Affine3A, Quat, Vec3};
use toile_geometry::normals::vertex_normals;
use toile_geometry::pose::Pose;

use super::deepsd::Deepsd;
use super::{ClothImages, Method, Placement, Wearer};
use crate::error::DrapeError;
use crate::hero::{Hero, SIDE, Worn, worn};
use crate::network::Networks;
use crate::skinning::place;

/// Joints that stood still where a network saw the upper body alone (`model/pixel_poses.py`).
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
        let see_legs = garments.iter().all(|worn| worn.hero.sees_legs);
        let by_legs = if see_legs { Vec::new() } else { by_legs(wearer, &still, networks)? };
        let (mut frames, mut first) = (Vec::with_capacity(still.len()), Vec::new());
        for (index, still) in still.iter().enumerate() {
            let mut frame = vec![Vec3::ZERO; wearer.outfit.positions.len()];
            for (garment, worn) in wearer.outfit.garments.iter().zip(&garments) {
                let (body, transforms) = carrier(wearer, index, still, worn.hero);
                let images = worn.hero.images(&worn.hero.pose(transforms), networks)?;
                let range = garment.vertices.start as usize..garment.vertices.end as usize;
                let moved = by_legs.get(index).filter(|_| !worn.hero.sees_legs);
                let moved = moved.and_then(|moved| moved.get(range.clone())).unwrap_or_default();
                let places = frame.get_mut(range).unwrap_or_default();
                put(places, worn, &worn.hero.cloth(&images, body), moved);
                if index == 0 {
                    let (garment, mask) = (garment.name.clone(), worn.hero.mask.clone());
                    first.push(ClothImages { garment, side: SIDE, values: images, mask });
                }
            }
            frames.push(frame);
        }
        Ok(Placement::Pixels { frames, first })
    }
}

/// Cloth of a network's garment at the `places` of an outfit's, and as far as legs moved it from there, if they did.
fn put(places: &mut [Vec3], worn: &Worn<'_>, cloth: &[Vec3], moved: &[Vec3]) {
    let own = worn.vertex.iter().map(|&v| cloth.get(v).copied().unwrap_or_default());
    places.iter_mut().zip(own).for_each(|(place, there)| *place = there);
    places.iter_mut().zip(moved).for_each(|(place, moved)| *place += *moved);
}

/// The body, its vertices and normals, and its joints as a hero's network knows them in a frame.
fn carrier<'b>(
    wearer: &Wearer<'b>,
    index: usize,
    still: &'b StillLegs,
    hero: &Hero,
) -> ((&'b [Vec3], &'b [Vec3]), &'b [Affine3A]) {
    match (wearer.bodies.get(index), wearer.transforms.get(index)) {
        (Some(body), Some(transforms)) if hero.sees_legs => ((&body.vertices, &body.normals), transforms),
        _ => ((&still.vertices, &still.normals), &still.transforms),
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
