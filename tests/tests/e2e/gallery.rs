//! The demo outfits.

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use toile_tests::{Server, ServerOptions, assert_valid_glb, repository, skirt};

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

fn shipped() -> Vec<Value> {
    let file = std::fs::read(repository().join("model/artifacts/gallery/gallery.json")).unwrap();
    serde_json::from_slice::<Value>(&file).unwrap().as_array().unwrap().clone()
}

fn listed(server: &Server) -> Vec<Value> {
    server.get("/v1/outfits?limit=100").with_status(200).json()["data"].as_array().unwrap().clone()
}

fn names(list: &[Value]) -> Vec<Value> {
    list.iter().map(|entry| entry["name"].clone()).collect()
}

/// The shipped artifacts with a gallery of our own.
fn artifacts_with_gallery(folder: &Path, exhibits: &[(&str, f32)]) {
    let (artifacts, gallery) = (repository().join("model/artifacts"), folder.join("gallery"));
    if !gallery.exists() {
        for entry in ["body.safetensors", "poses.json", "deepsd", "deepsd-concat", "garnet", "pixel_cloth"] {
            std::os::unix::fs::symlink(artifacts.join(entry), folder.join(entry)).unwrap();
        }
        std::fs::create_dir(&gallery).unwrap();
    }
    for (name, flare) in exhibits {
        std::fs::write(gallery.join(format!("{name}.glb")), skirt(*flare).glb()).unwrap();
    }
    std::fs::write(gallery.join("plain.png"), PNG).unwrap();
    let list: Vec<Value> = exhibits
        .iter()
        .map(|(name, _)| json!({"file": format!("{name}.glb"), "name": name, "description": "", "layers": ["skirt"]}))
        .collect();
    std::fs::write(gallery.join("gallery.json"), json!(list).to_string()).unwrap();
}

#[test]
fn a_fresh_server_has_the_demo_outfits_and_a_second_start_is_quick() {
    let folder = tempfile::tempdir().unwrap();
    let first = ServerOptions::default().on(folder.path()).with_gallery().start();
    let (outfits, shipped) = (listed(&first), shipped());
    assert!(shipped.len() >= 10);
    assert_eq!(names(&outfits), names(&shipped));
    for outfit in &outfits {
        let drape = first.drape(&json!({"outfit": outfit["id"], "pose": {"kind": "preset", "id": "walk-3"}}));
        assert_eq!(drape.status, 200, "{outfit}: {}", drape.text());
        assert_valid_glb(&drape.bytes);
    }
    let deleted = outfits[0]["links"]["self"].as_str().unwrap();
    first.request("DELETE", deleted, &[], &[]).with_status(204);
    first.stop();

    let begun = Instant::now();
    let second = ServerOptions::default().on(folder.path()).with_gallery().start();
    let start = begun.elapsed();
    assert!(start < Duration::from_secs(3), "the second start took {start:?}");
    assert_eq!(listed(&second), outfits[1..], "a deleted demo outfit came back, or one is new");
}

#[test]
fn a_demo_outfit_that_changed_replaces_what_it_was_and_has_its_picture() {
    let (artifacts, data) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let start = || {
        let arguments = ["--artifacts", artifacts.path().to_str().unwrap()];
        ServerOptions::default().on(data.path()).with_gallery().with(&arguments).start()
    };
    artifacts_with_gallery(artifacts.path(), &[("plain", 1.0), ("wide", 1.2)]);
    let first = start();
    let before = listed(&first);
    assert_eq!(names(&before), ["plain", "wide"]);
    let picture = first.get(before[0]["links"]["thumbnail"].as_str().unwrap()).with_status(200);
    assert_eq!(picture.header("content-type"), "image/png");
    assert_eq!(picture.bytes, PNG);
    assert!(before[1]["links"]["thumbnail"].is_null());
    first.stop();

    artifacts_with_gallery(artifacts.path(), &[("plain", 1.0), ("wide", 1.3)]);
    let second = start();
    let after = listed(&second);
    assert_eq!(names(&after), ["plain", "wide"]);
    assert_eq!(after[0], before[0]);
    assert_ne!(after[1]["id"], before[1]["id"]);
    assert_eq!(second.files("outfits").len(), 2);
}
