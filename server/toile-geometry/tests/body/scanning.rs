//! Bodies found again from meshes of them.

use std::sync::Arc;

use glam::Vec3;
use toile_geometry::body::{BodyShape, Detail};
use toile_geometry::measurements::{Measurement, measure};
use toile_geometry::mesh::Mesh;
use toile_geometry::nearest::PointTree;
use toile_geometry::normals::vertex_normals;
use toile_geometry::scan::{ScanError, fit};

use super::body;

fn shape(values: &[(&str, f32)]) -> BodyShape {
    let values = values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    BodyShape::from_values(body(), &values).unwrap()
}

fn mesh(shape: &BodyShape) -> Mesh {
    Mesh { positions: body().shape(shape).apose_vertices, triangles: body().triangles().to_vec() }
}

/// Every girth and length of the body of `scan` within `cm` of what `shape` measures.
#[track_caller]
fn assert_found(scan: &Mesh, shape: &BodyShape, cm: f32) {
    let found = fit(body(), scan).unwrap();
    let (got, due) = (measure(body(), &body().shape(&found.shape)), measure(body(), &body().shape(shape)));
    for measurement in Measurement::ALL.into_iter().filter(|m| *m != Measurement::Weight) {
        let (got, due) = (got.get(measurement), due.get(measurement));
        assert!((got - due).abs() < cm, "{}: {got} instead of {due} cm, {found:?}", measurement.name());
    }
}

#[test]
fn a_body_is_found_again_from_its_own_surface() {
    for values in [
        &[("gender", 1.0), ("weight", 0.8), ("height", 0.3)][..],
        &[("gender", 0.1), ("weight", 0.3), ("height", 0.7), ("muscle", 0.8)],
    ] {
        let shape = shape(values);
        assert_found(&mesh(&shape), &shape, 0.8);
    }
}

#[test]
fn noise_holes_other_triangles_and_another_place_do_not_matter() {
    let shape = shape(&[("gender", 0.8), ("weight", 0.6)]);
    let mut scan = mesh(&shape);
    // Every triangle turned over, one in seven missing, a hole in the back; noise of 2 mm; half a metre aside.
    let hole = |t: &[u32; 3]| scan.positions[t[0] as usize].distance(Vec3::new(0.0, 1.25, -0.12)) < 0.08;
    let kept = scan.triangles.iter().enumerate().filter(|(k, t)| k % 7 != 0 && !hole(t));
    let triangles = kept.map(|(_, [a, b, c])| [*a, *c, *b]).collect();
    let noise =
        |k: usize| Vec3::new((k as f32 * 0.7).sin(), (k as f32 * 1.3).cos(), (k as f32 * 2.1).sin()) * 0.002;
    let moved = |(k, p): (usize, &Vec3)| *p + noise(k) + Vec3::new(0.5, 0.02, -0.3);
    scan = Mesh { positions: scan.positions.iter().enumerate().map(moved).collect(), triangles };
    assert_found(&scan, &shape, 1.5);
}

#[test]
fn a_body_is_found_again_from_loose_triangles_whose_noise_tilts_them() {
    for values in [
        &[("gender", 0.2), ("age", 0.85), ("weight", 0.7), ("measure-upperleg-height-incr", 0.3)][..],
        &[
            ("gender", 0.9),
            ("age", 0.55),
            ("muscle", 0.7),
            ("height", 0.3),
            ("measure-waist-circ-incr", -0.3),
        ],
    ] {
        let off = off_from_loose_triangles(&shape(values));
        assert!(off < 4e-3, "every vertex {off} m from its own, on average");
    }
}

#[test]
fn a_slight_body_is_not_taken_for_a_muscular_one_with_narrowed_limbs() {
    let off = off_from_loose_triangles(&shape(&[
        ("gender", 0.22),
        ("muscle", 0.26),
        ("weight", 0.08),
        ("height", 0.63),
        ("proportions", 0.1),
        ("age", 0.64),
        ("measure-hips-circ-incr", -0.18),
        ("measure-thigh-circ-incr", 0.22),
        ("measure-bust-circ-incr", -0.18),
    ]));
    assert!(off < 4e-3, "every vertex {off} m from its own, on average");
}

/// How far every vertex lies from its own on average, metres, in the body found from every second triangle of a body
/// with corners of its own, each 2 mm off along every axis as a hash has it.
fn off_from_loose_triangles(shape: &BodyShape) -> f32 {
    let truth = mesh(shape);
    let noise = |k: usize| (k as f32 * 12.9898).sin() * 43_758.547 % 1.0 * 0.0034;
    let corners = truth.triangles.iter().step_by(2).flatten().enumerate();
    let positions: Vec<Vec3> = corners
        .map(|(k, &i)| truth.positions[i as usize] + Vec3::from_array([0, 1, 2].map(|a| noise(3 * k + a))))
        .collect();
    let triangles = (0..positions.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let found = fit(body(), &Mesh { positions, triangles }).unwrap();
    let detail = Some(Arc::new(Detail { id: "scan".to_owned(), offsets: found.offsets }));
    let got = body().shape(&BodyShape { detail, ..found.shape }).apose_vertices;
    got.iter().zip(&truth.positions).map(|(a, b)| a.distance(*b)).sum::<f32>() / got.len() as f32
}

#[test]
fn the_detail_puts_the_body_on_the_scan() {
    // A belly that the parameters do not know, 4 cm deep.
    let average = body().shape(&BodyShape::default());
    let middle = Vec3::new(0.0, 1.12, 0.12);
    let bulge = |p: &Vec3| *p + Vec3::Z * 0.04 * (-p.distance_squared(middle) / 0.012).exp();
    let scan = Mesh {
        positions: average.apose_vertices.iter().map(bulge).collect(),
        triangles: body().triangles().to_vec(),
    };
    let found = fit(body(), &scan).unwrap();
    let detail = Some(Arc::new(Detail { id: "scan".to_owned(), offsets: found.offsets.clone() }));
    let detailed = BodyShape { detail, ..found.shape.clone() };
    let tree = PointTree::new(&scan.positions, |_| true).unwrap();
    let normals = vertex_normals(&scan.positions, &scan.triangles);
    let off = |shape: &BodyShape| {
        let lack = |p: Vec3| {
            let hit = tree.nearest(p).index as usize;
            (p - scan.positions[hit]).dot(normals[hit]).abs()
        };
        let vertices = body().shape(shape).apose_vertices;
        let near: Vec<f32> =
            vertices.iter().filter(|p| p.distance(middle) < 0.15).map(|p| lack(*p)).collect();
        near.iter().sum::<f32>() / near.len() as f32
    };
    let (plain, exact) = (off(&found.shape), off(&detailed));
    assert!(exact < 0.3 * plain && exact < 3e-3, "{exact} m off with the detail, {plain} m without");
    assert_ne!(detailed, found.shape, "another body for every cache");
    let waist = |shape: &BodyShape| measure(body(), &body().shape(shape)).get(Measurement::Waist);
    let worn = waist(&detailed);
    assert!(worn > waist(&BodyShape::default()) + 1.0, "the tape goes around the belly: {worn} cm");
}

#[test]
fn a_scan_may_face_any_way() {
    let shape = shape(&[("gender", 0.9), ("weight", 0.55), ("height", 0.4)]);
    for angle in [0.5_f32, 1.4, 3.0, -1.9] {
        let turn = glam::Mat3::from_rotation_y(angle);
        let scan = mesh(&shape);
        let turned = Mesh { positions: scan.positions.iter().map(|p| turn * *p).collect(), ..scan };
        assert_found(&turned, &shape, 1.5);
    }
}

#[test]
fn what_is_no_person_is_refused() {
    let person = mesh(&BodyShape::default());
    let scaled = |factor: f32| Mesh {
        positions: person.positions.iter().map(|p| *p * factor).collect(),
        triangles: person.triangles.clone(),
    };
    assert!(matches!(fit(body(), &scaled(0.01)), Err(ScanError::Height { .. })));
    let mut wild = person.clone();
    wild.positions[7] = Vec3::new(3e38, 1.0, -3e38);
    assert!(matches!(fit(body(), &wild), Err(ScanError::Height { .. })));
    let few = Mesh { positions: person.positions[..100].to_vec(), triangles: Vec::new() };
    assert_eq!(fit(body(), &few), Err(ScanError::TooCoarse { found: 100 }));
    let points = Mesh { triangles: Vec::new(), ..person.clone() };
    assert_eq!(fit(body(), &points), Err(ScanError::NoTriangles));
    let stretched = person.positions.iter().map(|p| *p * Vec3::new(0.2, 1.0, 3.0)).collect();
    let board = Mesh { positions: stretched, triangles: person.triangles.clone() };
    assert!(matches!(fit(body(), &board), Err(ScanError::NotABody { .. })), "{:?}", fit(body(), &board));
}
