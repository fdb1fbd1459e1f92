//! Garments with a pixel-cloth network of their own, and how their pixels lie on the body (Jin et al. 2020, section 5).
//!
//! Sites are the vertices of a garment's panels in pattern space; a vertex on a seam is a site of each panel. The same
//! tables are made in `model/garment/local_frames.py` and `model/garment/cloth_image.py`; `model/export_pixel.py` writes them.

mod decoder;
mod tables;

use std::collections::HashMap;

use glam::{Affine3A, IVec3, Mat3, Vec3};

use crate::error::DrapeError;
use crate::network::Networks;
use crate::outfit::{Garment, Outfit};
use decoder::Decoder;

pub use decoder::SIDE;

/// m within which a garment's vertices must lie at those that the network was trained on.
const SAME: f32 = 2e-3;

/// A garment that a network was trained on.
#[derive(Debug)]
pub struct Hero {
    /// Pixels on the cloth or its padding, images (one a panel, [`SIDE`] square) one after the other, row by row.
    pub mask: Vec<bool>,
    /// Whether the network saw legs move.
    pub sees_legs: bool,
    decoder: Decoder,
    rest: Vec<Vec3>,
    /// Its vertices by the cell of space that they lie in.
    cells: HashMap<IVec3, Vec<usize>>,
    /// The joints whose turns the network sees, each against another one or the world.
    joints: Vec<(Option<usize>, usize)>,
    sites: Vec<Site>,
    filter: Filter,
}

/// Offsets of training's drapes by their principal components, the largest first (section 8.3): what a network says
/// beyond them is noise.
#[derive(Debug)]
struct Filter {
    /// One a site, m.
    mean: Vec<Vec3>,
    /// Components one after the other, one vector a site each, orthonormal.
    components: Vec<Vec3>,
}

impl Filter {
    fn apply(&self, offsets: &mut [Vec3]) {
        offsets.iter_mut().zip(&self.mean).for_each(|(o, mean)| *o -= *mean);
        let mut out = self.mean.clone();
        for component in self.components.chunks_exact(self.mean.len().max(1)) {
            let amount: f32 = component.iter().zip(offsets.iter()).map(|(c, o)| c.dot(*o)).sum();
            out.iter_mut().zip(component).for_each(|(o, c)| *o += *c * amount);
        }
        offsets.copy_from_slice(&out);
    }
}

#[derive(Debug)]
struct Site {
    vertex: usize,
    share: f32,
    /// Vertices of the body that hold it, and their shares of it.
    corners: Vec<(usize, f32)>,
    /// Sites around it; their places times these weights point along the pattern's u.
    along: Vec<(usize, f32)>,
    pixel: [usize; 4],
    pixel_weight: [f32; 4],
}

impl Hero {
    /// What the network sees of a pose: rotation matrices, row by row. Which way the body faces is left out.
    #[must_use]
    pub fn pose(&self, transforms: &[Affine3A]) -> Vec<f32> {
        let turn = |joint: usize| transforms.get(joint).map_or(Mat3::IDENTITY, |t| t.matrix3.into());
        let row_major = |(of, to): &(Option<usize>, usize)| {
            let turn = of.map_or_else(|| upright(turn(*to)), |of| turn(of).transpose() * turn(*to));
            turn.transpose().to_cols_array()
        };
        self.joints.iter().flat_map(row_major).collect()
    }

    /// What the network says of a pose: offsets along the pattern's u and v and off the skin, m, (panels, 3, SIDE, SIDE).
    ///
    /// # Errors
    /// When the network fails.
    pub fn images(&self, pose: &[f32], networks: &mut dyn Networks) -> Result<Vec<f32>, DrapeError> {
        self.decoder.images(pose, networks)
    }

    /// The garment's vertices, world, m, from what `images` (3 a panel, [`SIDE`] square) say at its sites, on a body's
    /// vertices and normals.
    #[must_use]
    pub fn cloth(&self, images: &[f32], body: (&[Vec3], &[Vec3])) -> Vec<Vec3> {
        let (vertices, normals) = body;
        let mixed = |of: &[Vec3], site: &Site| -> Vec3 {
            let part =
                |&(corner, weight): &(usize, f32)| of.get(corner).copied().unwrap_or_default() * weight;
            site.corners.iter().map(part).sum()
        };
        let places: Vec<Vec3> = self.sites.iter().map(|site| mixed(vertices, site)).collect();
        let mut offsets: Vec<Vec3> = self.sites.iter().map(|site| self.offset(images, site)).collect();
        self.filter.apply(&mut offsets);
        let mut out = vec![Vec3::ZERO; self.rest.len()];
        for ((site, place), offset) in self.sites.iter().zip(&places).zip(offsets) {
            let normal = mixed(normals, site).normalize_or_zero();
            let along: Vec3 = site.along.iter().map(|&(other, weight)| places[other] * weight).sum();
            let u = (along - normal * along.dot(normal)).normalize_or_zero();
            let world = *place + u * offset.x + normal.cross(u) * offset.y + normal * offset.z;
            out[site.vertex] += world * site.share;
        }
        out
    }

    /// Bytes in memory.
    #[must_use]
    pub fn byte_size(&self) -> usize {
        let points = self.rest.len() + self.filter.mean.len() + self.filter.components.len();
        let lists = |site: &Site| size_of_val(site.along.as_slice()) + size_of_val(site.corners.as_slice());
        let around: usize = self.sites.iter().map(|site| size_of::<Site>() + lists(site)).sum();
        points * size_of::<Vec3>() + around + self.mask.len() + self.decoder.byte_size()
    }

    fn offset(&self, images: &[f32], site: &Site) -> Vec3 {
        let plane = SIDE * SIDE;
        let read = |channel: usize| -> f32 {
            let pixels = site.pixel.iter().zip(site.pixel_weight);
            // Pixels count through the images; channels of an image lie one after the other.
            let at = |pixel: usize| (3 * (pixel / plane) + channel) * plane + pixel % plane;
            pixels.map(|(&pixel, weight)| images.get(at(pixel)).copied().unwrap_or_default() * weight).sum()
        };
        Vec3::new(read(0), read(1), read(2))
    }

    /// Which of its vertices each of `positions` is, where all of them are at one.
    fn fit(&self, positions: &[Vec3]) -> Option<Vec<usize>> {
        if positions.len() != self.rest.len() {
            return None;
        }
        let nearest = |p: &Vec3| {
            let (low, high) = (cell(*p - SAME), cell(*p + SAME));
            let near = (low.x..=high.x).flat_map(|x| (low.y..=high.y).map(move |y| (x, y)));
            let near = near.flat_map(|(x, y)| (low.z..=high.z).map(move |z| IVec3::new(x, y, z)));
            let found = near.filter_map(|c| self.cells.get(&c)).flatten();
            let found = found.map(|&v| (v, self.rest[v].distance(*p))).min_by(|a, b| a.1.total_cmp(&b.1));
            found.filter(|(_, away)| *away < SAME).map(|(v, _)| v)
        };
        positions.iter().map(nearest).collect()
    }
}

fn cell(p: Vec3) -> IVec3 {
    (p / (4.0 * SAME)).floor().as_ivec3()
}

fn by_cell(points: &[Vec3]) -> HashMap<IVec3, Vec<usize>> {
    let mut cells: HashMap<IVec3, Vec<usize>> = HashMap::new();
    points.iter().enumerate().for_each(|(v, p)| cells.entry(cell(*p)).or_default().push(v));
    cells
}

/// Rotation of the pelvis, turned about the vertical so that it faces +z.
fn upright(turn: Mat3) -> Mat3 {
    let ahead = turn.z_axis;
    let length = ahead.x.hypot(ahead.z).max(1e-6);
    let (sin, cos) = (ahead.x / length, ahead.z / length);
    Mat3::from_cols(Vec3::new(cos, 0.0, sin), Vec3::Y, Vec3::new(-sin, 0.0, cos)) * turn
}

/// A garment of an outfit with its network, and which vertex of the network's garment each of its vertices is.
#[derive(Debug)]
pub struct Worn<'a> {
    /// What it is.
    pub hero: &'a Hero,
    /// One a vertex of the garment.
    pub vertex: Vec<usize>,
}

/// The network's garment that every garment of an outfit is.
///
/// # Errors
/// When a garment is none of them.
pub fn worn<'a>(heroes: &[&'a Hero], outfit: &Outfit) -> Result<Vec<Worn<'a>>, DrapeError> {
    let of_garment = |garment: &Garment| {
        let positions = positions(outfit, garment);
        let found = heroes.iter().find_map(|&hero| Some(Worn { hero, vertex: hero.fit(positions)? }));
        found.ok_or_else(|| DrapeError::NoHero { garment: garment.name.clone() })
    };
    outfit.garments.iter().map(of_garment).collect()
}

/// Whether there is a network of each garment of an outfit.
#[must_use]
pub fn known(heroes: &[&Hero], outfit: &Outfit) -> Vec<bool> {
    let of_garment =
        |garment: &Garment| heroes.iter().any(|hero| hero.fit(positions(outfit, garment)).is_some());
    outfit.garments.iter().map(of_garment).collect()
}

fn positions<'o>(outfit: &'o Outfit, garment: &Garment) -> &'o [Vec3] {
    let range = garment.vertices.start as usize..garment.vertices.end as usize;
    outfit.positions.get(range).unwrap_or_default()
}
