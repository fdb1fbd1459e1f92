//! One garment of an outfit by itself.

use std::collections::HashMap;
use std::ops::Range;

use glam::{Vec2, Vec3};

use super::{NormalMapError, range};
use crate::outfit::{Garment, Outfit};

/// Drawn vertices and triangles of one garment, counted from its first.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    pub(super) name: String,
    /// Welded vertex of each drawn vertex, counted from the outfit's first.
    pub(super) welded: Vec<u32>,
    /// Rest position of each drawn vertex, metres.
    pub(super) positions: Vec<Vec3>,
    /// UV of each drawn vertex, as the file has it; finite.
    pub(super) uvs: Vec<Vec2>,
    /// Triangles over drawn vertices, all of them within range; of vertices at one place with one UV, the first.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Ranges of `triangles`, one a material.
    pub(super) parts: Vec<Range<usize>>,
}

impl Patch {
    /// The garment with its welded vertices at `rest`.
    ///
    /// # Errors
    /// When the outfit has no UVs.
    pub(super) fn new(fine: &Outfit, rest: &[Vec3], garment: &Garment) -> Result<Self, NormalMapError> {
        let no_uvs = || NormalMapError::NoUvs { garment: garment.name.clone() };
        let drawn = range(&garment.drawn_vertices);
        let welded = fine.surface.vertex_of.get(drawn.clone()).unwrap_or(&[]).to_vec();
        let uvs = fine.surface.uvs.get(drawn).ok_or_else(no_uvs)?.to_vec();
        if !uvs.iter().all(|uv| uv.is_finite()) || welded.is_empty() || uvs.len() != welded.len() {
            return Err(no_uvs());
        }
        let first_alike = first_alike(&welded, &uvs);
        let start = garment.drawn_vertices.start;
        let all = range(&garment.triangles());
        let corner = |corner: u32| pick(&first_alike, corner.saturating_sub(start));
        let drawn = fine.surface.triangles.get(all.clone()).unwrap_or(&[]).iter();
        let parts = garment.parts.iter().map(|part| range(&part.triangles));
        Ok(Self {
            name: garment.name.clone(),
            positions: welded.iter().map(|&vertex| pick(rest, vertex)).collect(),
            triangles: drawn.map(|t| t.map(corner)).collect(),
            parts: parts.map(|p| p.start - all.start..p.end - all.start).collect(),
            welded,
            uvs,
        })
    }

    /// What lies at a triangle's corners.
    pub(super) fn corners<T: Copy + Default>(values: &[T], triangle: [u32; 3]) -> [T; 3] {
        triangle.map(|corner| pick(values, corner))
    }
}

/// For each vertex the first at the same place with the same UV: a file may split them for its own normals.
fn first_alike(welded: &[u32], uvs: &[Vec2]) -> Vec<u32> {
    let mut first = HashMap::new();
    let key = |(vertex, uv): (&u32, &Vec2)| (*vertex, uv.x.to_bits(), uv.y.to_bits());
    let vertices = welded.iter().zip(uvs).map(key).zip(0..);
    vertices.map(|(key, index)| *first.entry(key).or_insert(index)).collect()
}

/// The value of a vertex.
#[inline]
pub(super) fn pick<T: Copy + Default>(values: &[T], index: u32) -> T {
    values.get(index as usize).copied().unwrap_or_default()
}
