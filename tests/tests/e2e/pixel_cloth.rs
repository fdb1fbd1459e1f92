//! Pixel-based cloth: the method of garments that have a network of their own.

use serde_json::{Value, json};
use toile_tests::{Form, Server, assert_valid_glb, repository};

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
