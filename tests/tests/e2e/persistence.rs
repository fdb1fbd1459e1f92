//! What survives, and what is computed once.

use serde_json::json;
use toile_tests::{Server, ServerOptions};

fn source(answer: &toile_tests::Answer) -> String {
    answer.stage("static").and_then(|(_, source)| source).unwrap_or_default()
}

#[test]
fn outfits_and_static_passes_survive_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let first = ServerOptions::default().on(folder.path()).start();
    let outfit = first.upload_skirt();
    let request = json!({"outfit": outfit, "pose": {"kind": "preset", "id": "walk-1"}});
    let before = first.drape(&request).with_status(200);
    assert_eq!(source(&before), "memory");
    let shown = first.get("/v1/outfits").json();
    first.stop();

    let second = ServerOptions::default().on(folder.path()).start();
    assert_eq!(second.get("/v1/outfits").json(), shown);
    let after = second.drape(&request).with_status(200);
    assert_eq!(source(&after), "disk");
    assert!(after.bytes == before.bytes, "the drape changed with the restart");
    assert_eq!(source(&second.drape(&request)), "memory");
}

#[test]
fn a_corrupted_or_missing_static_pass_is_computed_again() {
    let folder = tempfile::tempdir().unwrap();
    let first = ServerOptions::default().on(folder.path()).start();
    let request = json!({"outfit": first.upload_skirt(), "pose": {"kind": "preset", "id": "squat"}});
    let before = first.drape(&request).with_status(200);
    let [name]: [String; 1] = first.files("static").try_into().unwrap();
    let path = folder.path().join("static").join(name);
    first.stop();

    let whole = std::fs::read(&path).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    let damages: [Option<&[u8]>; 4] = [Some(&flipped), Some(&whole[..whole.len() - 1]), Some(b""), None];
    for damage in damages {
        match damage {
            Some(bytes) => std::fs::write(&path, bytes).unwrap(),
            None => std::fs::remove_file(&path).unwrap(),
        }
        let server = ServerOptions::default().on(folder.path()).start();
        let after = server.drape(&request).with_status(200);
        assert_eq!(source(&after), "computed");
        assert!(after.bytes == before.bytes, "the drape differs after the damage");
        server.stop();
        assert!(std::fs::read(&path).unwrap() == whole, "the file was not written again");
    }
}

#[test]
fn many_requests_for_one_cold_outfit_prepare_it_once() {
    let folder = tempfile::tempdir().unwrap();
    let first = ServerOptions::default().on(folder.path()).start();
    let request = json!({"outfit": first.upload_skirt()});
    let [name]: [String; 1] = first.files("static").try_into().unwrap();
    first.stop();
    std::fs::remove_file(folder.path().join("static").join(name)).unwrap();

    let server = ServerOptions::default().on(folder.path()).start();
    let sources: Vec<String> = std::thread::scope(|scope| {
        let clients: Vec<_> =
            (0..8).map(|_| scope.spawn(|| source(&server.drape(&request).with_status(200)))).collect();
        clients.into_iter().map(|client| client.join().unwrap()).collect()
    });
    let computed = sources.iter().filter(|source| *source == "computed").count();
    assert_eq!(computed, 1, "{sources:?}");
    assert_eq!(server.log().matches("static pass computed").count(), 1);
}

#[test]
fn an_outfit_that_does_not_fit_into_memory_is_still_draped() {
    let server = ServerOptions::default().with(&["--cache", "0"]).start();
    let request = json!({"outfit": server.upload_skirt()});
    for _ in 0..2 {
        assert_eq!(source(&server.drape(&request).with_status(200)), "disk");
    }
}

#[test]
fn uploads_of_the_same_file_at_the_same_time_are_one_outfit() {
    let server = Server::start();
    let ids: Vec<String> = std::thread::scope(|scope| {
        let clients: Vec<_> = (0..4).map(|_| scope.spawn(|| server.upload_skirt())).collect();
        clients.into_iter().map(|client| client.join().unwrap()).collect()
    });
    assert!(ids.iter().all(|id| *id == ids[0]));
    assert_eq!(server.get("/v1/outfits").json()["data"].as_array().unwrap().len(), 1);
    assert_eq!(server.files("outfits"), [ids[0].clone()]);
}
