//! The demo outfits.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use toile_tests::{ServerOptions, assert_valid_glb, repository};

fn exhibits() -> Vec<Value> {
    let file = std::fs::read(repository().join("model/artifacts/gallery/gallery.json")).unwrap();
    serde_json::from_slice::<Value>(&file).unwrap().as_array().unwrap().clone()
}

#[test]
fn a_fresh_server_has_the_demo_outfits_and_a_second_start_is_quick() {
    let folder = tempfile::tempdir().unwrap();
    let first = ServerOptions::default().on(folder.path()).with_gallery().start();
    let listed = first.get("/v1/outfits?limit=100").json();
    let (outfits, exhibits) = (listed["data"].as_array().unwrap(), exhibits());
    assert!(exhibits.len() >= 10);
    let names = |list: &[Value]| list.iter().map(|entry| entry["name"].clone()).collect::<Vec<_>>();
    assert_eq!(names(outfits), names(&exhibits));
    for outfit in outfits {
        let drape = first.drape(&json!({"outfit": outfit["id"], "pose": {"kind": "preset", "id": "walk-3"}}));
        assert_eq!(drape.status, 200, "{outfit}: {}", drape.text());
        assert_valid_glb(&drape.bytes);
        let picture = first.get(outfit["links"]["thumbnail"].as_str().unwrap()).with_status(200);
        assert_eq!(picture.header("content-type"), "image/png");
        assert!(picture.bytes.starts_with(b"\x89PNG"));
    }
    let deleted = outfits[0]["links"]["self"].as_str().unwrap();
    first.request("DELETE", deleted, &[], &[]).with_status(204);
    first.stop();

    let begun = Instant::now();
    let second = ServerOptions::default().on(folder.path()).with_gallery().start();
    assert!(begun.elapsed() < Duration::from_secs(3), "the second start took {:?}", begun.elapsed());
    let again = second.get("/v1/outfits?limit=100").json();
    assert_eq!(
        again["data"].as_array().unwrap()[..],
        outfits[1..],
        "a deleted demo outfit came back, or one is new"
    );
}
