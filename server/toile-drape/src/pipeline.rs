//! From a body and poses to draped cloth. Open this file first.

use std::sync::Arc;
use std::time::Instant;

use glam::{Affine3A, Vec3};
use serde::{Deserialize, Serialize};
use toile_geometry::body::{BodyShape, ShapedBody};
use toile_geometry::normals::vertex_normals;
use toile_geometry::pose::Pose;

use crate::contact::Collider;
use crate::error::DrapeError;
use crate::fitted::{Fitted, lengths};
use crate::hero::Hero;
use crate::methods::{ClothImages, GarmentKind, MethodKind, Placement, SimulatedDrape, Wearer};
use crate::network::Networks;
use crate::outfit::Outfit;
use crate::posed_body::PosedBody;
use crate::resolve::{Resolved, resolve};
use crate::settle::settle;
use crate::skinning::place;
use crate::static_pass::StaticPass;
use crate::studio::Studio;

/// A body in one or more poses.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Shape of the body, the same in every frame.
    pub shape: BodyShape,
    /// One pose a frame.
    pub poses: Vec<Pose>,
    /// Frames a second.
    pub frame_rate: f32,
}

/// What to drape, on whom, how.
pub struct DrapeRequest<'a> {
    /// The outfit.
    pub outfit: &'a Outfit,
    /// Its static pass.
    pub statics: &'a StaticPass,
    /// The body and its poses.
    pub motion: &'a Motion,
    /// The way to drape.
    pub method: MethodKind,
    /// Kind of every garment, innermost first; empty for methods that need none.
    pub kinds: &'a [GarmentKind],
    /// A pixel-cloth network of the outfit's own, beside those of the studio.
    pub hero: Option<&'a Hero>,
    /// Kept simulations of the outfit, for the method that shows them.
    pub simulated: &'a [SimulatedDrape],
    /// Whether cloth inside the body or under inner garments is moved out afterwards.
    pub resolve: bool,
}

/// One draped frame, world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Cloth, welded order, metres.
    pub positions: Vec<Vec3>,
    /// Unit normals of the cloth.
    pub normals: Vec<Vec3>,
    /// The body.
    pub body: Arc<PosedBody>,
    /// Metres inside the body before cloth is moved out, 0 outside.
    pub penetration: Vec<f32>,
    /// Mean strain of the edges at each vertex (length over rest length, less 1).
    pub strain: Vec<f32>,
}

/// How good a drape is; the worst frame counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Vertices inside the body before cloth is moved out, percent.
    pub penetration_before_percent: f32,
    /// Vertices inside the body after the resolve, percent.
    pub penetration_after_percent: f32,
    /// 95th percentile of |length over rest length, less 1| over the edges.
    pub p95_edge_strain: f32,
    /// Largest length over rest length.
    pub max_edge_stretch: f32,
}

/// Milliseconds of each stage, summed over frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timing(Vec<(&'static str, f64)>);

impl Timing {
    /// Stages in order with their milliseconds.
    pub fn stages(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.0.iter().copied()
    }

    /// Milliseconds of all stages.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.0.iter().map(|s| s.1).sum()
    }

    fn time<T>(&mut self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let out = work();
        let spent = started.elapsed().as_secs_f64() * 1e3;
        match self.0.iter_mut().find(|s| s.0 == stage) {
            Some(slot) => slot.1 += spent,
            None => self.0.push((stage, spent)),
        }
        out
    }
}

/// Draped frames with what is known about them.
#[derive(Clone, Debug, Default)]
pub struct Drape {
    /// One a pose.
    pub frames: Vec<Frame>,
    /// The worst frame's quality.
    pub quality: Quality,
    /// What a pixel-cloth network said of the first frame, one entry a garment.
    pub images: Vec<ClothImages>,
    /// Where the time went.
    pub timing: Timing,
}

/// Drapes an outfit on a body in every pose of a motion.
///
/// # Errors
/// When there is no pose, the static pass is of another outfit, or a network fails.
pub fn drape(
    studio: &Studio,
    request: &DrapeRequest<'_>,
    networks: &mut dyn Networks,
) -> Result<Drape, DrapeError> {
    check(request)?;
    let mut out = Drape::default();
    let timing = &mut out.timing;
    let (shaped, fitted) = timing.time("body", || clothe(studio, request));
    let posed = timing.time("body", || posed(studio, &shaped, request.motion));
    let heroes: Vec<&Hero> = request.hero.into_iter().chain(&studio.heroes).collect();
    let wearer = Wearer {
        outfit: request.outfit,
        statics: request.statics,
        kinds: request.kinds,
        rest: &fitted.rest,
        shape: &request.motion.shape,
        body: &studio.body,
        shaped: &shaped,
        reference: &studio.reference_body,
        poses: &request.motion.poses,
        transforms: &posed.transforms,
        parents: &studio.garment_parents,
        bodies: &posed.bodies,
        seen: &studio.seen,
        heroes: &heroes,
        simulated: request.simulated,
    };
    let method = request.method.method();
    let placement = timing.time("dynamic", || method.dynamic_pass(&wearer, networks))?;
    let scene = Scene { studio, fitted: &fitted, placement: &placement, request };
    for (index, (body, transforms)) in posed.bodies.iter().zip(&posed.transforms).enumerate() {
        let (frame, quality) = drape_frame(&scene, index, body, transforms, timing);
        out.quality = out.quality.worse(quality);
        out.frames.push(frame);
    }
    if let Placement::Pixels { first, .. } = placement {
        out.images = first;
    }
    Ok(out)
}

fn check(request: &DrapeRequest<'_>) -> Result<(), DrapeError> {
    let (expected, found) = (request.outfit.positions.len(), request.statics.rest.len());
    if request.motion.poses.is_empty() {
        return Err(DrapeError::NoPose);
    }
    if expected != found {
        return Err(DrapeError::OtherOutfit { expected, found });
    }
    Ok(())
}

fn clothe(studio: &Studio, request: &DrapeRequest<'_>) -> (Arc<ShapedBody>, Arc<Fitted>) {
    let shape = &request.motion.shape;
    let shaped = studio.shapes.get(shape.clone(), |s| studio.body.shape(s));
    let fitted = request.statics.fitted(studio, request.outfit, shape, &shaped);
    (shaped, fitted)
}

/// The body in every frame, standing on the floor.
struct PosedBodies {
    bodies: Vec<Arc<PosedBody>>,
    /// World-from-A-pose transforms of the garment joints.
    transforms: Vec<Vec<Affine3A>>,
}

fn posed(studio: &Studio, shaped: &ShapedBody, motion: &Motion) -> PosedBodies {
    let (body, parts) = (&studio.body, &studio.reference.parts);
    let frame = |pose: &Pose| {
        let world = body.world_joints(shaped, pose);
        let key = (motion.shape.clone(), pose.clone());
        let posed = studio.posed.get(key, |_| PosedBody::standing(body, parts, shaped, &world));
        let lift = Affine3A::from_translation(posed.lift);
        let transforms = body.garment_transforms(shaped, &world).iter().map(|t| lift * *t).collect();
        (posed, transforms)
    };
    let (bodies, transforms) = motion.poses.iter().map(frame).unzip();
    PosedBodies { bodies, transforms }
}

struct Scene<'a> {
    studio: &'a Studio,
    fitted: &'a Fitted,
    placement: &'a Placement<'a>,
    request: &'a DrapeRequest<'a>,
}

fn drape_frame(
    scene: &Scene<'_>,
    index: usize,
    posed: &Arc<PosedBody>,
    transforms: &[Affine3A],
    timing: &mut Timing,
) -> (Frame, Quality) {
    let (outfit, statics) = (scene.request.outfit, scene.request.statics);
    let mut positions =
        timing.time("skinning", || place(scene.placement, index, &scene.fitted.rest, transforms));
    let reference = &scene.studio.reference;
    let skin = Collider {
        vertices: &posed.vertices,
        normals: &posed.normals,
        ring: &reference.ring,
        facing: &posed.facing,
        cells: Some(&posed.cells),
        feet: reference.feet.each_ref().map(Vec::as_slice),
    };
    if scene.request.resolve && scene.request.method.settles() {
        timing.time("settle", || settle(statics, scene.fitted, &skin, &mut positions));
    }
    let resolved = timing.time("resolve", || match scene.placement {
        // Where cloth lies inside the body is told, but it stays there.
        Placement::Finished(_) => {
            let found = resolve(outfit, statics, scene.fitted, &skin, &mut positions.clone());
            Resolved { inside_after: found.inside_before, ..found }
        }
        _ if scene.request.resolve => resolve(outfit, statics, scene.fitted, &skin, &mut positions),
        _ => Resolved::default(),
    });
    let normals = timing.time("normals", || vertex_normals(&positions, &outfit.triangles));
    let (strain, mut quality) = timing.time("quality", || strains(scene, &positions));
    let percent = |count: usize| 100.0 * count as f32 / positions.len().max(1) as f32;
    quality.penetration_before_percent = percent(resolved.inside_before);
    quality.penetration_after_percent = percent(resolved.inside_after);
    let penetration = resolved.depth_before;
    (Frame { positions, normals, body: Arc::clone(posed), penetration, strain }, quality)
}

/// Strain at each vertex and the quality figures that follow from the edges.
fn strains(scene: &Scene<'_>, positions: &[Vec3]) -> (Vec<f32>, Quality) {
    let edges = &scene.request.statics.edges;
    let ratio: Vec<f32> = lengths(positions, edges)
        .iter()
        .zip(&scene.fitted.lengths)
        .map(|(now, rest)| now / rest.max(1e-5))
        .collect();
    let (mut sums, mut counts) = (vec![0.0_f32; positions.len()], vec![0_u32; positions.len()]);
    for (edge, r) in edges.iter().zip(&ratio) {
        for &v in edge {
            sums[v as usize] += r - 1.0;
            counts[v as usize] += 1;
        }
    }
    sums.iter_mut().zip(&counts).for_each(|(s, c)| *s /= (*c).max(1) as f32);
    let max_edge_stretch = ratio.iter().copied().fold(0.0, f32::max);
    let mut size: Vec<f32> = ratio.iter().map(|r| (r - 1.0).abs()).collect();
    let at = (size.len() * 95 / 100).min(size.len().saturating_sub(1));
    let p95_edge_strain =
        if size.is_empty() { 0.0 } else { *size.select_nth_unstable_by(at, f32::total_cmp).1 };
    (sums, Quality { p95_edge_strain, max_edge_stretch, ..Quality::default() })
}

impl Quality {
    /// The worse of each figure.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        Self {
            penetration_before_percent: self.penetration_before_percent.max(other.penetration_before_percent),
            penetration_after_percent: self.penetration_after_percent.max(other.penetration_after_percent),
            p95_edge_strain: self.p95_edge_strain.max(other.p95_edge_strain),
            max_edge_stretch: self.max_edge_stretch.max(other.max_edge_stretch),
        }
    }
}
