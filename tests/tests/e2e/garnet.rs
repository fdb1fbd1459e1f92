//! `GarNet++`: the method that needs to know the kind of every garment.

use serde_json::{Value, json};
use toile_tests::{Form, Server, assert_valid_glb, skirt};

fn request(outfit: &str, output: Value) -> Value {
    json!({"outfit": outfit, "pose": {"kind": "preset", "id": "walk-2"}, "output": output})
}

#[test]
fn an_outfit_whose_kinds_are_stated_is_draped_by_the_network_of_its_kind() {
    let server = Server::shared();
    let form = Form::file("a.glb", &skirt(1.1).glb()).metadata(&json!({"kinds": {"skirt": "dress"}}));
    let outfit = server.upload(&form).json();
    assert_eq!(outfit["kinds"], json!({"skirt": "dress"}));
    assert_eq!(outfit["methods"], json!(["deepsd", "deepsd-concat", "garnet", "skinning"]));
    let id = outfit["id"].as_str().unwrap();
    let draped = server.drape(&request(id, json!({"method": "garnet"}))).with_status(200);
    assert_valid_glb(&draped.bytes);
    let other = server.drape(&request(id, json!({"method": "deepsd"}))).with_status(200);
    assert!(draped.bytes != other.bytes, "both methods answer alike");
    let answer = server.drape_json(&request(id, json!({"method": "garnet"}))).with_status(200).json();
    assert_eq!(answer["method"], "garnet");
    assert!(answer["quality"]["penetration_after_percent"].as_f64().unwrap() < 2.0, "{answer}");
    let long = vec![json!({"kind": "preset", "id": "walk-2"}); 65];
    let long = json!({"outfit": id, "poses": long, "output": {"method": "garnet"}});
    server.drape(&long).assert_problem(400, "too-many-frames", Some("/poses"));
    let walk = json!({"outfit": id, "motion": "walk", "output": {"method": "garnet"}});
    assert_valid_glb(&server.drape(&walk).with_status(200).bytes);
}

#[test]
fn a_kind_may_come_with_the_drape_and_without_one_the_answer_says_what_to_do() {
    let server = Server::shared();
    let id = server.upload_skirt();
    let refused = server.drape(&request(&id, json!({"method": "garnet"})));
    refused.assert_problem(422, "unknown-kind", Some("/output/kinds"));
    for word in ["skirt", "jeans", "deepsd"] {
        assert!(refused.text().contains(word), "{word}: {}", refused.text());
    }
    let stated = json!({"method": "garnet", "kinds": {"skirt": "dress"}});
    server.drape(&request(&id, stated)).with_status(200);
    let methods = &server.get(&format!("/v1/outfits/{id}")).json()["methods"];
    assert_eq!(*methods, json!(["deepsd", "deepsd-concat", "skinning"]));
}

#[test]
fn kinds_and_garments_that_are_not_there_are_refused() {
    let server = Server::shared();
    let id = server.upload_skirt();
    for (kinds, pointer) in
        [(json!({"skirt": "kilt"}), "/output/kinds/skirt"), (json!({"cape": "tee"}), "/output/kinds/cape")]
    {
        let output = json!({"method": "garnet", "kinds": kinds});
        server.drape(&request(&id, output)).assert_problem(400, "invalid-field", Some(pointer));
    }
    let form = Form::file("a.glb", &skirt(1.2).glb());
    let answer = server.upload(&form.clone().metadata(&json!({"kinds": {"cape": "tee"}})));
    answer.assert_problem(400, "invalid-field", Some("/metadata/kinds/cape"));
    let answer = server.upload(&form.metadata(&json!({"kinds": {"skirt": "kilt"}})));
    answer.assert_problem(400, "invalid-field", Some("/metadata/kinds/skirt"));
}
