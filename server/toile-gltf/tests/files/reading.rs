#![allow(clippy::unwrap_used)]

use glam::{Vec2, Vec3};
use serde_json::json;
use toile_drape::outfit::UvTransform;

use crate::support::{SQUARE, floats, glb, read_glb, shorts, square, square_with};

fn point(i: usize) -> Vec3 {
    Vec3::from_slice(&SQUARE[i * 3..])
}

#[test]
fn a_plain_file_gives_its_vertices_uvs_names_and_material() {
    let source = read_glb(&square_with(|_| {})).unwrap();
    let mesh = &source.meshes[0];
    assert_eq!((source.name.as_deref(), mesh.name.as_str()), (Some("patch"), "square"));
    assert_eq!(mesh.positions, (0..4).map(point).collect::<Vec<_>>());
    assert_eq!(mesh.uvs[1], Vec2::ONE);
    assert_eq!(mesh.parts[0].triangles, vec![[0, 1, 2], [0, 2, 3]]);
    assert_eq!((mesh.parts[0].material, source.materials[0].name.as_str()), (Some(0), "linen"));
    assert_eq!((source.report.units.as_str(), source.report.scale_applied), ("m", 1.0));
}

#[test]
fn a_given_name_wins_over_the_scene() {
    let hints = toile_gltf::Hints::default();
    let source =
        toile_gltf::read(&square_with(|_| {}), toile_gltf::Format::Glb, &hints, Some("Mine")).unwrap();
    assert_eq!(source.name.as_deref(), Some("Mine"));
}

#[test]
fn strips_and_fans_become_triangles_of_one_winding() {
    for (mode, expected) in [(5, [[0, 1, 2], [1, 3, 2]]), (6, [[0, 1, 2], [0, 2, 3]])] {
        let bytes = square_with(|json| {
            json["meshes"][0]["primitives"][0]["mode"] = mode.into();
            json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
        });
        assert_eq!(read_glb(&bytes).unwrap().meshes[0].parts[0].triangles, expected, "mode {mode}");
    }
}

#[test]
fn node_transforms_apply_down_the_tree_and_mirrors_turn_the_winding() {
    let bytes = square_with(|json| {
        json["nodes"] = json!([
            {"translation": [0, 0, -0.3], "children": [1]},
            {"mesh": 0, "scale": [-1, 1, 1], "rotation": [0, 1, 0, 0]},
        ]);
    });
    let source = read_glb(&bytes).unwrap();
    // Mirrored in x, turned by half about y, moved back: (x, y, z) → (x, y, −z − 0.3).
    assert!(source.meshes[0].positions[1].distance(Vec3::new(0.1, 1.2, -0.5)) < 1e-6);
    assert_eq!(source.meshes[0].parts[0].triangles[0], [0, 2, 1]);
}

#[test]
fn a_matrix_is_column_major() {
    let matrix = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.05, 0.1, 0, 1]);
    let source = read_glb(&square_with(|json| json["nodes"][0]["matrix"] = matrix)).unwrap();
    assert!(source.meshes[0].positions[0].distance(Vec3::new(-0.05, 1.3, 0.2)) < 1e-6);
}

#[test]
fn interleaved_vertices_are_read_by_their_stride() {
    let (mut json, _) = square();
    let interleaved: Vec<f32> =
        (0..4).flat_map(|i| [SQUARE[i * 3], SQUARE[i * 3 + 1], SQUARE[i * 3 + 2], 0.5, i as f32]).collect();
    json["bufferViews"] = json!([
        {"buffer": 0, "byteLength": 80, "byteStride": 20},
        {"buffer": 0, "byteOffset": 80, "byteLength": 12},
    ]);
    json["accessors"][1] =
        json!({"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 4, "type": "VEC2"});
    json["accessors"][2]["bufferView"] = 1.into();
    let bytes = glb(&json, &[floats(&interleaved), shorts(&[0, 1, 2, 0, 2, 3])].concat());
    let mesh = read_glb(&bytes).unwrap().meshes.remove(0);
    assert_eq!((mesh.positions[3], mesh.uvs[3]), (point(3), Vec2::new(0.5, 3.0)));
}

#[test]
fn normalised_integers_are_divided_by_their_largest_value() {
    let (mut json, _) = square();
    json["bufferViews"][1] = json!({"buffer": 0, "byteOffset": 48, "byteLength": 16});
    json["bufferViews"][2]["byteOffset"] = 64.into();
    json["accessors"][1]["componentType"] = 5123.into();
    json["accessors"][1]["normalized"] = true.into();
    let uvs = shorts(&[0, u16::MAX, u16::MAX, 0, 0, 0, 0, 0]);
    let bytes = glb(&json, &[floats(&SQUARE), uvs, shorts(&[0, 1, 2, 0, 2, 3]), vec![0; 16]].concat());
    let mesh = read_glb(&bytes).unwrap().meshes.remove(0);
    assert_eq!(&mesh.uvs[..2], &[Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.0)]);
}

#[test]
fn sparse_values_replace_those_of_the_accessor() {
    let (mut json, mut binary) = square();
    binary.extend([shorts(&[2]), floats(&[0.0, 1.5, 0.25])].concat());
    json["buffers"][0]["byteLength"] = binary.len().into();
    json["bufferViews"].as_array_mut().unwrap().extend([
        json!({"buffer": 0, "byteOffset": 92, "byteLength": 4}),
        json!({"buffer": 0, "byteOffset": 96, "byteLength": 12}),
    ]);
    json["accessors"][0]["sparse"] =
        json!({"count": 1, "indices": {"bufferView": 3, "componentType": 5123}, "values": {"bufferView": 4}});
    let mesh = read_glb(&glb(&json, &binary)).unwrap().meshes.remove(0);
    assert_eq!(mesh.positions, [point(0), point(1), Vec3::new(0.0, 1.5, 0.25), point(3)]);
}

#[test]
fn primitives_that_name_the_same_accessors_share_vertices() {
    let bytes = square_with(|json| {
        let primitive = json["meshes"][0]["primitives"][0].clone();
        json["meshes"][0]["primitives"] = json!([primitive, primitive]);
    });
    let mesh = read_glb(&bytes).unwrap().meshes.remove(0);
    assert_eq!((mesh.positions.len(), mesh.parts.len()), (4, 2));
}

#[test]
fn sheen_cutout_and_texture_transform_are_kept() {
    let png = tiny_png();
    let bytes = square_with(|json| {
        json["images"] = json!([{"uri": png}]);
        json["textures"] = json!([{"source": 0}]);
        json["materials"][0] = json!({
            "alphaMode": "MASK", "alphaCutoff": 0.25,
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 2.0, 1.0],
                "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [4, 4]}}},
            },
            "extensions": {"KHR_materials_sheen": {"sheenColorFactor": [0.5, 0.5, 0.5], "sheenRoughnessFactor": 0.75}},
        });
    });
    let material = read_glb(&bytes).unwrap().materials.remove(0);
    assert_eq!(material.base_color, [0.5, 0.25, 1.0, 1.0]);
    assert_eq!(material.alpha_cutoff, Some(0.25));
    assert_eq!(material.sheen, Some(([0.5; 3], 0.75)));
    assert_eq!(material.uv_transform, Some(UvTransform { offset: [0.0; 2], rotation: 0.0, scale: [4.0; 2] }));
    assert_eq!(material.base_color_picture.map(|picture| picture.mime_type), Some("image/png".to_owned()));
}

/// A data URI of a picture of 2 × 2 pixels.
pub fn tiny_png() -> String {
    use base64::Engine;
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(2, 2, image::Rgb([200, 100, 50]))
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes.into_inner()))
}
