//! An outfit made here, so that no test depends on a file.

use std::f32::consts::TAU;
use std::fmt::Write;

use serde_json::{Value, json};

use crate::glb_of_json;

const SEGMENTS: u32 = 48;
const RINGS: u32 = 20;

/// Triangles, in metres, glTF axes.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Positions.
    pub positions: Vec<[f32; 3]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
}

/// A skirt around the hips of the reference body; `flare` widens the hem, so that two skirts differ.
pub fn skirt(flare: f32) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for ring in 0..=RINGS {
        let down = ring as f32 / RINGS as f32;
        let (y, x, z) = (1.06 - 0.48 * down, 0.19 + 0.12 * flare * down, 0.17 + 0.1 * flare * down);
        for segment in 0..SEGMENTS {
            let (sin, cos) = (TAU * segment as f32 / SEGMENTS as f32).sin_cos();
            positions.push([x * sin, y, z * cos + 0.02]);
        }
    }
    for ring in 0..RINGS {
        for segment in 0..SEGMENTS {
            let (a, b) = (ring * SEGMENTS + segment, ring * SEGMENTS + (segment + 1) % SEGMENTS);
            let (c, d) = (a + SEGMENTS, b + SEGMENTS);
            triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    Mesh { positions, triangles }
}

impl Mesh {
    /// The mesh with every position changed.
    #[must_use]
    pub fn map(&self, change: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        Self {
            positions: self.positions.iter().copied().map(change).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// As a GLB.
    pub fn glb(&self) -> Vec<u8> {
        glb_of_json(&self.gltf_json(None), &self.binary())
    }

    /// As a GLB whose JSON was changed.
    pub fn glb_with(&self, change: impl FnOnce(&mut Value)) -> Vec<u8> {
        let mut json = self.gltf_json(None);
        change(&mut json);
        glb_of_json(&json, &self.binary())
    }

    /// As glTF with an embedded buffer.
    pub fn gltf(&self) -> Vec<u8> {
        let uri = format!("data:application/octet-stream;base64,{}", base64(&self.binary()));
        self.gltf_json(Some(&uri)).to_string().into_bytes()
    }

    /// As OBJ.
    pub fn obj(&self) -> Vec<u8> {
        let mut text = String::from("o skirt\n");
        for [x, y, z] in &self.positions {
            writeln!(text, "v {x} {y} {z}").expect("a string");
        }
        for [a, b, c] in &self.triangles {
            writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("a string");
        }
        text.into_bytes()
    }

    fn binary(&self) -> Vec<u8> {
        let positions = self.positions.iter().flatten().flat_map(|x| x.to_le_bytes());
        positions.chain(self.triangles.iter().flatten().flat_map(|i| i.to_le_bytes())).collect()
    }

    fn gltf_json(&self, uri: Option<&str>) -> Value {
        let (points, corners) = (self.positions.len() * 12, self.triangles.len() * 12);
        let bound = |pick: fn(f32, f32) -> f32| {
            let start = self.positions.first().copied().unwrap_or_default();
            self.positions.iter().fold(start, |b, p| std::array::from_fn(|axis| pick(b[axis], p[axis])))
        };
        let mut buffer = json!({"byteLength": points + corners});
        if let Some(uri) = uri {
            buffer["uri"] = json!(uri);
        }
        json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"name": "skirt", "mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": self.positions.len(), "type": "VEC3",
                 "min": bound(f32::min), "max": bound(f32::max)},
                {"bufferView": 1, "componentType": 5125, "count": self.triangles.len() * 3, "type": "SCALAR"}
            ],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": points},
                {"buffer": 0, "byteOffset": points, "byteLength": corners}
            ],
            "buffers": [buffer]
        })
    }
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let word =
            chunk.iter().fold(0_u32, |word, byte| word << 8 | u32::from(*byte)) << (8 * (3 - chunk.len()));
        for place in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * place)) as usize & 63];
            text.push(if place > chunk.len() { '=' } else { char::from(letter) });
        }
    }
    text
}
