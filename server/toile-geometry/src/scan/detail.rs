//! What a scan knows beyond the parameters: the body's surface drawn onto it, smoothly.

use glam::{Mat3, Vec3};

use super::surface::Surface;
use super::unknowns::Unknowns;
use crate::body::{Body, ShapedBody};
use crate::mesh::Adjacency;
use crate::normals::vertex_normals;

/// How strongly neighbours move alike, beside a vertex's own wish: round by round less.
const STIFFNESS: [f32; 5] = [16.0, 8.0, 4.0, 2.0, 1.0];
/// Averagings of a round.
const SMOOTHINGS: usize = 40;
/// How far from the body scan points are believed, metres.
const REACH: f32 = 0.06;
/// Longest offset, metres.
const LONGEST: f32 = 0.10;
/// Joints whose skin keeps its shape: hair and hands are no matter of clothes, and seldom scanned well.
const KEPT: [&str; 3] = ["head", "wrist.L", "wrist.R"];

/// Offsets of the rest vertices, metres, that put the fitted body's surface on the scan.
pub(super) fn offsets(body: &Body, unknowns: &Unknowns, surface: &Surface) -> Vec<Vec3> {
    let shaped = body.shape(&unknowns.shape());
    let world = body.world_joints(&shaped, &unknowns.pose(body));
    let posed = body.posed_vertices(&shaped, &world);
    let free = free(body);
    let ring = Adjacency::new(posed.len(), body.triangles());
    let mut moved = vec![Vec3::ZERO; posed.len()];
    for stiffness in STIFFNESS {
        let here: Vec<Vec3> = posed.iter().zip(&moved).map(|(p, d)| *p + *d).collect();
        let normals = vertex_normals(&here, body.triangles());
        let wish = |v: usize| {
            let (target, normal) = surface.facing(here[v], normals[v]).filter(|_| free[v])?;
            let way = target - here[v];
            (way.length() < REACH).then(|| moved[v] + normal * way.dot(normal))
        };
        let wishes: Vec<Option<Vec3>> = (0..posed.len()).map(wish).collect();
        moved = smoothed(moved, &wishes, &free, &ring, stiffness);
    }
    let turns = turns(body, &shaped, &world, &posed);
    moved.iter().zip(turns).map(|(d, turn)| (turn.inverse() * *d).clamp_length_max(LONGEST)).collect()
}

/// Vertices that may move.
fn free(body: &Body) -> Vec<bool> {
    let names = body.skeleton().garment_joints().iter().map(|&j| body.joint_names()[j].as_str());
    let kept: Vec<bool> = names.map(|name| KEPT.contains(&name)).collect();
    let share = |v: usize| {
        let (joints, weights) = body.garment_skin().row(v);
        let of_kept = joints.iter().zip(weights).filter(|(j, _)| kept[usize::from(**j)]);
        of_kept.map(|(_, w)| *w).sum::<f32>()
    };
    (0..body.vertex_count()).map(|v| share(v) < 0.5).collect()
}

/// Each free vertex between its wish and the mean of its neighbours.
fn smoothed(
    mut moved: Vec<Vec3>,
    wishes: &[Option<Vec3>],
    free: &[bool],
    ring: &Adjacency,
    stiffness: f32,
) -> Vec<Vec3> {
    for _ in 0..SMOOTHINGS {
        let next = |v: usize| {
            let around = ring.of(v);
            if !free[v] || around.is_empty() {
                return Vec3::ZERO;
            }
            let mean = around.iter().map(|&w| moved[w as usize]).sum::<Vec3>() / around.len() as f32;
            wishes[v].map_or(mean, |wish| (wish + mean * stiffness) / (1.0 + stiffness))
        };
        moved = (0..moved.len()).map(next).collect();
    }
    moved
}

/// The linear part of every vertex's skinning from rest to the pose.
fn turns(
    body: &Body,
    shaped: &ShapedBody,
    world: &[glam::Affine3A],
    posed: &[Vec3],
) -> impl Iterator<Item = Mat3> + use<> {
    let along = |axis: Vec3| {
        let mut shifted = shaped.clone();
        shifted.rest_vertices.iter_mut().for_each(|p| *p += axis);
        let moved = body.posed_vertices(&shifted, world);
        moved.iter().zip(posed).map(|(a, b)| *a - *b).collect::<Vec<Vec3>>()
    };
    let [x, y, z] = Vec3::AXES.map(along);
    x.into_iter().zip(y).zip(z).map(|((x, y), z)| Mat3::from_cols(x, y, z))
}
