//! The parametric body that is nearest to a scan: a mesh of a person of any topology, standing about in the A-pose,
//! whichever way it faces.
//!
//! Points of the body are drawn to the planes of the nearest scan points that face the same way (Chen and Medioni 1992),
//! by damped Gauss-Newton steps over shape, place and the lift of arms and legs. What the scan leaves open stays
//! average. Metres, glTF axes.

mod detail;
mod surface;
mod unknowns;

use std::ops::Range;

use glam::Vec3;
use thiserror::Error;

use self::surface::Surface;
use self::unknowns::{COUNT, PLACE, Unknowns};
use crate::body::{Body, BodyShape, ShapedBody};
use crate::measurements::cholesky;
use crate::mesh::Mesh;
use crate::normals::vertex_normals;
use crate::pose::Pose;

/// Heights of people, metres.
const HEIGHTS: std::ops::RangeInclusive<f32> = 1.0..=2.4;
/// Widest mesh that is looked at, metres.
const WIDEST: f32 = 20.0;
/// Fewest vertices of a scan.
const FEWEST: usize = 500;
/// Steps, and how far from the body scan points are believed at the first and at the last one, metres.
const STEPS: usize = 16;
const REACH: (f32, f32) = (0.20, 0.03);
/// The step that the second search begins with: a kink in the way has kept the first from the better side at times.
const SECOND: usize = 9;
/// Steps of place and limbs alone, for each of the four ways that a scan may face.
const PLACING: usize = 5;
/// Of every so many body vertices one is compared.
const STRIDE: usize = 4;
/// Mean distance and share of the body without a counterpart beyond which a scan is no body, metres and percent.
const FARTHEST: f32 = 0.025;
const MOST_UNSEEN: f32 = 40.0;
/// Step of the difference quotients.
const DIFFERENCE: f32 = 1e-2;

/// The body of a scan.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanFit {
    /// Its shape.
    pub shape: BodyShape,
    /// Offsets of its rest vertices that put its surface on the scan, metres ([`crate::body::Detail`]).
    pub offsets: Vec<Vec3>,
    /// Mean distance of the body from the scan where the scan has a counterpart, metres.
    pub distance: f32,
    /// Share of the body for which the scan has no counterpart within 3 cm, percent.
    pub unseen_percent: f32,
}

/// Why a mesh is no scan of a body. Every message says what to do about it.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ScanError {
    /// Too small a mesh.
    #[error("the mesh has {found} vertices; a scan of a body has {FEWEST} at the least")]
    TooCoarse {
        /// Vertices found.
        found: usize,
    },
    /// Nothing with an area.
    #[error("the mesh has no triangles with an area")]
    NoTriangles,
    /// The size fits no person.
    #[error(
        "the mesh is {height:.2} m high; state its `units` (m, cm, mm or in) and the `up` axis, or crop it to the person"
    )]
    Height {
        /// Its height, metres.
        height: f32,
    },
    /// Nothing like a person in the A-pose.
    #[error(
        "the mesh is no person in the A-pose: the nearest body is {:.0} mm off and {unseen_percent:.0} % of it have no counterpart; GET /v1/body/reference.glb shows the pose",
        1e3 * distance
    )]
    NotABody {
        /// Mean distance of what was matched, metres.
        distance: f32,
        /// Share of the body without a counterpart, percent.
        unseen_percent: f32,
    },
}

/// The body nearest to a scan, in two or three seconds.
///
/// # Errors
/// [`ScanError`] where the mesh is no scan of a person.
pub fn fit(body: &Body, scan: &Mesh) -> Result<ScanFit, ScanError> {
    if scan.positions.len() < FEWEST {
        return Err(ScanError::TooCoarse { found: scan.positions.len() });
    }
    let height = height(scan).ok_or(ScanError::NoTriangles)?;
    if !HEIGHTS.contains(&height) {
        return Err(ScanError::Height { height });
    }
    let surface = Surface::new(scan).ok_or(ScanError::NoTriangles)?;
    let compared = Compared::new(body);
    let facing = (0..4).filter_map(|quarters| Some(compared.placed(surface.turned(quarters)?, height)));
    let nearest = facing.min_by(|(a, ..), (b, ..)| a.total_cmp(b)).ok_or(ScanError::NoTriangles)?;
    let (_, surface, unknowns) = nearest;
    let first = compared.settled(unknowns, &surface, 0);
    let second = compared.settled(first.across(), &surface, SECOND);
    let nearer = match [first, second].map(|found| compared.judged(found, &surface)) {
        [Ok(one), Ok(other)] if other.distance < one.distance => other,
        [Err(_), Ok(other)] => other,
        [one, _] => one?,
    };
    let Judged { unknowns, distance, unseen_percent } = nearer;
    let offsets = detail::offsets(body, &unknowns, &surface);
    Ok(ScanFit { shape: unknowns.shape(), offsets, distance, unseen_percent })
}

/// Height of the triangles, metres, infinite where they are wider than any room; none without triangles.
fn height(scan: &Mesh) -> Option<f32> {
    let corners = || scan.triangles.iter().flatten().filter_map(|&i| scan.positions.get(i as usize)).copied();
    let (low, high) = (corners().reduce(Vec3::min)?, corners().reduce(Vec3::max)?);
    Some(if (high - low).max_element() < WIDEST { high.y - low.y } else { f32::INFINITY })
}

/// The vertices of the body that are compared with a scan.
struct Compared<'a> {
    body: &'a Body,
    vertices: Vec<u32>,
    /// Share of the body's area around each of them.
    area: Vec<f32>,
}

/// What a step may move.
struct Freedom {
    of: Range<usize>,
    /// How early the step is, 1 at the start to 0 at the end.
    early: f32,
}

/// A body that is near enough to a scan, as of [`ScanFit`].
struct Judged {
    unknowns: Unknowns,
    distance: f32,
    unseen_percent: f32,
}

/// Where they are.
struct Posed {
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    shaped: ShapedBody,
}

impl<'a> Compared<'a> {
    fn new(body: &'a Body) -> Self {
        let shaped = body.shape(&BodyShape::default());
        let vertices: Vec<u32> = (0..body.vertex_count() as u32).step_by(STRIDE).collect();
        let mut around = vec![0.0_f32; body.vertex_count()];
        for &triangle in body.triangles() {
            let [a, b, c] = triangle.map(|i| shaped.apose_vertices[i as usize]);
            let third = (b - a).cross(c - a).length() / 6.0;
            triangle.iter().for_each(|&i| around[i as usize] += third);
        }
        let chosen: Vec<f32> = vertices.iter().map(|&v| around[v as usize]).collect();
        let total: f32 = chosen.iter().sum();
        Self { body, vertices, area: chosen.iter().map(|a| a / total).collect() }
    }

    /// A body of the scan's height where the scan stands: how far it is off, area by area, and both.
    fn placed(&self, surface: Surface, height: f32) -> (f32, Surface, Unknowns) {
        let (low, high) = surface.bounds();
        let mut unknowns = Unknowns::standing(self.body, height, low, high);
        let first = self.posed(&unknowns);
        let surface = surface.turned_like(&first.points, &first.normals);
        let freedom = Freedom { of: PLACE..COUNT, early: 1.0 };
        for _ in 0..PLACING {
            self.step(&mut unknowns, &surface, REACH.0, &freedom);
        }
        let here = self.posed(&unknowns);
        let off = here.points.iter().zip(&here.normals).zip(&self.area).map(|((point, normal), area)| {
            let found = surface.facing(*point, *normal);
            area * found.map_or(REACH.0, |(target, _)| point.distance(target).min(REACH.0))
        });
        (off.sum(), surface, unknowns)
    }

    /// After the steps of a search from `begin` on.
    fn settled(&self, mut unknowns: Unknowns, surface: &Surface, begin: usize) -> Unknowns {
        for step in begin..STEPS {
            let share = step as f32 / (STEPS - 1) as f32;
            let reach = REACH.0 * (REACH.1 / REACH.0).powf(share);
            self.step(&mut unknowns, surface, reach, &Freedom { of: 0..COUNT, early: 1.0 - share });
        }
        unknowns
    }

    fn points(&self, shaped: &ShapedBody, pose: &Pose) -> Vec<Vec3> {
        self.body.posed_subset(shaped, &self.body.world_joints(shaped, pose), &self.vertices)
    }

    fn posed(&self, unknowns: &Unknowns) -> Posed {
        let shaped = self.body.shape(&unknowns.shape());
        let world = self.body.world_joints(&shaped, &unknowns.pose(self.body));
        let all = self.body.posed_vertices(&shaped, &world);
        let normals = vertex_normals(&all, self.body.triangles());
        let pick = |from: &[Vec3]| self.vertices.iter().map(|&v| from[v as usize]).collect();
        Posed { points: pick(&all), normals: pick(&normals), shaped }
    }

    /// How the points move with each unknown that is free.
    fn slopes(&self, unknowns: &Unknowns, here: &Posed, free: &Range<usize>) -> Vec<Vec<Vec3>> {
        let slope = |k: usize| {
            if !free.contains(&k) {
                return vec![Vec3::ZERO; here.points.len()];
            }
            let moved = unknowns.moved(k, DIFFERENCE);
            let points = match k < PLACE {
                true => self.points(&self.body.shape(&moved.shape()), &moved.pose(self.body)),
                false => self.points(&here.shaped, &moved.pose(self.body)),
            };
            points.iter().zip(&here.points).map(|(a, b)| (*a - *b) / DIFFERENCE).collect()
        };
        (0..COUNT).map(slope).collect()
    }

    /// One damped Gauss-Newton step of the unknowns that are free, towards scan points within `reach` metres.
    fn step(&self, unknowns: &mut Unknowns, surface: &Surface, reach: f32, freedom: &Freedom) {
        let here = self.posed(unknowns);
        let rows: Vec<(usize, Vec3, f64, f64)> = (0..here.points.len())
            .filter_map(|i| {
                let (target, normal) = surface.facing(here.points[i], here.normals[i])?;
                let way = here.points[i] - target;
                let trust = self.area[i] / (1.0 + (way.length() / reach).powi(2));
                (way.length() < reach).then(|| (i, normal, f64::from(way.dot(normal)), f64::from(trust)))
            })
            .collect();
        let columns = self.slopes(unknowns, &here, &freedom.of);
        let (mut matrix, mut right) = unknowns.pull(freedom.early);
        for &(i, normal, lack, trust) in &rows {
            let slope: Vec<f64> = columns.iter().map(|c| f64::from(c[i].dot(normal))).collect();
            for (k, s) in slope.iter().enumerate() {
                right[k] -= trust * s * lack;
                matrix[k].iter_mut().zip(&slope).for_each(|(m, t)| *m += trust * s * t);
            }
        }
        if let Some(change) = cholesky::solve(matrix, right) {
            unknowns.change(&change);
        }
    }

    fn judged(&self, unknowns: Unknowns, surface: &Surface) -> Result<Judged, ScanError> {
        let here = self.posed(&unknowns);
        let (mut distance, mut seen) = (0.0, 0.0);
        for ((point, normal), area) in here.points.iter().zip(&here.normals).zip(&self.area) {
            if let Some((target, facing)) = surface.facing(*point, *normal)
                && point.distance(target) < REACH.1
            {
                distance += area * (*point - target).dot(facing).abs();
                seen += area;
            }
        }
        let (distance, unseen_percent) = (distance / f32::max(seen, 1e-6), 100.0 * (1.0 - seen));
        if distance > FARTHEST || unseen_percent > MOST_UNSEEN {
            return Err(ScanError::NotABody { distance, unseen_percent });
        }
        Ok(Judged { unknowns, distance, unseen_percent })
    }
}
