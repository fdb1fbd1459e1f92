//! Pixel-based cloth: the method of garments that have a network of their own.

use std::collections::HashMap;

use safetensors::SafeTensors;
use serde_json::{Value, json};
use toile_tests::{Form, Server, ServerOptions, assert_valid_glb, repository};

fn hero() -> Vec<u8> {
    std::fs::read(repository().join("model/artifacts/gallery/hero-t-shirt.glb")).unwrap()
}

fn request(outfit: &str, pose: &str, method: &str) -> Value {
    let output = json!({"method": method});
    json!({"outfit": outfit, "pose": {"kind": "preset", "id": pose}, "output": output})
}

fn upload(server: &Server, file: &[u8]) -> Value {
    server.upload(&Form::file("hero.glb", file)).json()
}

/// Width, height, bits a channel and colour type of a PNG.
fn header(png: &[u8]) -> (u32, u32, u8, u8) {
    assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
    let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    (number(16), number(20), png[24], png[25])
}

#[test]
fn a_garment_with_a_network_is_draped_by_it_and_its_images_can_be_fetched() {
    let server = Server::shared();
    let outfit = upload(&server, &hero());
    assert!(outfit["methods"].as_array().unwrap().contains(&json!("pixel_cloth")), "{outfit}");
    assert_eq!(outfit["garments"][0]["pixel_cloth"], true);
    let id = outfit["id"].as_str().unwrap();
    let draped = server.drape(&request(id, "arms-up", "pixel_cloth")).with_status(200);
    assert_valid_glb(&draped.bytes);
    let other = server.drape(&request(id, "arms-up", "deepsd")).with_status(200);
    assert!(draped.bytes != other.bytes, "both methods answer alike");
    let answer = server.drape_json(&request(id, "arms-up", "pixel_cloth")).with_status(200).json();
    assert_eq!(answer["method"], "pixel_cloth");
    assert!(answer["quality"]["penetration_after_percent"].as_f64().unwrap() < 0.1, "{answer}");
    let cloth = &answer["cloth"][0];
    assert_eq!(cloth["garment"], outfit["garments"][0]["name"]);
    let picture = |name: &str| server.get(cloth[name].as_str().unwrap()).with_status(200);
    assert_eq!(picture("url").header("content-type"), "image/png");
    assert_eq!(header(&picture("url").bytes), (512, 256, 16, 2));
    assert_eq!(header(&picture("preview").bytes), (512, 256, 8, 6));
    let plain = server.drape_json(&request(id, "arms-up", "deepsd")).with_status(200).json();
    assert!(plain.get("cloth").is_none(), "only pixel cloth has images");
    let elsewhere = server.drape_json(&request(id, "wave", "pixel_cloth")).json();
    assert_ne!(elsewhere["cloth"][0]["url"], cloth["url"], "images move with the pose");
    server.get("/v1/drapes/0000/cloth.png").assert_problem(404, "drape-expired", None);
}

#[test]
fn a_body_of_another_shape_and_a_motion_wear_it_too() {
    let server = Server::shared();
    let id = upload(&server, &hero())["id"].as_str().unwrap().to_owned();
    let mut heavy = request(&id, "hands-on-hips", "pixel_cloth");
    heavy["body"] = json!({"kind": "phenotypes", "values": {"weight": 0.8, "gender": 1.0}});
    let answer = server.drape_json(&heavy).with_status(200).json();
    assert!(answer["quality"]["penetration_after_percent"].as_f64().unwrap() < 0.5, "{answer}");
    let walk = json!({"outfit": id, "motion": "walk", "output": {"method": "pixel_cloth"}});
    assert_valid_glb(&server.drape(&walk).with_status(200).bytes);
}

#[test]
fn legs_that_the_network_never_saw_move_the_cloth_too() {
    let server = Server::shared();
    let id = upload(&server, &hero())["id"].as_str().unwrap().to_owned();
    for pose in ["sitting", "squat", "lunge"] {
        let answer = server.drape_json(&request(&id, pose, "pixel_cloth")).with_status(200).json();
        let inside = answer["quality"]["penetration_after_percent"].as_f64().unwrap();
        let stretched = answer["quality"]["max_edge_stretch"].as_f64().unwrap();
        assert!(inside < 0.1 && stretched < 3.0, "{pose}: {answer}");
    }
}

#[test]
fn a_garment_without_a_network_is_refused_with_what_to_do() {
    let server = Server::shared();
    let id = server.upload_skirt();
    let refused = server.drape(&request(&id, "walk-2", "pixel_cloth"));
    refused.assert_problem(422, "no-pixel-cloth", Some("/output/method"));
    for word in ["skirt", "deepsd"] {
        assert!(refused.text().contains(word), "{word}: {}", refused.text());
    }
    let outfit = server.get(&format!("/v1/outfits/{id}")).json();
    assert!(!outfit["methods"].as_array().unwrap().contains(&json!("pixel_cloth")));
}

/// The shipped artifacts without any network of one garment.
fn artifacts_without_heroes() -> tempfile::TempDir {
    let (artifacts, folder) = (repository().join("model/artifacts"), tempfile::tempdir().unwrap());
    let own = folder.path().join("pixel_cloth");
    std::fs::create_dir(&own).unwrap();
    for entry in ["body.safetensors", "poses.json", "deepsd", "deepsd-concat", "garnet"] {
        std::os::unix::fs::symlink(artifacts.join(entry), folder.path().join(entry)).unwrap();
    }
    for file in ["manifest.json", "decoder.onnx"] {
        std::os::unix::fs::symlink(artifacts.join("pixel_cloth").join(file), own.join(file)).unwrap();
    }
    folder
}

/// The shipped T-shirt's network as `make hero` would bring it, with a tensor left out.
fn network(without: &str) -> Vec<u8> {
    let shipped = std::fs::read(repository().join("model/artifacts/pixel_cloth/tee.safetensors")).unwrap();
    let tensors = SafeTensors::deserialize(&shipped).unwrap();
    let kept: Vec<_> = tensors.tensors().into_iter().filter(|(name, _)| name != without).collect();
    let report =
        json!({"minutes": 1.0, "drapes": 2, "skinning_cm": 4.0, "deepsd_cm": 2.0, "pixel_cloth_cm": 1.0});
    let about = HashMap::from([("report".to_owned(), report.to_string())]);
    safetensors::serialize(kept, Some(about)).unwrap()
}

#[test]
fn a_network_of_ones_own_is_taken_in_kept_and_taken_back() {
    let (artifacts, data) = (artifacts_without_heroes(), tempfile::tempdir().unwrap());
    let start = || {
        let arguments = ["--artifacts", artifacts.path().to_str().unwrap()];
        ServerOptions::default().on(data.path()).with(&arguments).start()
    };
    let server = start();
    let outfit = upload(&server, &hero());
    let id = outfit["id"].as_str().unwrap().to_owned();
    let at = format!("/v1/outfits/{id}/hero");
    assert!(!outfit["methods"].as_array().unwrap().contains(&json!("pixel_cloth")), "{outfit}");
    server.drape(&request(&id, "sitting", "pixel_cloth")).assert_problem(
        422,
        "no-pixel-cloth",
        Some("/output/method"),
    );
    server.get(&at).assert_problem(404, "no-hero", None);
    let report = server.request("PUT", &at, &[], &network("")).with_status(200).json();
    assert_eq!(report["pixel_cloth_cm"], 1.0);
    assert_eq!(server.get(&at).with_status(200).json(), report);
    let shown = server.get(&format!("/v1/outfits/{id}")).json();
    assert!(shown["methods"].as_array().unwrap().contains(&json!("pixel_cloth")), "{shown}");
    assert_eq!(shown["links"]["hero"], at);
    let draped = server.drape(&request(&id, "sitting", "pixel_cloth")).with_status(200).bytes;
    assert_valid_glb(&draped);
    assert_eq!(server.files("heroes").len(), 1);
    drop(server);

    let server = start();
    assert_eq!(server.drape(&request(&id, "sitting", "pixel_cloth")).with_status(200).bytes, draped);
    server.request("DELETE", &at, &[], &[]).with_status(204);
    server.request("DELETE", &at, &[], &[]).assert_problem(404, "no-hero", None);
    server.drape(&request(&id, "sitting", "pixel_cloth")).assert_problem(
        422,
        "no-pixel-cloth",
        Some("/output/method"),
    );
    server.request("PUT", &at, &[], &network("")).with_status(200);
    server.request("DELETE", &format!("/v1/outfits/{id}"), &[], &[]).with_status(204);
    assert!(server.files("heroes").is_empty());
}

#[test]
fn a_network_that_does_not_fit_is_refused_and_nothing_changes() {
    let server = Server::start();
    let id = server.upload_skirt();
    let put = |id: &str, file: &[u8]| server.request("PUT", &format!("/v1/outfits/{id}/hero"), &[], file);
    let whole = network("");
    put(&id, &whole).assert_problem(422, "invalid-hero", None);
    assert!(put(&id, &whole).text().contains("another garment"));
    let tee = upload(&server, &hero())["id"].as_str().unwrap().to_owned();
    put(&tee, b"no network").assert_problem(422, "invalid-hero", None);
    put(&tee, &whole[..whole.len() - 8]).assert_problem(422, "invalid-hero", None);
    put(&tee, &network("weight3")).assert_problem(422, "invalid-hero", None);
    let shipped = std::fs::read(repository().join("model/artifacts/pixel_cloth/tee.safetensors")).unwrap();
    assert!(put(&tee, &shipped).text().contains("report"), "a file without a report was taken");
    put("0123", &whole).assert_problem(404, "unknown-outfit", None);
    assert!(server.files("heroes").is_empty());
}
