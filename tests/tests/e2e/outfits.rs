//! Uploading, listing, showing, deleting.

use serde_json::json;
use toile_tests::{Form, Glb, Server, assert_valid_glb, skirt};

#[test]
fn an_upload_is_described_and_can_be_fetched_again() {
    let server = Server::start();
    let form = Form::file("Red skirt.glb", &skirt(1.0).glb());
    let answer = server.upload(&form).with_status(201);
    let outfit = answer.json();
    let id = outfit["id"].as_str().unwrap();
    let at = format!("/v1/outfits/{id}");
    assert_eq!(answer.header("location"), at);
    assert!(answer.stage("static").is_some(), "{}", answer.header("server-timing"));
    assert_eq!(outfit["vertices"], 1008);
    assert_eq!(outfit["triangles"], 1920);
    assert_eq!(outfit["garments"][0]["name"], "skirt");
    assert_eq!(outfit["garments"][0]["layer"], 0);
    assert_eq!(outfit["methods"], json!(["deepsd", "deepsd-concat", "skinning"]));
    assert_eq!(outfit["links"]["static"], format!("{at}/static.glb"));
    assert_eq!(outfit["report"]["units"], "m");
    assert_eq!(outfit["report"]["components"], 1);
    assert_eq!(outfit["created_at"].as_str().unwrap().len(), "2026-01-01T00:00:00Z".len());
    assert_eq!(server.get(&at).with_status(200).json(), outfit);
}

#[test]
fn a_glb_a_gltf_and_an_obj_of_one_mesh_give_the_same_counts() {
    let server = Server::shared();
    let mesh = skirt(1.05);
    for (name, bytes) in [("a.glb", mesh.glb()), ("a.gltf", mesh.gltf()), ("a.obj", mesh.obj())] {
        let answer = server.upload(&Form::file(name, &bytes));
        assert!([200, 201].contains(&answer.status), "{name}: {}", answer.text());
        assert_eq!(answer.json()["vertices"], 1008, "{name}");
        assert_eq!(answer.json()["triangles"], 1920, "{name}");
    }
}

#[test]
fn the_same_upload_is_one_outfit_and_another_name_makes_another() {
    let server = Server::start();
    let form = Form::file("a.glb", &skirt(1.0).glb());
    let first = server.upload(&form).with_status(201).json();
    let again = server.upload(&form).with_status(200).json();
    assert_eq!(first, again);
    let named = form.metadata(&json!({"name": "Another"}));
    let other = server.upload(&named).with_status(201).json();
    assert_eq!(other["name"], "Another");
    assert_ne!(other["id"], first["id"]);
    assert_eq!(server.get("/v1/outfits").json()["data"].as_array().unwrap().len(), 2);
}

#[test]
fn units_and_up_axis_are_detected_or_taken_as_stated() {
    let server = Server::shared();
    let in_centimetres_with_z_up = skirt(1.0).map(|[x, y, z]| [100.0 * x, -100.0 * z, 100.0 * y]).glb();
    let detected = Form::file("a.glb", &in_centimetres_with_z_up);
    let stated = detected.clone().metadata(&json!({"units": "cm", "up": "z"}));
    for form in [detected, stated] {
        let answer = server.upload(&form);
        assert!([200, 201].contains(&answer.status), "{}", answer.text());
        let report = answer.json()["report"].clone();
        assert_eq!(report["units"], "cm");
        assert_eq!(report["up_axis"], "z");
        assert!((report["scale_applied"].as_f64().unwrap() - 0.01).abs() < 1e-6);
    }
}

#[test]
fn an_outfit_may_be_fitted_on_another_body() {
    let server = Server::shared();
    let body = json!({"kind": "phenotypes", "values": {"height": 0.55}});
    let form = Form::file("a.glb", &skirt(1.0).glb()).metadata(&json!({"fitted_on": body}));
    let answer = server.upload(&form);
    assert!([200, 201].contains(&answer.status), "{}", answer.text());
    let drape = server.drape(&json!({"outfit": answer.json()["id"]})).with_status(200);
    assert_valid_glb(&drape.bytes);
}

#[test]
fn the_list_is_paged_oldest_first_and_without_reports() {
    let server = Server::start();
    let ids: Vec<String> = (0..5).map(|step| server.upload_mesh(&skirt(1.0 + 0.02 * step as f32))).collect();
    let mut seen = Vec::new();
    let mut path = "/v1/outfits?limit=2".to_owned();
    for page in 0.. {
        let answer = server.get(&path).with_status(200).json();
        let data = answer["data"].as_array().unwrap();
        assert!(data.iter().all(|outfit| outfit.get("report").is_none()));
        seen.extend(data.iter().map(|outfit| outfit["id"].as_str().unwrap().to_owned()));
        let Some(cursor) = answer["next_cursor"].as_str() else {
            assert_eq!(page, 2);
            break;
        };
        path = format!("/v1/outfits?limit=2&cursor={cursor}");
    }
    assert_eq!(seen, ids);
}

#[test]
fn a_list_with_a_wrong_limit_cursor_or_parameter_is_refused() {
    let server = Server::shared();
    for query in ["limit=0", "limit=101", "limit=many", "cursor=here"] {
        server.get(&format!("/v1/outfits?{query}")).assert_problem(400, "invalid-field", None);
    }
    server.get("/v1/outfits?page=2").assert_problem(400, "unknown-field", None);
}

#[test]
fn a_deleted_outfit_is_gone_with_its_files() {
    let server = Server::start();
    let id = server.upload_skirt();
    server.drape(&json!({"outfit": id})).with_status(200);
    assert_eq!(server.files("outfits"), std::slice::from_ref(&id));
    assert_eq!(server.files("static").len(), 1);
    let at = format!("/v1/outfits/{id}");
    let answer = server.request("DELETE", &at, &[], &[]).with_status(204);
    assert!(answer.bytes.is_empty());
    assert!(server.files("outfits").is_empty());
    assert!(server.files("static").is_empty());
    server.get(&at).assert_problem(404, "unknown-outfit", None);
    server.request("DELETE", &at, &[], &[]).assert_problem(404, "unknown-outfit", None);
    server.drape(&json!({"outfit": id})).assert_problem(404, "unknown-outfit", Some("/outfit"));
    assert_eq!(server.upload_skirt(), id, "it cannot be uploaded again");
}

#[test]
fn the_rest_pose_is_valid_gltf_in_the_vertex_order_of_every_drape() {
    let server = Server::shared();
    let id = server.upload_skirt();
    let rest = server.get(&format!("/v1/outfits/{id}/static.glb")).with_status(200);
    assert_eq!(rest.header("content-type"), "model/gltf-binary");
    assert_valid_glb(&rest.bytes);
    let drape = server.drape(&json!({"outfit": id, "pose": {"kind": "preset", "id": "squat"}}));
    let (rest, drape) = (Glb::parse(&rest.bytes), Glb::parse(&drape.bytes));
    assert_eq!(rest.nodes(), ["skirt"]);
    assert_eq!(rest.positions("skirt").len(), drape.positions("skirt").len());
    assert_eq!(rest.index_bytes("skirt"), drape.index_bytes("skirt"));
    let heights = rest.positions("skirt").into_iter().map(|p| p[1]);
    assert!(heights.clone().fold(f32::MAX, f32::min) > 0.5 && heights.fold(0.0, f32::max) < 1.15);
}

#[test]
fn the_rest_pose_is_not_sent_to_a_client_that_has_it() {
    let server = Server::shared();
    let at = format!("/v1/outfits/{}/static.glb", server.upload_skirt());
    let first = server.get(&at).with_status(200);
    let etag = first.header("etag");
    assert!(etag.starts_with('"') && etag.len() > 10, "{etag}");
    let again = server.get_with(&at, &[("if-none-match", etag)]).with_status(304);
    assert!(again.bytes.is_empty());
    assert_eq!(again.header("etag"), etag);
    server.get_with(&at, &[("if-none-match", "\"another\"")]).with_status(200);
}

#[test]
fn an_outfit_without_a_picture_has_no_thumbnail() {
    let server = Server::shared();
    let id = server.upload_skirt();
    let outfit = server.get(&format!("/v1/outfits/{id}")).json();
    assert!(outfit["links"]["thumbnail"].is_null());
    let answer = server.get(&format!("/v1/outfits/{id}/thumbnail.png"));
    answer.assert_problem(404, "no-thumbnail", None);
}

#[test]
fn an_unknown_outfit_is_a_404_wherever_it_is_asked_for() {
    let server = Server::shared();
    for id in ["0123456789abcdef0123456789abcdef", "%2e%2e%2fetc", "x"] {
        for path in ["", "/static.glb", "/thumbnail.png"] {
            server.get(&format!("/v1/outfits/{id}{path}")).assert_problem(404, "unknown-outfit", None);
        }
    }
}
