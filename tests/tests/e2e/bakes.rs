//! Bakes: an outfit's own basis and blend weights in the place of the networks' answers.

use safetensors::SafeTensors;
use safetensors::tensor::TensorView;
use serde_json::json;
use std::collections::HashMap;
use toile_tests::{Answer, Server, ServerOptions, assert_valid_glb};

/// What the report of every bake here says.
const REPORT: &str = r#"{"minutes": 1.5, "drapes": 64,
    "before": {"miss_mm": 24.0, "edge_mm": 1.5, "inside_percent": 0.5},
    "after": {"miss_mm": 20.0, "edge_mm": 1.25, "inside_percent": 0.25}}"#;

/// A bake of an outfit whose basis is the networks' times `scale`, with metadata.
fn bake(server: &Server, id: &str, scale: f32, metadata: &[(&str, &str)]) -> Vec<u8> {
    let file = server.get(&format!("/v1/outfits/{id}/static.safetensors")).with_status(200).bytes;
    let (_, header) = SafeTensors::read_metadata(&file).unwrap();
    let made_for = header.metadata().clone().unwrap()["static"].clone();
    let tensors = SafeTensors::deserialize(&file).unwrap();
    let basis = tensors.tensor("basis").unwrap();
    let scaled: Vec<u8> = basis
        .data()
        .chunks_exact(4)
        .flat_map(|b| (scale * f32::from_le_bytes(b.try_into().unwrap())).to_le_bytes())
        .collect();
    let views = [
        ("basis", TensorView::new(basis.dtype(), basis.shape().to_vec(), &scaled).unwrap()),
        ("joints", tensors.tensor("joints").unwrap()),
        ("weights", tensors.tensor("weights").unwrap()),
    ];
    let mut about =
        HashMap::from([("static".to_owned(), made_for), ("report".to_owned(), REPORT.to_owned())]);
    about.extend(metadata.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())));
    safetensors::serialize(views, Some(about)).unwrap()
}

fn put(server: &Server, id: &str, file: &[u8]) -> Answer {
    server.request("PUT", &format!("/v1/outfits/{id}/bake"), &[], file)
}

fn drape(server: &Server, id: &str) -> Vec<u8> {
    let drape =
        server.drape(&json!({"outfit": id, "pose": {"kind": "preset", "id": "sitting"}})).with_status(200);
    assert_valid_glb(&drape.bytes);
    drape.bytes
}

#[test]
fn a_bake_changes_the_next_drape_survives_a_restart_and_can_be_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let server = ServerOptions::default().on(folder.path()).start();
    let id = server.upload_skirt();
    let at = format!("/v1/outfits/{id}/bake");
    let plain = drape(&server, &id);
    let networks_say = server.get(&format!("/v1/outfits/{id}/static.safetensors")).with_status(200).bytes;
    server.get(&at).assert_problem(404, "no-bake", None);
    assert_eq!(server.get(&format!("/v1/outfits/{id}")).json()["links"]["bake"], json!(null));

    let report = put(&server, &id, &bake(&server, &id, 0.5, &[])).with_status(200).json();
    assert_eq!(report["after"]["miss_mm"], 20.0);
    assert_eq!(server.get(&at).with_status(200).json(), report);
    assert_eq!(server.get(&format!("/v1/outfits/{id}")).json()["links"]["bake"], at);
    let baked = drape(&server, &id);
    assert_ne!(baked, plain);
    let unbaked = server.get(&format!("/v1/outfits/{id}/static.safetensors")).bytes;
    assert_eq!(unbaked, networks_say, "the next bake starts from the networks again");
    assert_eq!(server.files("bakes").len(), 1);
    drop(server);

    let server = ServerOptions::default().on(folder.path()).start();
    assert_eq!(drape(&server, &id), baked);
    server.request("DELETE", &at, &[], &[]).with_status(204);
    assert_eq!(drape(&server, &id), plain);
    server.request("DELETE", &at, &[], &[]).assert_problem(404, "no-bake", None);
    assert!(server.files("bakes").is_empty());
}

#[test]
fn a_bake_that_does_not_fit_is_refused_and_nothing_changes() {
    let server = Server::start();
    let id = server.upload_skirt();
    let plain = drape(&server, &id);
    let refused = |file: &[u8], status, code| put(&server, &id, file).assert_problem(status, code, None);
    refused(b"not a bake", 422, "invalid-bake");
    let whole = bake(&server, &id, 1.0, &[]);
    refused(&whole[..whole.len() - 8], 422, "invalid-bake");
    refused(&bake(&server, &id, f32::NAN, &[]), 422, "invalid-bake");
    refused(&bake(&server, &id, 1.0, &[("report", "{}")]), 422, "invalid-bake");
    refused(&bake(&server, &id, 1.0, &[("static", "0123")]), 409, "outdated-bake");
    put(&server, "0123", &whole).assert_problem(404, "unknown-outfit", None);
    server.get("/v1/outfits/0123/static.safetensors").assert_problem(404, "unknown-outfit", None);
    server.request("DELETE", "/v1/outfits/0123/bake", &[], &[]).assert_problem(404, "unknown-outfit", None);
    assert_eq!(drape(&server, &id), plain);
    assert!(server.files("bakes").is_empty());
}

#[test]
fn a_corrupted_bake_is_left_out_and_a_deleted_outfit_takes_its_bake_along() {
    let folder = tempfile::tempdir().unwrap();
    let server = ServerOptions::default().on(folder.path()).start();
    let id = server.upload_skirt();
    let plain = drape(&server, &id);
    put(&server, &id, &bake(&server, &id, 0.5, &[])).with_status(200);
    let path = folder.path().join("bakes").join(&server.files("bakes")[0]);
    drop(server);
    let mut file = std::fs::read(&path).unwrap();
    let last = file.len() - 1;
    file[last] ^= 1;
    std::fs::write(&path, file).unwrap();

    let server = ServerOptions::default().on(folder.path()).start();
    assert_eq!(drape(&server, &id), plain);
    assert!(server.log().contains("bake cannot be used"));
    server.request("DELETE", &format!("/v1/outfits/{id}"), &[], &[]).with_status(204);
    assert!(server.files("bakes").is_empty());
}
