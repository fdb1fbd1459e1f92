#![allow(clippy::unwrap_used)]

use glam::Vec3;
use serde_json::{Value, json};
use toile_drape::outfit::{Material, RawMesh, RawPart};
use toile_drape::outfit::{Outfit, Picture};
use toile_drape::outfit_build::{OutfitSource, build};
use toile_geometry::normals::vertex_normals;
use toile_gltf::{
    BodyTemplate, FrameView, OutfitTemplate, Scene, WriteError, write_body, write_drape, write_rest,
};

use crate::support::{body, outfit_of, tube};

/// A shirt of two fabrics with a UV seam, and a skirt.
fn outfit() -> Outfit {
    let (mut positions, mut triangles) = tube(0.2, 1.0, 1.5, 40, 20);
    let seam: Vec<u32> = (0..=20).map(|ring| ring * 40).collect();
    for triangle in &mut triangles {
        if triangle.iter().any(|corner| corner % 40 == 39) {
            for corner in triangle.iter_mut().filter(|corner| **corner % 40 == 0 && seam.contains(corner)) {
                *corner = 21 * 40 + *corner / 40;
            }
        }
    }
    positions.extend(seam.iter().map(|vertex| positions[*vertex as usize]).collect::<Vec<_>>());
    let uvs = positions.iter().map(|p| glam::Vec2::new(p.x, p.y)).collect();
    let back = triangles.split_off(triangles.len() / 2);
    let part = |triangles, material| RawPart { triangles, material };
    let shirt = RawMesh {
        name: "shirt".into(),
        positions,
        uvs,
        parts: vec![part(triangles, Some(0)), part(back, Some(1))],
    };
    let (positions, triangles) = tube(0.22, 0.5, 1.1, 40, 20);
    let skirt = RawMesh { name: "skirt".into(), positions, uvs: vec![], parts: vec![part(triangles, None)] };
    let picture = Picture { mime_type: "image/png".into(), bytes: png() };
    let front = Material { name: "front".into(), base_color_picture: Some(picture), ..Material::default() };
    let back = Material { name: "back".into(), sheen: None, alpha_cutoff: Some(0.5), ..Material::default() };
    let source = OutfitSource {
        name: Some("Two".into()),
        meshes: vec![shirt, skirt],
        materials: vec![front, back],
        ..OutfitSource::default()
    };
    let (vertices, triangles) = body();
    build(source, &vertices, &triangles).unwrap().0
}

fn png() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(2, 2).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// The JSON of a GLB, after checking that its lengths are exact.
fn json_of(bytes: &[u8]) -> Value {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (b"glTF".as_slice(), 2, bytes.len()));
    let json = word(12);
    assert_eq!((json % 4, word(20 + json) + 28 + json), (0, bytes.len()));
    serde_json::from_slice(&bytes[20..20 + json]).unwrap()
}

fn frame<'a>(positions: &'a [Vec3], normals: &'a [Vec3]) -> FrameView<'a> {
    FrameView { positions, normals, ..FrameView::default() }
}

fn drape(outfit: &Outfit, frames: &[FrameView<'_>], textures: bool) -> Result<Vec<u8>, WriteError> {
    let template = OutfitTemplate::new(outfit);
    write_drape(&Scene { outfit: Some(&template), body: None, frames, frame_rate: 24.0, textures })
}

#[test]
fn a_rest_pose_is_read_back_as_the_same_outfit() {
    let outfit = outfit();
    let (again, report) = outfit_of(&write_rest(&outfit, &outfit.positions).unwrap());
    assert_eq!(again, outfit);
    assert_eq!((report.flipped_normals, report.welded_vertices), (0, 21));
}

#[test]
fn every_garment_is_a_node_and_the_body_is_the_node_body() {
    let outfit = outfit();
    let (vertices, triangles) = body();
    let (template, body) = (OutfitTemplate::new(&outfit), BodyTemplate::new(vertices.len(), &triangles));
    let normals = vertex_normals(&outfit.positions, &outfit.triangles);
    let frames = [FrameView { body: &vertices, ..frame(&outfit.positions, &normals) }];
    let scene = Scene {
        outfit: Some(&template),
        body: Some(&body),
        frames: &frames,
        frame_rate: 24.0,
        textures: true,
    };
    let bytes = write_drape(&scene).unwrap();
    let json = json_of(&bytes);
    let names: Vec<&str> =
        json["nodes"].as_array().unwrap().iter().map(|n| n["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["shirt", "skirt", "body"]);
    assert_eq!(json["extensionsUsed"], json!(["KHR_materials_sheen"]));
    assert!(json["materials"].as_array().unwrap().iter().all(|material| material["doubleSided"] == true));
    assert_eq!(json["images"].as_array().unwrap().len(), 1);
    let indices = json["meshes"][0]["primitives"][0]["indices"].as_u64().unwrap();
    assert_eq!(json["accessors"][indices as usize]["componentType"], 5123);
    assert_eq!(bytes, write_drape(&scene).unwrap(), "the same scene gives the same bytes");
}

#[test]
fn positions_state_their_bounds() {
    let outfit = outfit();
    let json = json_of(&write_rest(&outfit, &outfit.positions).unwrap());
    let position = json["meshes"][1]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap() as usize;
    let bounds = |key: &str, axis: usize| json["accessors"][position][key][axis].as_f64().unwrap() as f32;
    assert_eq!((bounds("min", 1), bounds("max", 1)), (0.5, 1.1));
}

#[test]
fn pictures_can_be_left_out() {
    let outfit = outfit();
    let normals = vertex_normals(&outfit.positions, &outfit.triangles);
    let frames = [frame(&outfit.positions, &normals)];
    let (with, without) = (drape(&outfit, &frames, true).unwrap(), drape(&outfit, &frames, false).unwrap());
    assert!(json_of(&without).get("images").is_none());
    assert!(without.len() + png().len() < with.len());
}

#[test]
fn a_sequence_shows_frame_k_at_its_time_through_morph_targets() {
    let outfit = outfit();
    let normals = vertex_normals(&outfit.positions, &outfit.triangles);
    let moved: Vec<Vec<Vec3>> =
        (0..3).map(|k| outfit.positions.iter().map(|p| *p + Vec3::X * 0.25 * k as f32).collect()).collect();
    let frames: Vec<_> = moved.iter().map(|positions| frame(positions, &normals)).collect();
    let bytes = drape(&outfit, &frames, false).unwrap();
    let json = json_of(&bytes);
    for mesh in json["meshes"].as_array().unwrap() {
        for primitive in mesh["primitives"].as_array().unwrap() {
            let targets = primitive["targets"].as_array().unwrap();
            assert_eq!(targets.len(), 2);
            let delta = &json["accessors"][targets[1]["POSITION"].as_u64().unwrap() as usize];
            let (low, high) = (delta["min"][0].as_f64().unwrap(), delta["max"][0].as_f64().unwrap());
            assert!((low - 0.5).abs() < 1e-6 && (high - 0.5).abs() < 1e-6, "{delta}");
        }
    }
    let animation = &json["animations"][0];
    assert_eq!(animation["channels"].as_array().unwrap().len(), 2);
    let view = |sampler: &str| {
        let accessor = &json["accessors"][animation["samplers"][0][sampler].as_u64().unwrap() as usize];
        &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize]
    };
    let floats = |sampler: &str| -> Vec<f32> {
        let start = bytes.len() - json["buffers"][0]["byteLength"].as_u64().unwrap() as usize
            + view(sampler)["byteOffset"].as_u64().unwrap() as usize;
        let end = start + view(sampler)["byteLength"].as_u64().unwrap() as usize;
        bytes[start..end].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    };
    assert_eq!(floats("input"), [0.0, 1.0 / 24.0, 2.0 / 24.0]);
    assert_eq!(floats("output"), [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn strain_and_penetration_are_attributes_when_given() {
    let outfit = outfit();
    let normals = vertex_normals(&outfit.positions, &outfit.triangles);
    let values = vec![0.5; outfit.positions.len()];
    let view = FrameView { strain: &values, penetration: &values, ..frame(&outfit.positions, &normals) };
    let json = json_of(&drape(&outfit, &[view], false).unwrap());
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    for name in ["_STRAIN", "_PENETRATION"] {
        let accessor = &json["accessors"][attributes[name].as_u64().unwrap() as usize];
        assert_eq!(accessor["count"], outfit.garments[0].drawn_vertices.len());
    }
}

#[test]
fn large_meshes_have_wide_indices() {
    let (positions, triangles) = tube(0.2, 0.0, 1.8, 300, 300);
    let bytes = write_body(&positions, &triangles).unwrap();
    let json = json_of(&bytes);
    assert_eq!(
        json["accessors"].as_array().unwrap().iter().filter(|a| a["componentType"] == 5125).count(),
        1
    );
    let source = crate::support::read_glb(&bytes).unwrap();
    assert_eq!((&source.meshes[0].positions, &source.meshes[0].parts[0].triangles), (&positions, &triangles));
}

#[test]
fn data_that_do_not_fit_are_refused() {
    let outfit = outfit();
    let normals = vertex_normals(&outfit.positions, &outfit.triangles);
    let short = &outfit.positions[1..];
    assert!(matches!(drape(&outfit, &[frame(short, &normals)], true), Err(WriteError::Length { .. })));
    assert!(matches!(drape(&outfit, &[], true), Err(WriteError::EmptyScene(_))));
    let mut broken = outfit.positions.clone();
    broken[3].y = f32::NAN;
    assert_eq!(drape(&outfit, &[frame(&broken, &normals)], true), Err(WriteError::NonFinite("positions")));
    assert_eq!(
        drape(&outfit, &[frame(&outfit.positions, &broken)], true),
        Err(WriteError::NonFinite("normals"))
    );
}
