//! Kept simulations of demo outfits, to hold the methods against.

use serde_json::{Value, json};
use toile_tests::{Form, Glb, Server, assert_valid_glb, repository};

/// The id of a demo outfit, uploaded as the gallery has it.
fn upload(server: &Server, file: &str) -> Value {
    let gallery = repository().join("model/artifacts/gallery");
    let list: Value = serde_json::from_slice(&std::fs::read(gallery.join("gallery.json")).unwrap()).unwrap();
    let exhibit = list.as_array().unwrap().iter().find(|exhibit| exhibit["file"] == file).unwrap();
    let mut metadata = json!({"name": exhibit["name"], "layers": exhibit["layers"]});
    if let Some(kinds) = exhibit.get("kinds") {
        metadata["kinds"] = kinds.clone();
    }
    let bytes = std::fs::read(gallery.join(file)).unwrap();
    server.upload(&Form::file(file, &bytes).metadata(&metadata)).json()
}

fn request(outfit: &Value, on: &Value, method: &str) -> Value {
    let output = json!({"method": method});
    json!({"outfit": outfit["id"], "body": on["body"], "pose": on["pose"], "output": output})
}

#[test]
fn what_was_simulated_is_listed_and_lies_near_what_the_networks_say() {
    let server = Server::shared();
    let outfit = upload(&server, "hero-t-shirt.glb");
    assert!(outfit["methods"].as_array().unwrap().contains(&json!("simulation")), "{outfit}");
    let simulated = outfit["simulated"].as_array().unwrap();
    assert!(!simulated.is_empty());
    let node = outfit["garments"][0]["name"].as_str().unwrap();
    for on in simulated {
        let places = |method: &str| {
            let answer = server.drape(&request(&outfit, on, method)).with_status(200);
            assert_valid_glb(&answer.bytes);
            Glb::parse(&answer.bytes).positions(node)
        };
        let (truth, learned) = (places("simulation"), places("deepsd"));
        assert_eq!(truth.len(), learned.len());
        let distance = |(a, b): (&[f32; 3], &[f32; 3])| {
            a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
        };
        let mean = truth.iter().zip(&learned).map(distance).sum::<f32>() / truth.len() as f32;
        assert!((0.002..0.08).contains(&mean), "{on}: {mean} m apart");
    }
    let answer = server.drape_json(&request(&outfit, &simulated[0], "simulation")).with_status(200).json();
    let quality = &answer["quality"];
    assert_eq!(
        quality["penetration_before_percent"], quality["penetration_after_percent"],
        "nothing is moved"
    );
}

#[test]
fn what_was_not_simulated_is_refused_with_what_to_do() {
    let server = Server::shared();
    let outfit = upload(&server, "hero-t-shirt.glb");
    let on = &outfit["simulated"][0];
    let mut other_pose = request(&outfit, on, "simulation");
    other_pose["pose"] = json!({"kind": "preset", "id": "arms-up"});
    let mut other_body = request(&outfit, on, "simulation");
    other_body["body"] = json!({"kind": "phenotypes", "values": {"weight": 0.8}});
    let other_outfit = request(&json!({"id": server.upload_skirt()}), on, "simulation");
    for refused in [other_pose, other_body, other_outfit] {
        let answer = server.drape(&refused);
        answer.assert_problem(422, "not-simulated", Some("/output/method"));
        for word in ["simulated", "deepsd"] {
            assert!(answer.text().contains(word), "{word}: {}", answer.text());
        }
    }
}
