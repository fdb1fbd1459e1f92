//! Sheets and tubes of cloth, and ground, for tests.

use glam::Vec3;
use toile_geometry::mesh::Adjacency;

use crate::contact::Collider;
use crate::outfit::{Garment, Outfit};

/// A square sheet in the ground plane, `side` vertices of 1 cm each way.
pub fn sheet(side: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let at = |i: u32| Vec3::new((i % side) as f32 * 0.01 + 0.003, 0.0, (i / side) as f32 * 0.01 + 0.003);
    let corners = (0..side * (side - 1)).filter(|i| i % side + 1 < side);
    let triangles = corners.flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]]).collect();
    ((0..side * side).map(at).collect(), triangles)
}

/// Sheets of 1 cm quads facing up, one garment each: (height, rows).
pub fn sheets(all: &[(f32, u32)]) -> Outfit {
    let mut outfit = Outfit::default();
    for (layer, (height, rows)) in all.iter().enumerate() {
        let first = outfit.positions.len() as u32;
        outfit.positions.extend(
            (0..rows * 10).map(|i| Vec3::new(0.01 * (i % 10) as f32, *height, 0.01 * (i / 10) as f32)),
        );
        let corners = (0..10 * (rows - 1)).filter(|i| i % 10 < 9).map(|i| first + i);
        outfit.triangles.extend(corners.flat_map(|i| [[i, i + 10, i + 1], [i + 1, i + 10, i + 11]]));
        let vertices = first..outfit.positions.len() as u32;
        outfit.garments.push(Garment {
            name: layer.to_string(),
            layer: layer as u32,
            drawn_vertices: vertices.clone(),
            vertices,
            parts: vec![],
        });
    }
    outfit
}

/// A tube that hangs around the origin, of 2 cm quads: radius and height in metres.
pub fn tube(radius: f32, height: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let around = (std::f32::consts::TAU * radius / 0.02) as u32;
    let rows = (height / 0.02) as u32;
    let at = |i: u32| {
        let (sin, cos) = (std::f32::consts::TAU * (i % around) as f32 / around as f32).sin_cos();
        Vec3::new(radius * cos, 0.02 * (i / around) as f32, radius * sin)
    };
    let quad = |i: u32| {
        let next = i - i % around + (i + 1) % around;
        [[i, i + around, next], [next, i + around, next + around]]
    };
    ((0..around * rows).map(at).collect(), (0..around * (rows - 1)).flat_map(quad).collect())
}

/// A surface of one limb, without folds and feet.
pub fn limb<'a>(vertices: &'a [Vec3], normals: &'a [Vec3], ring: &'a Adjacency) -> Collider<'a> {
    Collider { vertices, normals, ring, facing: &[], cells: None, feet: [&[]; 2] }
}
