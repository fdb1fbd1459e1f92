//! From the fine drape's normals to a picture in the tangent frames of the coarse mesh.

use glam::{Mat3, Vec3};

use super::packing::{Box2, GUTTER};
use super::patch::{Patch, pick};
use super::texels::each_texel;
use super::{CoarseOutfit, Shading, Source};

/// Texels beyond the coarse mesh's edges that are filled, so that filtering does not bring in what is not cloth.
const RIM: usize = 4;
/// Least part of a unit normal that points off the coarse surface.
const LEAST_OUT: f32 = 0.05;
/// No normal at all.
const FLAT: [u8; 3] = [128, 128, 255];
const NO_BOX: u16 = u16::MAX;

/// Tangent-space normals of one garment, glTF's way: red where u grows, green up in the picture, blue outwards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NormalMap {
    /// Texels each way.
    pub side: usize,
    /// Rows from the top, three bytes a texel: 0 is −1 and 255 is 1.
    pub texels: Vec<[u8; 3]>,
}

impl CoarseOutfit {
    /// One picture a garment of the fine drape's unit normals (welded order), for the coarse mesh as it is shaded;
    /// of `side` texels each way, or as many as its folds ask for.
    #[must_use]
    pub fn bake(&self, normals: &[Vec3], shading: &Shading, side: Option<usize>) -> Vec<NormalMap> {
        let bake = |(index, source): (usize, &Source)| {
            let side = side.unwrap_or(source.side);
            let mut picture = Picture::new(side, &source.boxes);
            self.encode(index, shading, &source.normals(normals, side), &mut picture);
            picture.spread();
            NormalMap { side, texels: picture.texels }
        };
        self.sources.iter().enumerate().map(bake).collect()
    }

    /// Writes normals into the picture as they are in the interpolated frames of the coarse mesh.
    fn encode(&self, index: usize, shading: &Shading, seen: &[Vec3], picture: &mut Picture) {
        let side = picture.side;
        for &drawn in self.triangles(index) {
            let frames = drawn.map(|corner| self.frame(shading, corner));
            each_texel(side, Patch::corners(&self.uvs, drawn), |texel, weights| {
                let normal = seen.get(texel).copied().and_then(Vec3::try_normalize);
                picture.set(texel, normal.map(|normal| coded(blended(&frames, weights), normal)));
            });
        }
    }

    /// Tangent, bitangent and normal of a coarse vertex as columns.
    fn frame(&self, shading: &Shading, corner: u32) -> Mat3 {
        let normal = pick(&shading.normals, pick(&self.outfit.surface.vertex_of, corner));
        let tangent = pick(&shading.tangents, corner);
        Mat3::from_cols(tangent.truncate(), normal.cross(tangent.truncate()) * tangent.w, normal)
    }
}

impl Source {
    /// The fine drape's normals in the picture's texels, of any length; zero where there is no cloth.
    fn normals(&self, normals: &[Vec3], side: usize) -> Vec<Vec3> {
        let mut seen = vec![Vec3::ZERO; side * side];
        for &triangle in &self.triangles {
            let [a, b, c] = Patch::corners(&self.welded, triangle).map(|vertex| pick(normals, vertex));
            each_texel(side, Patch::corners(&self.uvs, triangle), |texel, weights| {
                if let Some(slot) = seen.get_mut(texel) {
                    *slot = a * weights.x + b * weights.y + c * weights.z;
                }
            });
        }
        seen
    }
}

/// The frame within a triangle as a renderer has it: every axis interpolated, then of unit length.
fn blended([a, b, c]: &[Mat3; 3], weights: Vec3) -> Mat3 {
    let sum = *a * weights.x + *b * weights.y + *c * weights.z;
    Mat3::from_cols(
        sum.x_axis.normalize_or_zero(),
        sum.y_axis.normalize_or_zero(),
        sum.z_axis.normalize_or_zero(),
    )
}

/// A unit normal by its parts along the axes of a frame that need not be at right angles.
fn coded(frame: Mat3, normal: Vec3) -> [u8; 3] {
    let inverse = if frame.determinant().abs() > 0.1 { frame.inverse() } else { frame.transpose() };
    let local = (inverse * normal).normalize_or(Vec3::Z);
    // What looks away from the coarse surface cannot be said.
    let local = local.with_z(local.z.max(LEAST_OUT)).normalize_or(Vec3::Z);
    local.to_array().map(|part| (127.5 * (part + 1.0)).round() as u8)
}

/// A picture in the making.
struct Picture {
    side: usize,
    texels: Vec<[u8; 3]>,
    /// Whether a texel has its colour.
    known: Vec<bool>,
    /// Whether a texel lies on the coarse mesh, but not on the fine one.
    wanted: Vec<bool>,
    /// The box of an island, with half of its gutter, that a texel lies in.
    box_of: Vec<u16>,
}

impl Picture {
    fn new(side: usize, boxes: &[Box2]) -> Self {
        let count = side * side;
        let mut box_of = vec![NO_BOX; count];
        let (around, end) = ((GUTTER * side as f32 / 2.0).max(1.0), side as f32);
        for (index, bounds) in boxes.iter().enumerate() {
            let first = |at: f32| (at * end - around).clamp(0.0, end) as usize;
            let last = |at: f32| (at * end + around + 1.0).clamp(0.0, end) as usize;
            for y in first(bounds.low.y)..last(bounds.high.y) {
                let row = y * side + first(bounds.low.x)..y * side + last(bounds.high.x);
                box_of.get_mut(row).unwrap_or_default().fill(index as u16);
            }
        }
        let (known, wanted) = (vec![false; count], vec![false; count]);
        Self { side, texels: vec![FLAT; count], known, wanted, box_of }
    }

    fn set(&mut self, texel: usize, colour: Option<[u8; 3]>) {
        match (colour, self.texels.get_mut(texel), self.known.get_mut(texel), self.wanted.get_mut(texel)) {
            (Some(colour), Some(slot), Some(known), _) => (*slot, *known) = (colour, true),
            (None, _, Some(false), Some(wanted)) => *wanted = true,
            _ => {}
        }
    }

    /// Carries colours over to neighbours within the same box: everywhere on the coarse mesh, and a rim around it.
    fn spread(&mut self) {
        let mut edge: Vec<usize> = (0..self.known.len()).filter(|&texel| self.has(texel)).collect();
        let mut missing =
            self.wanted.iter().zip(&self.known).filter(|(wanted, known)| **wanted && !**known).count();
        let mut rim = 0;
        while !edge.is_empty() && (rim < RIM || missing > 0) {
            let mut next = Vec::new();
            for texel in edge {
                for neighbour in self.neighbours(texel) {
                    if self.has(neighbour) || self.box_of.get(neighbour) != self.box_of.get(texel) {
                        continue;
                    }
                    missing -= usize::from(self.wanted.get(neighbour) == Some(&true));
                    self.set(neighbour, self.texels.get(texel).copied());
                    next.push(neighbour);
                }
            }
            edge = next;
            rim += 1;
        }
    }

    fn has(&self, texel: usize) -> bool {
        self.known.get(texel) == Some(&true)
    }

    /// Texels to the sides of one, as far as there are any.
    fn neighbours(&self, texel: usize) -> impl Iterator<Item = usize> + use<> {
        let (side, count, x) = (self.side, self.known.len(), texel % self.side);
        let left = (x > 0).then(|| texel - 1);
        let right = (x + 1 < side).then_some(texel + 1);
        let below = (texel + side < count).then_some(texel + side);
        [left, right, texel.checked_sub(side), below].into_iter().flatten()
    }
}
