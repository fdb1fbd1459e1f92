//! Joints: their hierarchy, the humanoid names of the API, and the garment skeleton.

use std::collections::BTreeMap;

use glam::{Affine3A, Quat, Vec3, Vec3A};

use crate::pose::Pose;

/// All joints of the body.
#[derive(Clone, Debug, Default)]
pub struct Skeleton {
    names: Vec<String>,
    parents: Vec<Option<usize>>,
    humanoid: Vec<HumanoidJoint>,
    /// The joint that stands for each garment joint.
    garment_joints: Vec<usize>,
    garment_parents: Vec<Option<usize>>,
}

/// Humanoid names as the body file has them.
#[derive(Clone, Debug, Default)]
pub struct HumanoidSource {
    /// Humanoid name -> one or two joints, from the root outwards.
    pub joints: BTreeMap<String, Vec<String>>,
    /// Unit direction of each limb of two joints, on the reference body in the A-pose.
    pub bone_axes: BTreeMap<String, [f32; 3]>,
}

/// A humanoid (VRM) joint and what it drives.
#[derive(Clone, Debug)]
struct HumanoidJoint {
    name: String,
    drive: Drive,
    parent: Option<usize>,
}

/// How the rotation of a humanoid joint is shared by the joints it drives.
#[derive(Clone, Debug)]
enum Drive {
    /// One joint takes it whole.
    Whole(usize),
    /// Two joints of the spine take half each.
    Halves([usize; 2]),
    /// The first of a limb takes the swing and half of the twist about the axis, the second the other
    /// half: a turned sleeve twists evenly.
    SwingTwist([usize; 2], Vec3),
}

impl Drive {
    fn first(&self) -> usize {
        match self {
            Self::Whole(joint) | Self::Halves([joint, _]) | Self::SwingTwist([joint, _], _) => *joint,
        }
    }

    fn drives(&self, joint: usize) -> bool {
        match self {
            Self::Whole(only) => *only == joint,
            Self::Halves(pair) | Self::SwingTwist(pair, _) => pair.contains(&joint),
        }
    }
}

impl Skeleton {
    /// Checks and indexes joints; `garment_of` names each joint's garment joint.
    ///
    /// # Errors
    /// What is wrong, in words: several roots, a child before its parent, a humanoid name of no joint,
    /// a garment joint that none stands for.
    pub fn new(
        names: Vec<String>,
        parents: Vec<Option<usize>>,
        garment_of: &[u32],
        humanoid: &HumanoidSource,
    ) -> Result<Self, String> {
        let ordered = parents.iter().enumerate().all(|(j, p)| p.map_or(j == 0, |p| p < j));
        if !ordered || names.len() != parents.len() || garment_of.len() != names.len() {
            return Err("joints are not a tree of one root with parents first".to_owned());
        }
        let garment_count = garment_of.iter().max().map_or(0, |&g| g as usize + 1).min(names.len() + 1);
        let standing = |g: usize| garment_of.iter().position(|&of| of as usize == g);
        let garment_joints: Option<Vec<usize>> = (0..garment_count).map(standing).collect();
        let garment_joints = garment_joints.ok_or("a garment joint that no joint stands for")?;
        let garment_parents = garment_joints
            .iter()
            .map(|&j| parents.get(j).copied().flatten().and_then(|p| garment_of.get(p)).map(|&g| g as usize))
            .collect();
        let mut out = Self { names, parents, humanoid: Vec::new(), garment_joints, garment_parents };
        out.humanoid = out.humanoid_from(humanoid)?;
        Ok(out)
    }

    fn humanoid_from(&self, source: &HumanoidSource) -> Result<Vec<HumanoidJoint>, String> {
        let mut out = Vec::with_capacity(source.joints.len());
        for (name, joints) in &source.joints {
            let indices: Option<Vec<usize>> = joints.iter().map(|j| self.index(j)).collect();
            let axis = source.bone_axes.get(name).map(|&axis| Vec3::from(axis).try_normalize());
            let drive = match (indices.as_deref(), axis) {
                (Some(&[joint]), None) => Drive::Whole(joint),
                (Some(&[first, second]), None) => Drive::Halves([first, second]),
                (Some(&[first, second]), Some(Some(axis))) => Drive::SwingTwist([first, second], axis),
                _ => return Err(format!("humanoid joint {name:?} drives {joints:?}")),
            };
            out.push(HumanoidJoint { name: name.clone(), drive, parent: None });
        }
        out.sort_by_key(|joint| joint.drive.first());
        let parents: Vec<Option<usize>> = out.iter().map(|joint| self.humanoid_parent(&out, joint)).collect();
        out.iter_mut().zip(parents).for_each(|(joint, parent)| joint.parent = parent);
        Ok(out)
    }

    /// The nearest ancestor that another humanoid joint drives.
    fn humanoid_parent(&self, all: &[HumanoidJoint], joint: &HumanoidJoint) -> Option<usize> {
        let mut at = self.parents.get(joint.drive.first()).copied().flatten();
        while let Some(ancestor) = at {
            if let Some(k) = all.iter().position(|other| other.drive.drives(ancestor)) {
                return Some(k);
            }
            at = self.parents.get(ancestor).copied().flatten();
        }
        None
    }

    /// Number of joints.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.names.len()
    }

    /// Joint names, Anny's.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Parents; every one comes before its children.
    #[must_use]
    pub fn parents(&self) -> &[Option<usize>] {
        &self.parents
    }

    /// Index of a joint by Anny's name.
    #[must_use]
    pub fn index(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }

    /// The joint that stands for each garment joint: the one that all others fold into.
    #[must_use]
    pub fn garment_joints(&self) -> &[usize] {
        &self.garment_joints
    }

    /// Parent of each garment joint among the garment joints.
    #[must_use]
    pub fn garment_parents(&self) -> &[Option<usize>] {
        &self.garment_parents
    }

    /// Humanoid joints with their humanoid parents; parents come first.
    pub fn humanoid_joints(&self) -> impl Iterator<Item = (&str, Option<&str>)> {
        let parent = |joint: &HumanoidJoint| joint.parent.and_then(|p| self.humanoid.get(p));
        self.humanoid.iter().map(move |joint| (joint.name.as_str(), parent(joint).map(|p| p.name.as_str())))
    }

    /// Gives a humanoid joint's unit quaternion to the joints it drives; `false` when there is none.
    #[must_use]
    pub fn set_humanoid(&self, rotations: &mut [Quat], name: &str, q: Quat) -> bool {
        let Some(joint) = self.humanoid.iter().find(|joint| joint.name == name) else { return false };
        let parts = match joint.drive {
            Drive::Whole(only) => [(only, q), (only, q)],
            Drive::Halves([first, second]) => [(first, half(q)), (second, half(q))],
            Drive::SwingTwist([first, second], axis) => {
                let (swing, twist) = swing_twist(q, axis);
                [(first, swing * half(twist)), (second, half(twist))]
            }
        };
        for (index, part) in parts {
            if let Some(slot) = rotations.get_mut(index) {
                *slot = part;
            }
        }
        true
    }

    /// World-from-joint transforms of a pose, for joints (A-pose, metres) of a body shape.
    #[must_use]
    pub fn world_joints(&self, joints: &[Vec3], pose: &Pose) -> Vec<Affine3A> {
        let mut out: Vec<Affine3A> = Vec::with_capacity(self.parents.len());
        for ((&parent, &joint), &rotation) in self.parents.iter().zip(joints).zip(&pose.rotations) {
            let world = match parent.and_then(|p| Some((out.get(p)?, joints.get(p)?))) {
                Some((world, &at)) => *world * Affine3A::from_rotation_translation(rotation, joint - at),
                None => Affine3A::from_rotation_translation(rotation, joint + pose.root_translation),
            };
            out.push(world);
        }
        out
    }

    /// World-from-A-pose transforms of the garment skeleton.
    #[must_use]
    pub fn garment_transforms(&self, joints: &[Vec3], world: &[Affine3A]) -> Vec<Affine3A> {
        let transform = |&j: &usize| {
            let (world, joint) = (*world.get(j)?, *joints.get(j)?);
            let translation = world.translation - world.matrix3 * Vec3A::from(joint);
            Some(Affine3A { matrix3: world.matrix3, translation })
        };
        self.garment_joints.iter().map(|j| transform(j).unwrap_or(Affine3A::IDENTITY)).collect()
    }
}

/// The rotation half way from the identity to `q`, the short way round.
fn half(q: Quat) -> Quat {
    let q = if q.w < 0.0 { -q } else { q };
    Quat::from_xyzw(q.x, q.y, q.z, q.w + 1.0).normalize()
}

/// `q` = swing × twist, the twist about the unit `axis`; no twist where it is not defined.
fn swing_twist(q: Quat, axis: Vec3) -> (Quat, Quat) {
    let along = axis * q.xyz().dot(axis);
    let twist = Quat::from_xyzw(along.x, along.y, along.z, q.w);
    if twist.length_squared() < 1e-12 {
        return (q, Quat::IDENTITY);
    }
    let twist = twist.normalize();
    (q * twist.conjugate(), twist)
}
