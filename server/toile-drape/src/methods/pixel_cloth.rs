//! Pixel-based cloth (Jin et al. 2020): a garment of its own network, whose decoder turns a pose into cloth images.
//!
//! A body carries the garment's pixels, held by its triangles; the images say how far the cloth is from there. The
//! network knows the reference body alone, and mostly legs that stand. What another shape and moving legs do to the
//! cloth is what they do to it by `DeePSD`: the drape is `DeePSD`'s, and what the network says beyond it where it knows.

use glam::{Affine3A, Quat, Vec3};
use toile_geometry::body::BodyShape;
use toile_geometry::normals::vertex_normals;
use toile_geometry::pose::Pose;

use super::deepsd::Deepsd;
use super::{ClothImages, Method, Placement, Wearer};
use crate::error::DrapeError;
use crate::hero::{SIDE, Worn, worn};
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
        let see_legs = garments.iter().all(|worn| worn.hero.sees_legs);
        let known: Vec<Known> = wearer.poses.iter().map(|pose| Known::of(wearer, pose, see_legs)).collect();
        let mut frames = beyond_known(wearer, &known, networks)?;
        let mut first = Vec::with_capacity(garments.len());
        for (index, (frame, known)) in frames.iter_mut().zip(&known).enumerate() {
            for (garment, worn) in wearer.outfit.garments.iter().zip(&garments) {
                let images = worn.hero.images(&worn.hero.pose(&known.transforms), networks)?;
                let cloth = worn.hero.cloth(&images, (&known.vertices, &known.normals));
                let range = garment.vertices.start as usize..garment.vertices.end as usize;
                add(frame.get_mut(range).unwrap_or_default(), worn, &cloth);
                if index == 0 {
                    let (garment, mask) = (garment.name.clone(), worn.hero.mask.clone());
                    first.push(ClothImages { garment, side: SIDE, values: images, mask });
                }
            }
        }
        Ok(Placement::Pixels { frames, first })
    }
}

fn add(places: &mut [Vec3], worn: &Worn<'_>, cloth: &[Vec3]) {
    let own = worn.vertex.iter().map(|&v| cloth.get(v).copied().unwrap_or_default());
    places.iter_mut().zip(own).for_each(|(place, there)| *place += there);
}

/// A body as networks know it, in one pose: the reference body, not lifted, its legs standing unless they `see_legs`.
struct Known {
    vertices: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// World from A-pose of the garment joints.
    transforms: Vec<Affine3A>,
}

impl Known {
    fn of(wearer: &Wearer<'_>, pose: &Pose, see_legs: bool) -> Self {
        let (body, mut pose) = (wearer.body, pose.clone());
        for name in if see_legs { &[] } else { LEGS.as_slice() } {
            let is_there = body.skeleton().set_humanoid(&mut pose.rotations, name, Quat::IDENTITY);
            debug_assert!(is_there, "{name} is a joint of every humanoid");
        }
        let world = body.world_joints(wearer.reference, &pose);
        let vertices = body.posed_vertices(wearer.reference, &world);
        let normals = vertex_normals(&vertices, body.triangles());
        let transforms = body.garment_transforms(wearer.reference, &world);
        Self { vertices, normals, transforms }
    }
}

/// `DeePSD`'s cloth on the body as it is, less that on the body that networks know, in every frame.
fn beyond_known(
    wearer: &Wearer<'_>,
    known: &[Known],
    networks: &mut dyn Networks,
) -> Result<Vec<Vec<Vec3>>, DrapeError> {
    let transforms: Vec<Vec<Affine3A>> = known.iter().map(|k| k.transforms.clone()).collect();
    let (rest, shape) = (wearer.statics.rest_positions(), BodyShape::default());
    let reference =
        Wearer { rest, shape: &shape, shaped: wearer.reference, transforms: &transforms, ..*wearer };
    let (here, there) = (Deepsd.dynamic_pass(wearer, networks)?, Deepsd.dynamic_pass(&reference, networks)?);
    let frame = |(index, (own, known)): (usize, (&Vec<Affine3A>, &Vec<Affine3A>))| {
        let (here, there) = (place(&here, index, wearer.rest, own), place(&there, index, rest, known));
        here.iter().zip(there).map(|(here, there)| *here - there).collect()
    };
    Ok(wearer.transforms.iter().zip(&transforms).enumerate().map(frame).collect())
}
