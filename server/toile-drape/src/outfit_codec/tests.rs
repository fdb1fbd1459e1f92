#![allow(clippy::unwrap_used)]

use glam::Vec2;

use super::*;

fn outfit() -> Outfit {
    let picture = Picture { mime_type: "image/png".into(), bytes: vec![1, 2, 3] };
    Outfit {
        name: "Ärmel".into(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        garments: vec![Garment {
            name: "shirt".into(),
            layer: 1,
            vertices: 0..3,
            drawn_vertices: 0..4,
            parts: vec![Part { material: 0, triangles: 0..1 }],
        }],
        surface: Surface {
            vertex_of: vec![0, 1, 2, 2],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE],
            triangles: vec![[0, 1, 3]],
        },
        materials: vec![Material {
            base_color_picture: Some(picture),
            uv_transform: Some(UvTransform { offset: [0.1, 0.2], rotation: 0.3, scale: [4.0, 5.0] }),
            alpha_cutoff: Some(0.5),
            ..Material::default()
        }],
    }
}

#[test]
fn an_outfit_comes_back_as_it_was_stored() {
    assert_eq!(from_bytes(&to_bytes(&outfit())), Ok(outfit()));
}

#[test]
fn bytes_cut_anywhere_or_continued_are_refused() {
    let bytes = to_bytes(&outfit());
    for length in 0..bytes.len() {
        assert!(from_bytes(&bytes[..length]).is_err(), "cut at {length}");
    }
    let longer = [bytes.as_slice(), &[0]].concat();
    assert_eq!(from_bytes(&longer), Err(CodecError::Length));
}

#[test]
fn an_index_that_points_nowhere_is_refused() {
    let mut broken = outfit();
    broken.triangles[0][2] = 3;
    assert_eq!(from_bytes(&to_bytes(&broken)), Err(CodecError::Inconsistent));
}

#[test]
fn changed_bytes_never_panic_and_never_give_indices_out_of_range() {
    let bytes = to_bytes(&outfit());
    let mut state = 0x9e37_79b9_u32;
    for _ in 0..20_000 {
        let mut changed = bytes.clone();
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let at = state as usize % changed.len();
        changed[at] = (state >> 24) as u8;
        if let Ok(read) = from_bytes(&changed) {
            assert!(is_consistent(&read));
        }
    }
}
