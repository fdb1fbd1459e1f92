#![allow(clippy::unwrap_used)]

use glam::{Vec2, Vec3};

use super::{OutfitError, OutfitSource, build};
use crate::outfit::{Material, Outfit, RawMesh, RawPart, Report};

/// A cylinder around the Y axis, wound outwards.
fn tube(radius: f32, low: f32, high: f32) -> RawMesh {
    const SIDES: u32 = 32;
    const RINGS: u32 = 16;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for ring in 0..=RINGS {
        let y = low + (high - low) * ring as f32 / RINGS as f32;
        for side in 0..SIDES {
            let angle = std::f32::consts::TAU * side as f32 / SIDES as f32;
            positions.push(Vec3::new(radius * angle.sin(), y, radius * angle.cos()));
        }
    }
    for ring in 0..RINGS {
        for side in 0..SIDES {
            let (a, b) = (ring * SIDES + side, ring * SIDES + (side + 1) % SIDES);
            triangles.extend([[a, b, b + SIDES], [a, b + SIDES, a + SIDES]]);
        }
    }
    mesh("", positions, triangles)
}

fn mesh(name: &str, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> RawMesh {
    RawMesh { name: name.into(), positions, uvs: vec![], parts: vec![RawPart { triangles, material: None }] }
}

fn named(name: &str, mesh: RawMesh) -> RawMesh {
    RawMesh { name: name.into(), ..mesh }
}

/// One mesh of the triangles of two.
fn joined(mut first: RawMesh, second: &RawMesh) -> RawMesh {
    let shift = first.positions.len() as u32;
    first.positions.extend(&second.positions);
    let more = second.parts[0].triangles.iter().map(|t| t.map(|corner| corner + shift));
    first.parts[0].triangles.extend(more);
    first
}

fn on_body(source: OutfitSource) -> Result<(Outfit, Report), OutfitError> {
    let body = tube(0.15, 0.0, 1.84);
    build(source, &body.positions, &body.parts[0].triangles)
}

fn built(meshes: Vec<RawMesh>) -> (Outfit, Report) {
    on_body(OutfitSource { meshes, ..OutfitSource::default() }).unwrap()
}

fn refused(meshes: Vec<RawMesh>) -> OutfitError {
    on_body(OutfitSource { meshes, ..OutfitSource::default() }).unwrap_err()
}

fn names(outfit: &Outfit) -> Vec<&str> {
    outfit.garments.iter().map(|garment| garment.name.as_str()).collect()
}

#[test]
fn a_clean_garment_stays_as_it_is() {
    let shirt = named("shirt", tube(0.2, 1.0, 1.5));
    let (outfit, report) = built(vec![shirt.clone()]);
    assert_eq!((&outfit.positions, &outfit.triangles), (&shirt.positions, &shirt.parts[0].triangles));
    assert_eq!((outfit.name.as_str(), names(&outfit)), ("shirt", vec!["shirt"]));
    assert_eq!(outfit.materials, vec![Material::default()]);
    assert_eq!(report, Report { components: 1, ..Report::default() });
}

#[test]
fn vertices_at_one_place_are_welded_and_still_drawn_apart() {
    let mut shirt = tube(0.2, 1.0, 1.5);
    let copy = shirt.positions.len() as u32;
    shirt.positions.push(shirt.positions[40] + Vec3::splat(1e-6));
    shirt.uvs = shirt.positions.iter().map(|p| Vec2::new(p.x, p.y)).collect();
    let corner = shirt.parts[0].triangles.iter_mut().flatten().find(|corner| **corner == 40).unwrap();
    *corner = copy;
    let (outfit, report) = built(vec![shirt]);
    assert_eq!(report.welded_vertices, 1);
    assert_eq!(outfit.surface.vertex_of[copy as usize], 40);
    assert_eq!(outfit.surface.uvs.len(), outfit.positions.len() + 1);
    let welded = |t: &[u32; 3]| t.map(|corner| outfit.surface.vertex_of[corner as usize]);
    assert_eq!(outfit.surface.triangles.iter().map(welded).collect::<Vec<_>>(), outfit.triangles);
}

#[test]
fn faces_without_area_and_faces_that_are_there_twice_are_dropped() {
    let mut shirt = tube(0.2, 1.0, 1.5);
    let faces = shirt.parts[0].triangles.len();
    let [a, b, c] = shirt.parts[0].triangles[7];
    shirt.parts[0].triangles.extend([[a, a, b], [a, c, b], [b, c, a]]);
    let (outfit, report) = built(vec![shirt]);
    assert_eq!((report.degenerate_faces_removed, report.duplicate_faces_removed), (1, 2));
    assert_eq!(outfit.triangles.len(), faces);
}

#[test]
fn vertices_that_no_face_uses_are_left_out() {
    let mut shirt = tube(0.2, 1.0, 1.5);
    shirt.positions.insert(0, Vec3::new(0.0, 50.0, 0.0));
    shirt.parts[0].triangles.iter_mut().flatten().for_each(|corner| *corner += 1);
    let (outfit, _) = built(vec![shirt.clone()]);
    assert_eq!(outfit.positions, shirt.positions[1..]);
}

#[test]
fn an_inside_out_garment_is_turned_and_mixed_windings_agree() {
    let shirt = tube(0.2, 1.0, 1.5);
    let expected = built(vec![shirt.clone()]).0.triangles;
    for every in [1, 3] {
        let mut turned = shirt.clone();
        turned.parts[0].triangles.iter_mut().step_by(every).for_each(|t| t.swap(1, 2));
        let (outfit, report) = built(vec![turned]);
        assert_eq!(outfit.triangles, expected);
        assert_eq!(report.flipped_normals, expected.len().div_ceil(every));
    }
}

#[test]
fn a_closed_piece_is_wound_by_its_volume() {
    // The inner wall of a double shell looks at the body, as it should.
    let (outer, inner) = (tube(0.22, 1.0, 1.5), tube(0.2, 1.0, 1.5));
    let count = outer.positions.len() as u32;
    let mut shell = joined(outer, &inner);
    let wall = shell.parts[0].triangles.len() / 2;
    shell.parts[0].triangles[wall..].iter_mut().for_each(|t| t.swap(1, 2));
    for rim in [0, count - 32] {
        for side in 0..32 {
            let (a, b) = (rim + side, rim + (side + 1) % 32);
            let quad = [[a, a + count, b + count], [a, b + count, b]];
            shell.parts[0]
                .triangles
                .extend(quad.map(|[p, q, r]| if rim == 0 { [p, q, r] } else { [p, r, q] }));
        }
    }
    assert_eq!(built(vec![shell.clone()]).1.flipped_normals, 0);
    let faces = shell.parts[0].triangles.len();
    shell.parts[0].triangles.iter_mut().for_each(|t| t.swap(1, 2));
    assert_eq!(built(vec![shell]).1.flipped_normals, faces);
}

#[test]
fn edges_of_three_faces_are_counted() {
    let mut shirt = tube(0.2, 1.0, 1.5);
    let [a, b, _] = shirt.parts[0].triangles[100];
    let fin = shirt.positions.len() as u32;
    shirt.positions.push(Vec3::new(0.4, 1.2, 0.0));
    shirt.parts[0].triangles.push([a, b, fin]);
    assert_eq!(built(vec![shirt]).1.non_manifold_edges, 1);
}

#[test]
fn large_pieces_of_one_mesh_are_garments_and_small_ones_go_with_the_nearest() {
    let button = |y: f32| {
        let at = |x: f32, z: f32| Vec3::new(x, y + z, 0.23);
        mesh("", vec![at(0.0, 0.0), at(0.01, 0.0), at(0.0, 0.01)], vec![[0, 1, 2]])
    };
    let suit = joined(joined(joined(tube(0.2, 1.1, 1.5), &tube(0.21, 0.1, 1.0)), &button(1.3)), &button(0.9));
    let (outfit, report) = built(vec![named("suit", suit)]);
    assert_eq!(names(&outfit), ["suit", "suit-2"]);
    assert_eq!(report.components, 4);
    assert!(report.notes.iter().any(|note| note.starts_with('2')), "{:?}", report.notes);
    let trousers = tube(0.21, 0.1, 1.0);
    assert_eq!(outfit.garments[0].vertices.len(), trousers.positions.len() + 3);
    assert_eq!(outfit.garments[1].vertices.len(), trousers.positions.len() + 3);
    for garment in &outfit.garments {
        let range = garment.triangles();
        let triangles = &outfit.triangles[range.start as usize..range.end as usize];
        assert!(triangles.iter().flatten().all(|corner| garment.vertices.contains(corner)));
    }
}

#[test]
fn a_tie_goes_with_the_shirt_that_it_lies_on_though_its_tip_touches_the_trousers() {
    let rows = 8_u32;
    let at = |i: u32| {
        Vec3::new((i % 2) as f32 * 0.02, 1.4 - 0.06 * (i / 2) as f32, 0.23 - 0.0025 * (i / 2) as f32)
    };
    let strips = (0..rows - 1).map(|r| 2 * r).flat_map(|a| [[a, a + 2, a + 1], [a + 1, a + 2, a + 3]]);
    let tie = mesh("", (0..2 * rows).map(at).collect(), strips.collect());
    let (outfit, _) =
        built(vec![named("suit", joined(joined(tube(0.2, 1.1, 1.5), &tube(0.21, 0.1, 1.05)), &tie))]);
    let shirt =
        outfit.garments.iter().find(|g| outfit.positions[g.vertices.start as usize].y > 1.06).unwrap();
    assert_eq!(shirt.vertices.len(), tube(0.2, 1.1, 1.5).positions.len() + 16);
}

#[test]
fn names_are_unique_never_empty_and_never_the_bodys() {
    let low = |name| named(name, tube(0.2, 0.2, 0.6));
    let high = |name| named(name, tube(0.2, 0.9, 1.3));
    assert_eq!(names(&built(vec![high("shirt"), low("shirt")]).0), ["shirt", "shirt-2"]);
    assert_eq!(names(&built(vec![high(" \u{7}"), low("body")]).0), ["garment", "body-2"]);
    let third = named("shirt-2", tube(0.2, 1.4, 1.7));
    assert_eq!(names(&built(vec![high("shirt"), low("shirt"), third]).0), ["shirt", "shirt-3", "shirt-2"]);
}

#[test]
fn the_garment_nearer_to_the_body_is_the_inner_one() {
    let jacket = named("jacket", tube(0.24, 1.0, 1.5));
    let shirt = named("shirt", tube(0.22, 0.9, 1.5));
    let vest = named("vest", tube(0.2, 1.0, 1.4));
    let socks = named("socks", tube(0.17, 0.0, 0.2));
    let (outfit, _) = built(vec![jacket, shirt, vest, socks]);
    let layers: Vec<(&str, u32)> = outfit.garments.iter().map(|g| (g.name.as_str(), g.layer)).collect();
    assert_eq!(layers, [("vest", 0), ("socks", 0), ("shirt", 1), ("jacket", 2)]);
}

#[test]
fn stated_layers_win_and_must_name_garments() {
    let meshes = vec![named("shirt", tube(0.2, 1.0, 1.5)), named("trousers", tube(0.22, 0.2, 1.1))];
    let with = |layers: &[&str]| {
        let layers = layers.iter().map(|name| (*name).to_owned()).collect();
        on_body(OutfitSource { meshes: meshes.clone(), layers, ..OutfitSource::default() })
    };
    assert_eq!(names(&with(&["shirt", "trousers"]).unwrap().0), ["shirt", "trousers"]);
    assert_eq!(names(&with(&["trousers", "shirt"]).unwrap().0), ["trousers", "shirt"]);
    let unknown = with(&["shirt", "hat"]).unwrap_err();
    assert_eq!((unknown.code(), unknown.pointer().as_deref()), ("invalid-field", Some("/layers/1")));
    assert!(unknown.to_string().contains("shirt, trousers"), "{unknown}");
    assert_eq!(with(&["shirt", "shirt"]).unwrap_err().code(), "invalid-field");
}

#[test]
fn vertices_inside_the_body_are_counted() {
    let share = |radius| built(vec![tube(radius, 1.0, 1.5)]).1.rest_penetration_percent;
    assert_eq!((share(0.2), share(0.14)), (0.0, 100.0));
}

#[test]
fn a_garment_that_passes_through_itself_is_reported() {
    let share = |z: f32| {
        let mut shirt = tube(0.2, 1.0, 1.5);
        shirt.positions[0] = Vec3::new(0.0, 1.01, z);
        built(vec![shirt]).1.self_crossed_percent
    };
    assert_eq!(share(0.2), 0.0);
    assert!(share(-0.25) > 0.0, "a vertex drawn through the opposite side");
}

#[test]
fn an_outfit_beside_the_body_or_under_the_floor_is_off_body() {
    let moved = |by: Vec3| {
        let mut shirt = tube(0.2, 1.0, 1.5);
        shirt.positions.iter_mut().for_each(|p| *p += by);
        refused(vec![shirt])
    };
    for by in [Vec3::X * 2.0, Vec3::Y * 3.0, Vec3::Z * 1e6, Vec3::NEG_Y * 1.3] {
        assert_eq!(moved(by).code(), "off-body", "{by}");
    }
}

#[test]
fn an_outfit_of_the_wrong_size_has_wrong_units() {
    for factor in [0.01, 100.0] {
        let mut shirt = tube(0.2, 1.0, 1.5);
        shirt.positions.iter_mut().for_each(|p| *p *= factor);
        assert_eq!(refused(vec![shirt]).code(), "wrong-units", "{factor}");
    }
}

#[test]
fn broken_meshes_have_their_own_codes() {
    let shirt = tube(0.2, 1.0, 1.5);
    let broken = |change: &dyn Fn(&mut RawMesh)| {
        let mut mesh = shirt.clone();
        change(&mut mesh);
        refused(vec![mesh]).code()
    };
    assert_eq!(broken(&|mesh| mesh.positions[3].y = f32::NAN), "non-finite-position");
    assert_eq!(broken(&|mesh| mesh.parts[0].triangles[3][1] = 1 << 30), "index-out-of-range");
    assert_eq!(broken(&|mesh| mesh.parts[0].material = Some(0)), "index-out-of-range");
    assert_eq!(broken(&|mesh| mesh.uvs = vec![Vec2::ZERO]), "index-out-of-range");
    assert_eq!(broken(&|mesh| mesh.parts[0].triangles = vec![[0, 0, 1]]), "no-triangles");
    assert_eq!(refused(vec![]).code(), "no-triangles");
    let many = (0..25).map(|k| tube(0.2, 0.06 * k as f32, 0.06 * k as f32 + 0.05)).collect();
    assert_eq!(refused(many).code(), "too-large");
}

#[test]
fn a_soup_of_loose_triangles_is_one_garment() {
    let tube = tube(0.2, 1.0, 1.5);
    let positions = tube.parts[0].triangles.iter().flatten().enumerate();
    let positions: Vec<Vec3> = positions
        .map(|(i, corner)| tube.positions[*corner as usize] * (1.0 + (i / 3) as f32 * 1e-4))
        .collect();
    let triangles = (0..positions.len() as u32 / 3).map(|t| [t * 3, t * 3 + 1, t * 3 + 2]).collect();
    let (outfit, report) = built(vec![mesh("soup", positions, triangles)]);
    assert_eq!((outfit.garments.len(), report.components), (1, 1024));
}

#[test]
fn triangles_are_sorted_by_material_and_unused_materials_left_out() {
    let mut shirt = tube(0.2, 1.0, 1.5);
    let back = shirt.parts[0].triangles.split_off(500);
    shirt.parts[0].material = Some(2);
    shirt.parts.push(RawPart { triangles: back, material: Some(0) });
    let materials =
        ["back", "unused", "front"].map(|name| Material { name: name.into(), ..Material::default() });
    let source =
        OutfitSource { meshes: vec![shirt], materials: materials.to_vec(), ..OutfitSource::default() };
    let outfit = on_body(source).unwrap().0;
    assert_eq!(outfit.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["back", "front"]);
    let parts = &outfit.garments[0].parts;
    assert_eq!((parts[0].material, parts[0].triangles.len()), (0, 524));
    assert_eq!((parts[1].material, parts[1].triangles.clone()), (1, 524..1024));
}
