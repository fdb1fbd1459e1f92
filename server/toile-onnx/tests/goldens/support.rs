//! Goldens and what they are replayed with.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use safetensors::SafeTensors;
use toile_drape::outfit::{Garment, Material, Outfit, Part, Surface};
use toile_drape::pipeline::Motion;
use toile_drape::studio::Studio;
use toile_geometry::body::{Body, BodyShape};
use toile_geometry::poses::PoseLibrary;
use toile_onnx::OnnxNetworks;

pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn library() -> PathBuf {
    if let Some(path) = std::env::var_os("ORT_DYLIB_PATH") {
        return path.into();
    }
    let lib = repository().join(".venv/lib");
    let python =
        std::fs::read_dir(&lib).expect("run `make build` first: .venv is missing").next().unwrap().unwrap();
    let capi = python.path().join("site-packages/onnxruntime/capi");
    let found = std::fs::read_dir(capi).unwrap().map(|e| e.unwrap().path());
    found.into_iter().find(|p| p.to_string_lossy().contains("libonnxruntime.so")).unwrap()
}

pub fn networks() -> OnnxNetworks {
    OnnxNetworks::load(&repository().join("model/artifacts"), &library()).unwrap()
}

pub struct Golden {
    bytes: Vec<u8>,
}

impl Golden {
    pub fn read(name: &str) -> Self {
        let path = repository().join("model/artifacts/golden").join(name);
        Self { bytes: std::fs::read(path).unwrap() }
    }

    pub fn floats(&self, name: &str) -> Vec<f32> {
        let file = SafeTensors::deserialize(&self.bytes).unwrap();
        let data = file.tensor(name).unwrap().data().to_vec();
        data.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
    }

    pub fn indices(&self, name: &str) -> Vec<u32> {
        let file = SafeTensors::deserialize(&self.bytes).unwrap();
        let data = file.tensor(name).unwrap().data().to_vec();
        data.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect()
    }

    pub fn points(&self, name: &str) -> Vec<Vec3> {
        self.floats(name).as_chunks::<3>().0.iter().map(|p| Vec3::from_array(*p)).collect()
    }

    pub fn outfit(&self) -> Outfit {
        let triangles = self.indices("triangles").as_chunks::<3>().0.to_vec();
        let positions = self.points("vertices");
        let (vertices, faces) = (0..positions.len() as u32, 0..triangles.len() as u32);
        let surface =
            Surface { vertex_of: vertices.clone().collect(), uvs: vec![], triangles: triangles.clone() };
        let garment = Garment {
            name: "garment".to_owned(),
            layer: 0,
            vertices: vertices.clone(),
            drawn_vertices: vertices,
            parts: vec![Part { material: 0, triangles: faces }],
        };
        Outfit {
            positions,
            triangles,
            garments: vec![garment],
            surface,
            materials: vec![Material::default()],
            ..Outfit::default()
        }
    }
}

pub fn body() -> Body {
    Body::from_safetensors(&std::fs::read(repository().join("model/artifacts/body.safetensors")).unwrap())
        .unwrap()
}

/// Mean and largest distance.
pub fn differences(a: &[Vec3], b: &[Vec3]) -> (f32, f32) {
    let sum: f32 = a.iter().zip(b).map(|(a, b)| a.distance(*b)).sum();
    (sum / a.len() as f32, largest_difference(a, b))
}

pub fn largest_difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

/// The golden body in the golden poses.
pub fn motion(studio: &Studio) -> Motion {
    let values = [("gender", 1.0), ("weight", 0.7), ("height", 0.4)];
    let values: BTreeMap<String, f32> = values.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect();
    let shape = BodyShape::from_values(&studio.body, &values).unwrap();
    let poses = std::fs::read(repository().join("model/artifacts/poses.json")).unwrap();
    let library = PoseLibrary::from_json(&poses, &studio.body).unwrap();
    let pose = |id| library.preset(id).unwrap().pose.to_pose(&studio.body).unwrap();
    Motion { shape, poses: ["walk-2", "sitting"].map(pose).to_vec(), frame_rate: 24.0 }
}

/// Mean and largest distance of `moved` cloth from what is `expected`, about their means: the presets' root may stand
/// elsewhere on the floor.
pub fn differences_about_means(moved: &[Vec3], expected: &[Vec3]) -> (f32, f32) {
    let centre = |x: &[Vec3]| x.iter().sum::<Vec3>() / x.len() as f32;
    let shift = centre(expected) - centre(moved);
    differences(&moved.iter().map(|p| *p + shift).collect::<Vec<_>>(), expected)
}
