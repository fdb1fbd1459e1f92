//! Small files made by hand, and a body to put them on.

#![allow(dead_code, clippy::unwrap_used)]

use glam::Vec3;
use serde_json::{Value, json};
use toile_drape::outfit::{Outfit, Report};
use toile_drape::outfit_build::build;
use toile_gltf::{Format, Hints, ReadError, read};

/// A GLB from its JSON and binary chunk.
pub fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut data = binary.to_vec();
    data.resize(data.len().next_multiple_of(4), 0);
    let total = 12 + 8 + text.len() + if data.is_empty() { 0 } else { 8 + data.len() };
    let mut out = b"glTF".to_vec();
    for word in [2, total as u32, text.len() as u32] {
        out.extend(word.to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(text);
    if !data.is_empty() {
        out.extend((data.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(data);
    }
    out
}

/// Little-endian bytes of floats.
pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Little-endian bytes of 16-bit indices, padded to four.
pub fn shorts(values: &[u16]) -> Vec<u8> {
    let mut bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

/// A square of two triangles in front of the chest, metres.
pub const SQUARE: [f32; 12] = [-0.1, 1.2, 0.2, 0.1, 1.2, 0.2, 0.1, 1.4, 0.2, -0.1, 1.4, 0.2];

/// JSON and binary of that square: positions, UVs, 16-bit indices.
pub fn square() -> (Value, Vec<u8>) {
    let binary =
        [floats(&SQUARE), floats(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]), shorts(&[0, 1, 2, 0, 2, 3])]
            .concat();
    let json = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0], "name": "patch"}],
        "nodes": [{"mesh": 0, "name": "square"}],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}
        ]}],
        "materials": [{"name": "linen", "pbrMetallicRoughness": {"metallicFactor": 0}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 92}],
    });
    (json, binary)
}

/// The square with one thing changed in its JSON.
pub fn square_with(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (mut json, binary) = square();
    change(&mut json);
    glb(&json, &binary)
}

/// What reading gives as an error code, or `read`.
pub fn code(bytes: &[u8]) -> &'static str {
    match read(bytes, Format::Glb, &Hints::default(), None) {
        Ok(_) => "read",
        Err(error) => error.code(),
    }
}

/// Reads a GLB without hints.
pub fn read_glb(bytes: &[u8]) -> Result<toile_drape::outfit_build::OutfitSource, ReadError> {
    read(bytes, Format::Glb, &Hints::default(), None)
}

/// A cylinder around the Y axis: positions and triangles wound outwards.
pub fn tube(radius: f32, low: f32, high: f32, sides: u32, rings: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    for ring in 0..=rings {
        let y = low + (high - low) * ring as f32 / rings as f32;
        for side in 0..sides {
            let angle = std::f32::consts::TAU * side as f32 / sides as f32;
            positions.push(Vec3::new(radius * angle.sin(), y, radius * angle.cos()));
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for side in 0..sides {
            let (a, b) = (ring * sides + side, ring * sides + (side + 1) % sides);
            triangles.extend([[a, b, b + sides], [a, b + sides, a + sides]]);
        }
    }
    (positions, triangles)
}

/// A person as a tube of 1.84 m.
pub fn body() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    tube(0.15, 0.0, 1.84, 48, 60)
}

/// Reads and builds on that person.
pub fn outfit_of(bytes: &[u8]) -> (Outfit, Report) {
    let (vertices, triangles) = body();
    build(read_glb(bytes).unwrap(), &vertices, &triangles).unwrap()
}
