#![allow(clippy::unwrap_used)]

use base64::Engine;
use serde_json::json;
use toile_gltf::{Format, MAX_BYTES, preflight};

use crate::support::{code, square_with};

#[test]
fn deep_trees_and_long_lists_are_too_large() {
    let chain = |length: usize| {
        square_with(move |json| {
            let parents = (1..length).map(|next| json!({"children": [next]}));
            json["nodes"] = parents.chain([json!({"mesh": 0})]).collect();
        })
    };
    assert_eq!(code(&chain(64)), "read");
    assert_eq!(code(&chain(65)), "too-large");
    assert_eq!(code(&square_with(|json| json["nodes"] = vec![json!({}); 5000].into())), "too-large");
    assert_eq!(code(&square_with(|json| json["images"] = vec![json!({}); 65].into())), "too-large");
    let primitive = json!({"attributes": {"POSITION": 0}, "mode": 0});
    let many = square_with(|json| json["meshes"][0]["primitives"] = vec![primitive; 5000].into());
    assert_eq!(code(&many), "too-large");
}

#[test]
fn vertices_count_once_for_every_node_that_shows_them() {
    let shown = |times: usize| {
        square_with(move |json| {
            json["accessors"][0] = json!({"componentType": 5126, "count": 100_000, "type": "VEC3"});
            json["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
            json["nodes"] = vec![json!({"mesh": 0}); times].into();
            json["scenes"][0]["nodes"] = (0..times).collect::<Vec<_>>().into();
        })
    };
    assert_eq!(code(&shown(3)), "too-large");
    assert_ne!(code(&shown(2)), "too-large");
}

#[test]
fn a_file_over_the_byte_cap_is_too_large_before_it_is_looked_at() {
    let bytes = vec![0; MAX_BYTES + 1];
    assert_eq!(preflight(&bytes, Format::Glb).unwrap_err().code(), "too-large");
}

#[test]
fn a_picture_larger_than_the_cap_is_too_large_and_a_broken_one_is_left_out() {
    let with_image = |bytes: &[u8]| {
        let data = base64::engine::general_purpose::STANDARD.encode(bytes);
        square_with(|json| {
            json["images"] = json!([{"uri": format!("data:image/png;base64,{data}")}]);
            json["textures"] = json!([{"source": 0}]);
            json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
        })
    };
    let mut header = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    header.extend([0, 0, 0x40, 0, 0, 0, 0x40, 0, 8, 6, 0, 0, 0]);
    header.extend(crc32(&header[12..]).to_be_bytes());
    assert_eq!(code(&with_image(&[header, b"\0\0\0\0IDAT\x35\xaf\x06\x1e".to_vec()].concat())), "too-large");
    let source = crate::support::read_glb(&with_image(b"\x89PNG\r\n\x1a\n junk")).unwrap();
    assert_eq!(source.materials[0].base_color_picture, None);
    assert!(source.report.notes.iter().any(|note| note.contains("Image 0")), "{:?}", source.report.notes);
}

/// CRC of PNG chunks (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
}
