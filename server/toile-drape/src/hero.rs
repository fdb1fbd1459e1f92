//! Garments with a pixel-cloth network of their own, and how their pixels lie on the body (Jin et al. 2020, section 5).
//!
//! Sites are the vertices of a garment's panels in pattern space; a vertex on a seam is a site of each panel. The same
//! tables are made in `model/garment/local_frames.py` and `model/garment/cloth_image.py`; `model/export_pixel.py` writes them.

use std::collections::HashMap;

use glam::{Affine3A, Mat3, Vec3};
use safetensors::tensor::{Dtype, SafeTensors};

use crate::error::DrapeError;
use crate::outfit::{Garment, Outfit};

/// Joints of a pose, and numbers that the network sees of it: rotation matrices.
const JOINTS: usize = 10;
/// Numbers of a pose.
pub const POSE: usize = 9 * JOINTS;
/// m within which a garment's vertices must lie at those that the network was trained on.
const SAME: f32 = 2e-3;

/// A garment that a network was trained on.
#[derive(Debug)]
pub struct Hero {
    /// Name of the network's graph.
    pub graph: String,
    /// Pixels of an image's side.
    pub side: usize,
    /// Images, one a panel.
    pub images: usize,
    /// Pixels on the cloth or its padding, images one after the other, row by row.
    pub mask: Vec<bool>,
    rest: Vec<Vec3>,
    /// The joints whose turns the network sees, each against another one or the world.
    joints: Vec<(Option<usize>, usize)>,
    sites: Vec<Site>,
}

#[derive(Debug)]
struct Site {
    vertex: usize,
    share: f32,
    corner: [usize; 3],
    corner_weight: [f32; 3],
    /// Sites around it; their places times these weights point along the pattern's u.
    along: Vec<(usize, f32)>,
    pixel: [usize; 4],
    pixel_weight: [f32; 4],
}

impl Hero {
    /// Reads the tables of `name` and checks that nothing points outside of them or of a body of `vertices`.
    ///
    /// # Errors
    /// When the file is not such tables.
    pub fn from_safetensors(name: &str, bytes: &[u8], vertices: usize) -> Result<Self, DrapeError> {
        let file = Tables(SafeTensors::deserialize(bytes).map_err(|e| DrapeError::Stored(e.to_string()))?);
        let rest: Vec<Vec3> = file.floats::<3>("rest")?.into_iter().map(Vec3::from_array).collect();
        let (images, side, mask) = file.mask()?;
        let vertex = file.indices("vertex", rest.len())?;
        let (corner, around) = (file.indices("corner", vertices)?, file.indices("around", vertex.len())?);
        let (share, along) = (file.floats::<1>("share")?, file.floats::<1>("along")?);
        let pixel = file.indices("pixel", mask.len())?;
        let (corner_weight, pixel_weight) =
            (file.floats::<3>("corner_weight")?, file.floats::<4>("pixel_weight")?);
        let count = vertex.len();
        let wide = along.len() / count.max(1);
        let even = [corner.len() / 3, pixel.len() / 4, share.len(), corner_weight.len(), pixel_weight.len()];
        if count == 0
            || wide == 0
            || along.len() != wide * count
            || around.len() != along.len()
            || even != [count; 5]
        {
            return Err(DrapeError::Stored(format!("the tables of {name} do not fit each other")));
        }
        let (corner, pixel) = (corner.as_chunks::<3>().0, pixel.as_chunks::<4>().0);
        let mut sites = Vec::with_capacity(count);
        let rows = around.chunks_exact(wide).zip(along.chunks_exact(wide));
        for (k, (around, along)) in rows.enumerate() {
            sites.push(Site {
                vertex: vertex[k],
                share: share[k][0],
                corner: corner[k],
                corner_weight: corner_weight[k],
                along: around
                    .iter()
                    .copied()
                    .zip(along.iter().map(|w| w[0]))
                    .filter(|(_, w)| *w != 0.0)
                    .collect(),
                pixel: pixel[k],
                pixel_weight: pixel_weight[k],
            });
        }
        Ok(Self {
            graph: format!("pixel_cloth/{name}"),
            side,
            images,
            mask,
            rest,
            joints: file.joints()?,
            sites,
        })
    }

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

    /// The garment's vertices, world, m, from what `images` (3 a panel, `side` square) say at its sites, on a body's
    /// vertices and normals.
    #[must_use]
    pub fn cloth(&self, images: &[f32], body: (&[Vec3], &[Vec3])) -> Vec<Vec3> {
        let (vertices, normals) = body;
        let mixed = |of: &[Vec3], site: &Site| -> Vec3 {
            let parts = site.corner.iter().zip(site.corner_weight);
            parts.map(|(&corner, weight)| of.get(corner).copied().unwrap_or_default() * weight).sum()
        };
        let places: Vec<Vec3> = self.sites.iter().map(|site| mixed(vertices, site)).collect();
        let mut out = vec![Vec3::ZERO; self.rest.len()];
        for (site, place) in self.sites.iter().zip(&places) {
            let normal = mixed(normals, site).normalize_or_zero();
            let along: Vec3 = site.along.iter().map(|&(other, weight)| places[other] * weight).sum();
            let u = (along - normal * along.dot(normal)).normalize_or_zero();
            let offset = self.offset(images, site);
            let world = *place + u * offset.x + normal.cross(u) * offset.y + normal * offset.z;
            out[site.vertex] += world * site.share;
        }
        out
    }

    fn offset(&self, images: &[f32], site: &Site) -> Vec3 {
        let plane = self.side * self.side;
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
        let cell = |p: Vec3| (p / (4.0 * SAME)).floor().as_ivec3();
        let mut cells: HashMap<glam::IVec3, Vec<usize>> = HashMap::new();
        self.rest.iter().enumerate().for_each(|(v, p)| cells.entry(cell(*p)).or_default().push(v));
        let nearest = |p: &Vec3| {
            let (low, high) = (cell(*p - SAME), cell(*p + SAME));
            let near = (low.x..=high.x).flat_map(|x| (low.y..=high.y).map(move |y| (x, y)));
            let near = near.flat_map(|(x, y)| (low.z..=high.z).map(move |z| glam::IVec3::new(x, y, z)));
            let found = near.filter_map(|c| cells.get(&c)).flatten();
            let found = found.map(|&v| (v, self.rest[v].distance(*p))).min_by(|a, b| a.1.total_cmp(&b.1));
            found.filter(|(_, away)| *away < SAME).map(|(v, _)| v)
        };
        positions.iter().map(nearest).collect()
    }
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
pub fn worn<'a>(heroes: &'a [Hero], outfit: &Outfit) -> Result<Vec<Worn<'a>>, DrapeError> {
    let of_garment = |garment: &Garment| {
        let positions = positions(outfit, garment);
        let found = heroes.iter().find_map(|hero| Some(Worn { hero, vertex: hero.fit(positions)? }));
        found.ok_or_else(|| DrapeError::NoHero { garment: garment.name.clone() })
    };
    outfit.garments.iter().map(of_garment).collect()
}

/// Whether there is a network of each garment of an outfit.
#[must_use]
pub fn known(heroes: &[Hero], outfit: &Outfit) -> Vec<bool> {
    let of_garment =
        |garment: &Garment| heroes.iter().any(|hero| hero.fit(positions(outfit, garment)).is_some());
    outfit.garments.iter().map(of_garment).collect()
}

fn positions<'o>(outfit: &'o Outfit, garment: &Garment) -> &'o [Vec3] {
    let range = garment.vertices.start as usize..garment.vertices.end as usize;
    outfit.positions.get(range).unwrap_or_default()
}

struct Tables<'a>(SafeTensors<'a>);

impl Tables<'_> {
    fn data(&self, name: &str, dtype: Dtype) -> Result<(Vec<usize>, &[u8]), DrapeError> {
        let tensor = self.0.tensor(name).map_err(|e| DrapeError::Stored(format!("{name}: {e}")))?;
        if tensor.dtype() != dtype {
            return Err(DrapeError::Stored(format!("{name} is {:?}, not {dtype:?}", tensor.dtype())));
        }
        let bytes = self.0.tensor(name).map(|t| t.data()).map_err(|e| DrapeError::Stored(e.to_string()))?;
        Ok((tensor.shape().to_vec(), bytes))
    }

    fn floats<const N: usize>(&self, name: &str) -> Result<Vec<[f32; N]>, DrapeError> {
        let (_, bytes) = self.data(name, Dtype::F32)?;
        let values: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        if !values.len().is_multiple_of(N) || values.iter().any(|v| !v.is_finite()) {
            return Err(DrapeError::Stored(format!("{name} does not hold rows of {N} finite numbers")));
        }
        Ok(values.as_chunks::<N>().0.to_vec())
    }

    fn integers(&self, name: &str) -> Result<Vec<i32>, DrapeError> {
        let (_, bytes) = self.data(name, Dtype::I32)?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|b| i32::from_le_bytes(*b)).collect())
    }

    fn indices(&self, name: &str, limit: usize) -> Result<Vec<usize>, DrapeError> {
        let outside = || DrapeError::Stored(format!("{name} points outside of its table"));
        let inside = |i: i32| usize::try_from(i).ok().filter(|i| *i < limit).ok_or_else(outside);
        self.integers(name)?.into_iter().map(inside).collect()
    }

    fn joints(&self) -> Result<Vec<(Option<usize>, usize)>, DrapeError> {
        let pairs = self.integers("joints")?;
        let (pairs, rest) = pairs.as_chunks::<2>();
        let joint = |i: i32| usize::try_from(i).ok();
        let known = pairs.iter().map(|[of, to]| Some((joint(*of), joint(*to)?))).collect::<Option<Vec<_>>>();
        match known.filter(|pairs| rest.is_empty() && pairs.len() == JOINTS) {
            Some(pairs) => Ok(pairs),
            None => Err(DrapeError::Stored(format!("joints are not {JOINTS} pairs"))),
        }
    }

    /// Images, pixels of their side, and the mask.
    fn mask(&self) -> Result<(usize, usize, Vec<bool>), DrapeError> {
        let (shape, bytes) = self.data("mask", Dtype::U8)?;
        match *shape.as_slice() {
            [images, side, across] if side == across && images > 0 && side > 0 => {
                Ok((images, side, bytes.iter().map(|b| *b != 0).collect()))
            }
            _ => Err(DrapeError::Stored("mask is not (images, side, side)".to_owned())),
        }
    }
}
