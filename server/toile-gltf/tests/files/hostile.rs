#![allow(clippy::unwrap_used)]

use base64::Engine;
use serde_json::json;
use toile_gltf::{Format, Hints, read};

use crate::support::{code, floats, glb, square, square_with};

#[test]
fn text_that_is_no_mesh_is_told_apart_by_its_name() {
    assert_eq!(Format::sniff(b"hello", None).unwrap_err().code(), "unsupported-media-type");
    assert_eq!(
        Format::sniff(b"\x89PNG\r\n\x1a\n", Some("a.png")).unwrap_err().code(),
        "unsupported-media-type"
    );
    for name in ["a.glb", "a.gltf", "A.OBJ"] {
        assert_eq!(Format::sniff(b"hello", Some(name)).unwrap_err().code(), "not-a-mesh", "{name}");
    }
    assert_eq!(Format::sniff(b"glT", Some("a.glb")).unwrap_err().code(), "truncated");
}

#[test]
fn formats_are_told_from_their_first_bytes() {
    assert_eq!(Format::sniff(b"glTF\x02", None), Ok(Format::Glb));
    assert_eq!(Format::sniff(b"\xef\xbb\xbf \n{\"asset\"", None), Ok(Format::Gltf));
    assert_eq!(Format::sniff(b"# made by hand\r\nmtllib a.mtl\r\nv 0 0 0", None), Ok(Format::Obj));
}

#[test]
fn a_glb_cut_anywhere_is_truncated() {
    let bytes = square_with(|_| {});
    for length in 4..bytes.len() {
        assert_eq!(code(&bytes[..length]), "truncated", "cut at {length}");
    }
}

#[test]
fn chunks_must_fit_the_file_exactly() {
    let bytes = square_with(|_| {});
    let mut longer = bytes.clone();
    longer.extend([0; 4]);
    assert_eq!(code(&longer), "not-a-mesh");
    let mut chunk = bytes.clone();
    chunk[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(code(&chunk), "truncated");
    let mut version = bytes;
    version[4] = 1;
    assert_eq!(code(&version), "not-a-mesh");
}

#[test]
fn a_twelve_byte_header_that_promises_four_gigabytes_is_truncated() {
    assert_eq!(code(b"glTF\x02\0\0\0\xff\xff\xff\xff"), "truncated");
}

#[test]
fn a_buffer_longer_than_the_binary_chunk_is_truncated() {
    assert_eq!(code(&square_with(|json| json["buffers"][0]["byteLength"] = 1_000.into())), "truncated");
}

#[test]
fn json_that_is_not_gltf_is_no_mesh() {
    assert_eq!(code(&glb(&json!({"hello": 1}), &[])), "not-a-mesh");
    assert_eq!(code(&glb(&json!({"asset": {"version": "1.0"}}), &[])), "not-a-mesh");
    assert_eq!(code(&square_with(|json| json["accessors"][0]["count"] = (-4).into())), "not-a-mesh");
}

#[test]
fn references_to_other_files_are_refused_whatever_their_form() {
    for uri in
        ["file:///etc/passwd", "/etc/passwd", "a.bin", "https://example.com/a.bin", "a%zz.bin", "%", ""]
    {
        let in_buffer = square_with(|json| json["buffers"][0]["uri"] = uri.into());
        assert_eq!(code(&in_buffer), "external-uri", "{uri}");
        let in_image = square_with(|json| json["images"] = json!([{"uri": uri}]));
        assert_eq!(code(&in_image), "external-uri", "{uri}");
    }
}

#[test]
fn a_data_uri_must_be_base64() {
    assert_eq!(code(&square_with(|json| json["buffers"][0]["uri"] = "data:,hello".into())), "not-a-mesh");
    assert_eq!(
        code(&square_with(|json| json["buffers"][0]["uri"] = "data:;base64,%%%".into())),
        "not-a-mesh"
    );
}

#[test]
fn a_self_contained_gltf_is_read() {
    let (mut json, binary) = square();
    let data = base64::engine::general_purpose::STANDARD.encode(&binary);
    json["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{data}").into();
    let source = read(json.to_string().as_bytes(), Format::Gltf, &Hints::default(), None).unwrap();
    assert_eq!(source.meshes[0].positions.len(), 4);
}

#[test]
fn compressed_files_are_refused_by_the_name_of_what_they_need() {
    let bytes = square_with(|json| json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]));
    let error = read(&bytes, Format::Glb, &Hints::default(), None).unwrap_err();
    assert_eq!(error.code(), "unsupported-extension");
    assert!(error.to_string().contains("KHR_draco_mesh_compression"), "{error}");
    assert_eq!(
        code(&square_with(|json| json["extensionsRequired"] = json!(["EXT_meshopt_compression"]))),
        "unsupported-extension"
    );
}

#[test]
fn accessors_that_reach_beyond_their_data_are_invalid() {
    for (pointer, value) in [
        ("/accessors/0/count", json!(5)),
        ("/accessors/0/byteOffset", json!(4)),
        ("/accessors/0/byteOffset", json!(u64::MAX)),
        ("/accessors/0/bufferView", json!(9)),
        ("/accessors/0/type", json!("VEC2")),
        ("/accessors/0/type", json!("MAT4")),
        ("/accessors/0/componentType", json!(1)),
        ("/accessors/1/count", json!(3)),
        ("/accessors/2/componentType", json!(5126)),
        ("/bufferViews/0/byteLength", json!(u64::MAX)),
        ("/bufferViews/0/byteOffset", json!(u64::MAX)),
        ("/bufferViews/0/byteStride", json!(4)),
        ("/bufferViews/0/byteStride", json!(u64::MAX)),
        ("/bufferViews/0/buffer", json!(1)),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(7)),
        ("/meshes/0/primitives/0/indices", json!(7)),
    ] {
        let bytes = square_with(|json| set(json, pointer, value.clone()));
        assert_eq!(code(&bytes), "invalid-accessor", "{pointer} = {value}");
    }
}

/// Sets a member, whether or not it is there.
fn set(json: &mut serde_json::Value, pointer: &str, value: serde_json::Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    json.pointer_mut(parent).unwrap()[key] = value;
}

#[test]
fn a_sparse_accessor_of_a_billion_elements_costs_nothing() {
    let bytes = square_with(|json| {
        json["accessors"][0] = json!({
            "componentType": 5126, "count": 1_000_000_000, "type": "VEC3",
            "sparse": {"count": 1_000_000_000, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 0}}
        });
    });
    assert_eq!(code(&bytes), "too-large");
    let more_sparse_than_elements = square_with(|json| {
        json["accessors"][0]["sparse"] = json!({"count": 5, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 0}});
    });
    assert_eq!(code(&more_sparse_than_elements), "invalid-accessor");
}

#[test]
fn a_sparse_index_beyond_its_accessor_is_out_of_range() {
    let bytes = square_with(|json| {
        json["accessors"][0]["sparse"] = json!({
            "count": 1, "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}
        });
    });
    assert_eq!(code(&bytes), "index-out-of-range");
}

#[test]
fn a_vertex_that_is_not_a_number_is_named() {
    for bad in [f32::NAN, f32::INFINITY] {
        let (json, mut binary) = square();
        binary[12..16].copy_from_slice(&floats(&[bad]));
        let error = read(&glb(&json, &binary), Format::Glb, &Hints::default(), None).unwrap_err();
        assert_eq!(error.code(), "non-finite-position");
        assert!(error.to_string().contains("vertex 1"), "{error}");
    }
    assert_eq!(
        code(&square_with(|json| json["nodes"][0]["scale"] = json!([1e38, 1e38, 1e38]))),
        "wrong-units"
    );
    assert_eq!(
        code(&square_with(|json| json["nodes"][0]["translation"] = json!([1e39, 0, 0]))),
        "non-finite-position"
    );
}

#[test]
fn indices_beyond_the_vertices_are_out_of_range() {
    let (json, mut binary) = square();
    binary[80] = 4;
    assert_eq!(code(&glb(&json, &binary)), "index-out-of-range");
    for (pointer, value) in [
        ("/nodes/0/mesh", json!(3)),
        ("/scenes/0/nodes/0", json!(3)),
        ("/scene", json!(3)),
        ("/meshes/0/primitives/0/material", json!(3)),
    ] {
        let bytes = square_with(|json| *json.pointer_mut(pointer).unwrap() = value);
        assert_eq!(code(&bytes), "index-out-of-range", "{pointer}");
    }
}

#[test]
fn points_lines_and_empty_scenes_have_no_triangles() {
    for mode in [0, 1, 2, 3] {
        let bytes = square_with(|json| json["meshes"][0]["primitives"][0]["mode"] = mode.into());
        assert_eq!(code(&bytes), "no-triangles", "mode {mode}");
    }
    assert_eq!(code(&glb(&json!({"asset": {"version": "2.0"}}), &[])), "no-triangles");
    assert_eq!(code(&square_with(|json| json["scenes"][0]["nodes"] = json!([]))), "no-triangles");
}

#[test]
fn node_graphs_that_are_no_trees_are_refused() {
    let child = |parent: usize, child: usize| {
        square_with(move |json| {
            json["nodes"] = json!([{"mesh": 0}, {}]);
            json["nodes"][parent]["children"] = json!([child]);
            json["scenes"][0]["nodes"] = json!([0, 1]);
        })
    };
    assert_eq!(code(&child(0, 0)), "not-a-mesh");
    assert_eq!(code(&child(1, 0)), "not-a-mesh");
    let cycle_without_scene = square_with(|json| {
        json["nodes"] = json!([{"mesh": 0, "children": [1]}, {"children": [0]}]);
        json.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
    });
    assert_eq!(code(&cycle_without_scene), "not-a-mesh");
}

#[test]
fn thousands_of_changed_bytes_never_panic() {
    let bytes = square_with(|json| {
        json["accessors"][0]["sparse"] = json!({"count": 1, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 0}});
    });
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state as usize
    };
    let mut read_anyway = 0;
    for _ in 0..6_000 {
        let mut changed = bytes.clone();
        for _ in 0..1 + next() % 4 {
            let at = next() % changed.len();
            changed[at] = next() as u8;
        }
        if next() % 8 == 0 {
            changed.truncate(next() % changed.len());
        }
        read_anyway += usize::from(code(&changed) == "read");
    }
    assert!((1..6_000).contains(&read_anyway), "{read_anyway} read");
}
