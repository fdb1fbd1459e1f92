#![allow(clippy::unwrap_used)]

use glam::{Vec2, Vec3};
use toile_drape::outfit_build::OutfitSource;
use toile_gltf::{Format, Hints, ReadError, read};

fn read_obj(text: &str) -> Result<OutfitSource, ReadError> {
    read(text.as_bytes(), Format::Obj, &Hints::default(), None)
}

const QUAD: &str = "v -0.1 1.2 0.2\nv 0.1 1.2 0.2\nv 0.1 1.4 0.2\nv -0.1 1.4 0.2\n";

#[test]
fn polygons_become_fans_and_windows_lines_and_comments_are_fine() {
    let text = format!("# square\n{QUAD}f 1 2 3 4 # all\n").replace('\n', "\r\n");
    let mesh = read_obj(&text).unwrap().meshes.remove(0);
    assert_eq!(mesh.positions[2], Vec3::new(0.1, 1.4, 0.2));
    assert_eq!(mesh.parts[0].triangles, vec![[0, 1, 2], [0, 2, 3]]);
    assert!(mesh.uvs.is_empty());
}

#[test]
fn negative_indices_count_from_the_end_and_uvs_from_the_top() {
    let text = format!("{QUAD}vt 0 0\nvt 1 0.25\nf -4/-2 -3/-1 -2/-1\n");
    let mesh = read_obj(&text).unwrap().meshes.remove(0);
    assert_eq!(mesh.parts[0].triangles, vec![[0, 1, 2]]);
    assert_eq!(mesh.uvs, vec![Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.75), Vec2::new(1.0, 0.75)]);
}

#[test]
fn a_vertex_with_two_uvs_is_drawn_twice() {
    let text = format!("{QUAD}vt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 1/2 3/2 4/2\n");
    assert_eq!(read_obj(&text).unwrap().meshes[0].positions.len(), 6);
}

#[test]
fn objects_are_meshes_unless_they_share_vertices() {
    let second = "v -0.1 0.2 0.2\nv 0.1 0.2 0.2\nv 0.1 0.4 0.2\n";
    let apart = format!("o shirt\n{QUAD}f 1 2 3\no skirt\n{second}f 5 6 7\n");
    let names: Vec<String> = read_obj(&apart).unwrap().meshes.into_iter().map(|mesh| mesh.name).collect();
    assert_eq!(names, ["shirt", "skirt"]);
    let sewn = format!("{QUAD}g front\nf 1 2 3\ng back\nf 1 3 4\n");
    assert_eq!(read_obj(&sewn).unwrap().meshes.len(), 1);
}

#[test]
fn materials_split_a_mesh_into_parts() {
    let text = format!("{QUAD}usemtl denim\nf 1 2 3\nusemtl linen\nf 1 3 4\n");
    let source = read_obj(&text).unwrap();
    assert_eq!(source.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["denim", "linen"]);
    assert_eq!(source.meshes[0].parts.len(), 2);
}

#[test]
fn bad_lines_have_their_own_codes() {
    for (line, code) in [
        ("f 1 2 5", "index-out-of-range"),
        ("f 0 1 2", "index-out-of-range"),
        ("f -5 1 2", "index-out-of-range"),
        ("f 1/1 2/1 3/1", "index-out-of-range"),
        ("f 99999999999999999999 1 2", "not-a-mesh"),
        ("f a b c", "not-a-mesh"),
        ("v 1 2", "not-a-mesh"),
        ("v nan 0 0", "non-finite-position"),
        ("v 1e99 0 0", "non-finite-position"),
        ("l 1 2", "no-triangles"),
        ("f 1 2", "no-triangles"),
    ] {
        assert_eq!(read_obj(&format!("{QUAD}{line}\n")).unwrap_err().code(), code, "{line}");
    }
    assert_eq!(read_obj("# nothing\n").unwrap_err().code(), "not-a-mesh");
}

#[test]
fn a_polygon_of_half_a_million_corners_is_too_large() {
    let text = format!("{QUAD}f{}\n", " 1 2 3".repeat(200_000));
    assert_eq!(read_obj(&text).unwrap_err().code(), "too-large");
    assert_eq!(read_obj(&"v 0 1 0\n".repeat(200_001)).unwrap_err().code(), "too-large");
}
