//! Uploads that are refused: each with its own code, and nothing is kept of any of them.

use serde_json::{Value, json};
use toile_tests::{Answer, Form, Mesh, Server, glb_of_json, skirt};

/// Uploads a file that must be refused, and asserts that nothing of it is left.
#[track_caller]
fn refused(server: &Server, name: &str, bytes: &[u8]) -> Answer {
    refused_form(server, &Form::file(name, bytes))
}

#[track_caller]
fn refused_form(server: &Server, form: &Form) -> Answer {
    let answer = server.upload(form);
    assert!(answer.status >= 400, "it was taken: {}", answer.text());
    assert_eq!(server.get("/v1/outfits").json()["data"], json!([]));
    for folder in ["outfits", "static", "thumbnails"] {
        assert!(server.files(folder).is_empty(), "{folder} has files after {}", answer.text());
    }
    answer
}

fn skirt_with(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    skirt(1.0).glb_with(change)
}

#[test]
fn a_file_of_no_known_format_is_refused() {
    let answer = refused(&Server::start(), "a.fbx", b"Kaydara FBX Binary  \0\x1a\0 and so on");
    answer.assert_problem(415, "unsupported-media-type", Some("/file"));
}

#[test]
fn a_file_that_only_claims_to_be_a_mesh_is_refused() {
    let server = Server::start();
    refused(&server, "a.glb", b"\x89PNG\r\n\x1a\n rather a picture").assert_problem(
        422,
        "not-a-mesh",
        Some("/file"),
    );
    refused(&server, "a.gltf", br#"{"asset": "none", "meshes": 3}"#).assert_problem(
        422,
        "not-a-mesh",
        Some("/file"),
    );
}

#[test]
fn a_truncated_glb_is_refused_wherever_it_ends() {
    let server = Server::start();
    let glb = skirt(1.0).glb();
    for length in [2, 11, 19, 200, glb.len() / 2, glb.len() - 1] {
        refused(&server, "a.glb", &glb[..length]).assert_problem(422, "truncated", Some("/file"));
    }
}

#[test]
fn a_reference_to_another_file_is_refused_and_not_followed() {
    let server = Server::start();
    for uri in ["other.bin", "file:///etc/passwd", "/etc/passwd", "http://127.0.0.1:1/a.bin", "%zz"] {
        let glb = skirt_with(|json| json["buffers"][0]["uri"] = json!(uri));
        refused(&server, "a.glb", &glb).assert_problem(422, "external-uri", Some("/file"));
    }
}

#[test]
fn a_required_extension_that_is_not_supported_is_refused() {
    let glb = skirt_with(|json| {
        json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    });
    refused(&Server::start(), "a.glb", &glb).assert_problem(422, "unsupported-extension", Some("/file"));
}

#[test]
fn an_accessor_beyond_its_buffer_is_refused() {
    let server = Server::start();
    let too_many = skirt_with(|json| json["accessors"][0]["count"] = json!(5000));
    refused(&server, "a.glb", &too_many).assert_problem(422, "invalid-accessor", Some("/file"));
    let too_far = skirt_with(|json| json["bufferViews"][0]["byteOffset"] = json!(u32::MAX));
    refused(&server, "a.glb", &too_far).assert_problem(422, "invalid-accessor", Some("/file"));
}

#[test]
fn a_position_that_is_no_number_is_refused() {
    let server = Server::start();
    for value in [f32::NAN, f32::INFINITY] {
        let mut mesh = skirt(1.0);
        mesh.positions[7][1] = value;
        let glb = mesh.glb_with(|json| {
            json["accessors"][0]["min"] = json!([-1.0, 0.0, -1.0]);
            json["accessors"][0]["max"] = json!([1.0, 2.0, 1.0]);
        });
        refused(&server, "a.glb", &glb).assert_problem(422, "non-finite-position", Some("/file"));
    }
    refused(&server, "a.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").assert_problem(
        422,
        "non-finite-position",
        Some("/file"),
    );
}

#[test]
fn a_triangle_of_a_vertex_that_is_not_there_is_refused() {
    let server = Server::start();
    let mut mesh = skirt(1.0);
    mesh.triangles[3][1] = 1008;
    refused(&server, "a.glb", &mesh.glb()).assert_problem(422, "index-out-of-range", Some("/file"));
    refused(&server, "a.obj", b"v 0 1 0\nv 0.1 1 0\nv 0 1.1 0\nf 1 2 9\n").assert_problem(
        422,
        "index-out-of-range",
        Some("/file"),
    );
}

#[test]
fn a_file_without_triangles_is_refused() {
    let server = Server::start();
    let points = skirt_with(|json| json["meshes"][0]["primitives"][0]["mode"] = json!(0));
    refused(&server, "a.glb", &points).assert_problem(422, "no-triangles", Some("/file"));
    let empty = glb_of_json(&json!({"asset": {"version": "2.0"}}), &[]);
    refused(&server, "a.glb", &empty).assert_problem(422, "no-triangles", Some("/file"));
}

#[test]
fn more_vertices_than_allowed_are_refused() {
    let server = Server::start();
    let many = 200_001;
    let positions = (0..many).map(|i| [0.1 * (i as f32).sin(), 1.0, 0.1 * (i as f32).cos()]).collect();
    let mesh = Mesh { positions, triangles: (0..many / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect() };
    refused(&server, "a.glb", &mesh.glb()).assert_problem(413, "too-large", Some("/file"));
}

#[test]
fn more_bytes_than_allowed_are_refused() {
    let server = Server::start();
    let answer = refused(&server, "a.glb", &vec![0; 64 * 1024 * 1024 + 1]);
    answer.assert_problem(413, "too-large", Some("/file"));
}

#[test]
fn an_outfit_beside_the_body_is_refused() {
    let beside = skirt(1.0).map(|[x, y, z]| [x + 1.5, y, z]).glb();
    let form = Form::file("a.glb", &beside).metadata(&json!({"units": "m", "up": "y"}));
    refused_form(&Server::start(), &form).assert_problem(422, "off-body", Some("/file"));
}

#[test]
fn an_outfit_of_a_size_that_fits_nobody_is_refused() {
    let server = Server::start();
    let huge = skirt(1.0).map(|p| p.map(|x| 5000.0 * x)).glb();
    refused(&server, "a.glb", &huge).assert_problem(422, "wrong-units", Some("/file"));
    let form = Form::file("a.glb", &skirt(1.0).glb()).metadata(&json!({"units": "mm", "up": "y"}));
    refused_form(&server, &form).assert_problem(422, "wrong-units", Some("/file"));
}

#[test]
fn metadata_that_is_not_understood_is_refused() {
    let server = Server::start();
    let glb = skirt(1.0).glb();
    let cases = [
        (json!({"colour": "red"}), "unknown-field", "/metadata/colour"),
        (json!({"name": 7}), "invalid-field", "/metadata/name"),
        (json!({"units": "yards"}), "invalid-field", "/metadata/units"),
        (json!({"up": "x"}), "invalid-field", "/metadata/up"),
        (json!({"layers": ["skirt", "cape"]}), "invalid-field", "/metadata/layers/1"),
        (json!({"fitted_on": {"values": {}}}), "missing-field", "/metadata/fitted_on"),
        (
            json!({"fitted_on": {"kind": "phenotypes", "values": {"charm": 1}}}),
            "unknown-phenotype",
            "/metadata/fitted_on/values/charm",
        ),
    ];
    for (metadata, code, pointer) in cases {
        let form = Form::file("a.glb", &glb).metadata(&metadata);
        refused_form(&server, &form).assert_problem(400, code, Some(pointer));
    }
}

#[test]
fn a_form_that_is_not_as_it_should_be_is_refused() {
    let server = Server::start();
    let glb = skirt(1.0).glb();
    let without_file = Form::default().metadata(&json!({}));
    refused_form(&server, &without_file).assert_problem(400, "missing-field", Some("/file"));
    let twice = Form::file("a.glb", &glb).part("name=\"file\"; filename=\"b.glb\"", &glb);
    refused_form(&server, &twice).assert_problem(400, "unknown-field", Some("/file"));
    let other = Form::file("a.glb", &glb).part("name=\"notes\"", b"hello");
    refused_form(&server, &other).assert_problem(400, "unknown-field", Some("/notes"));
    let bad_json = Form::file("a.glb", &glb).part("name=\"metadata\"", b"{name}");
    refused_form(&server, &bad_json).assert_problem(400, "invalid-json", Some("/metadata"));

    let (media_type, mut body) = Form::file("a.glb", &glb).encode();
    body.truncate(body.len() / 2);
    let cut = server.request("POST", "/v1/outfits", &[("content-type", &media_type)], &body);
    cut.assert_problem(400, "invalid-multipart", None);
    let raw = server.request("POST", "/v1/outfits", &[("content-type", "model/gltf-binary")], &glb);
    raw.assert_problem(415, "unsupported-media-type", None);
}
