//! Welding: drawn vertices of a mesh that lie at one place are one vertex.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::{OutfitError, OutfitSource};
use crate::outfit::{RawMesh, Report};

/// Vertices closer than this on every axis are one, metres.
const GRID_M: f64 = 1e-5;

/// A triangle on its way through the build.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Corners as drawn.
    pub(super) drawn: [u32; 3],
    /// Corners as welded.
    pub(super) welded: [u32; 3],
    /// Index into the source's meshes.
    pub(super) mesh: u32,
    /// Index into the source's materials.
    pub(super) material: Option<usize>,
}

/// All triangles of all meshes, welded within each mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Soup {
    /// Welded positions, metres.
    pub(super) positions: Vec<Vec3>,
    /// Drawn vertex -> welded vertex; drawn vertices run through the meshes in file order.
    pub(super) vertex_of: Vec<u32>,
    /// One UV per drawn vertex, or empty.
    pub(super) uvs: Vec<Vec2>,
    pub(super) faces: Vec<Face>,
}

impl Soup {
    /// Corner positions of a face.
    pub(super) fn corners(&self, face: &Face) -> [Vec3; 3] {
        face.welded.map(|vertex| self.position(vertex))
    }

    pub(super) fn position(&self, vertex: u32) -> Vec3 {
        self.positions.get(vertex as usize).copied().unwrap_or_default()
    }

    /// Twice the area times the unit normal.
    pub(super) fn area_vector(&self, face: &Face) -> Vec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a)
    }
}

/// Checks the meshes and welds each.
pub(super) fn weld(source: &OutfitSource, report: &mut Report) -> Result<Soup, OutfitError> {
    let mut soup = Soup::default();
    let has_uvs = source.meshes.iter().any(|mesh| !mesh.uvs.is_empty());
    for (index, mesh) in source.meshes.iter().enumerate() {
        check(mesh, source.materials.len())?;
        let first = soup.vertex_of.len() as u32;
        weld_positions(&mesh.positions, &mut soup);
        if has_uvs {
            soup.uvs.extend_from_slice(&mesh.uvs);
            soup.uvs.resize(soup.vertex_of.len(), Vec2::ZERO);
        }
        for part in &mesh.parts {
            let vertex_of = &soup.vertex_of;
            let faces = part.triangles.iter().map(|triangle| {
                let drawn = triangle.map(|corner| corner + first);
                let welded = drawn.map(|corner| vertex_of.get(corner as usize).copied().unwrap_or_default());
                Face { drawn, welded, mesh: index as u32, material: part.material }
            });
            soup.faces.extend(faces);
        }
    }
    report.welded_vertices = soup.vertex_of.len() - soup.positions.len();
    Ok(soup)
}

fn weld_positions(positions: &[Vec3], soup: &mut Soup) {
    let cell = |p: Vec3| p.to_array().map(|x| (f64::from(x) / GRID_M).round() as i64);
    let mut welded: HashMap<[i64; 3], u32> = HashMap::with_capacity(positions.len());
    for &position in positions {
        let next = soup.positions.len() as u32;
        let vertex = *welded.entry(cell(position)).or_insert(next);
        if vertex == next {
            soup.positions.push(position);
        }
        soup.vertex_of.push(vertex);
    }
}

fn check(mesh: &RawMesh, materials: usize) -> Result<(), OutfitError> {
    let out_of_range =
        |what, index, count| OutfitError::IndexOutOfRange { mesh: mesh.name.clone(), what, index, count };
    let vertices = mesh.positions.len();
    if let Some(vertex) = mesh.positions.iter().position(|position| !position.is_finite()) {
        return Err(OutfitError::NonFinitePosition { mesh: mesh.name.clone(), vertex });
    }
    if !mesh.uvs.is_empty() && mesh.uvs.len() != vertices {
        return Err(out_of_range("UV", mesh.uvs.len().min(vertices), mesh.uvs.len().min(vertices)));
    }
    for part in &mesh.parts {
        if let Some(corner) = part.triangles.iter().flatten().find(|corner| **corner as usize >= vertices) {
            return Err(out_of_range("vertex", *corner as usize, vertices));
        }
        if let Some(material) = part.material.filter(|material| *material >= materials) {
            return Err(out_of_range("material", material, materials));
        }
    }
    Ok(())
}
