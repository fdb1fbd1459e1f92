//! Coarse meshes with normal maps: the answers of `output.detail` "normal_map".

use serde_json::{Value, json};
use toile_tests::{Form, Glb, Server, assert_valid_glb, repository};

fn upload(server: &Server, name: &str) -> String {
    let file = std::fs::read(repository().join("model/artifacts/gallery").join(name)).unwrap();
    server.upload(&Form::file(name, &file)).json()["id"].as_str().unwrap().to_owned()
}

fn request(outfit: &str, output: Value) -> Value {
    json!({"outfit": outfit, "pose": {"kind": "preset", "id": "arms-up"}, "output": output})
}

fn draped(server: &Server, outfit: &str, output: Value) -> Vec<u8> {
    server.drape(&request(outfit, output)).with_status(200).bytes
}

#[test]
fn a_coarse_mesh_with_a_normal_map_is_smaller_than_the_fine_one() {
    let server = Server::shared();
    let id = upload(&server, "hero-t-shirt.glb");
    let with = |output: Value| draped(&server, &id, output);
    let fine = with(json!({"method": "pixel_cloth", "textures": false}));
    let output = json!({"method": "pixel_cloth", "textures": false, "detail": "normal_map"});
    let coarse = with(output.clone());
    assert_valid_glb(&coarse);
    assert!(coarse == with(output), "the same request gives other bytes");
    assert!(coarse.len() * 4 < fine.len() * 3, "{} bytes of {}", coarse.len(), fine.len());
    let (fine, coarse) = (Glb::parse(&fine), Glb::parse(&coarse));
    let name = "hero T-shirt";
    assert!(coarse.triangles(name).len() * 4 < fine.triangles(name).len() + 400);
    let all = fine.positions(name);
    assert!(coarse.positions(name).iter().all(|p| all.contains(p)), "coarse vertices are fine ones");
    for (name_of, least, most) in [("TEXCOORD_1", 0.0, 1.0), ("TANGENT", -1.0, 1.0)] {
        let values = coarse.attribute(name, name_of);
        assert!(values.iter().all(|v| (least - 1e-5..=most + 1e-5).contains(v)), "{name_of}");
    }
    let material = coarse.primitive(name)["material"].as_u64().unwrap() as usize;
    assert_eq!(coarse.json["materials"][material]["normalTexture"]["texCoord"], 1);
    assert_eq!(coarse.json["images"].as_array().unwrap().len(), 1);
}

#[test]
fn every_method_and_an_outfit_of_several_garments_have_them() {
    let server = Server::shared();
    let id = upload(&server, "striped-t-shirt-and-shorts.glb");
    for method in ["deepsd", "deepsd-concat", "garnet", "skinning"] {
        let kinds = json!({"T-shirt": "tee", "trousers": "jeans"});
        let output = json!({"method": method, "kinds": kinds, "detail": "normal_map", "normal_map_size": 128,
            "include": ["outfit", "body"], "attributes": ["strain"]});
        let answer = draped(&server, &id, output);
        assert_valid_glb(&answer);
        let glb = Glb::parse(&answer);
        assert_eq!(glb.nodes().len(), 3, "{method}");
        assert!(glb.has_attribute("trousers", "_STRAIN") && !glb.has_attribute("body", "TANGENT"));
        let fabrics = glb.json["materials"].as_array().unwrap();
        assert_ne!(fabrics[0]["normalTexture"]["index"], fabrics[1]["normalTexture"]["index"]);
        assert!(fabrics[0]["pbrMetallicRoughness"].get("baseColorTexture").is_some(), "fabrics stay");
    }
}

#[test]
fn the_size_can_be_asked_for() {
    let server = Server::shared();
    let id = upload(&server, "hero-t-shirt.glb");
    let with = |size: u32| {
        draped(&server, &id, json!({"textures": false, "detail": "normal_map", "normal_map_size": size}))
    };
    assert!(with(128).len() < with(512).len());
    for (size, detail) in [(100, "normal_map"), (4096, "normal_map"), (256, "mesh")] {
        let refused = server.drape(&request(&id, json!({"detail": detail, "normal_map_size": size})));
        refused.assert_problem(400, "invalid-field", Some("/output/normal_map_size"));
    }
}

#[test]
fn a_sequence_and_an_outfit_without_uvs_are_refused() {
    let server = Server::shared();
    let id = server.upload_skirt();
    let refused = server.drape(&request(&id, json!({"detail": "normal_map"})));
    refused.assert_problem(422, "no-uvs", Some("/output/detail"));
    for word in ["skirt", "UVs", "mesh"] {
        assert!(refused.text().contains(word), "{word}: {}", refused.text());
    }
    let pose = json!({"kind": "preset", "id": "walk-1"});
    for frames in [json!({"motion": "walk"}), json!({"poses": [pose, pose]})] {
        let mut request = json!({"outfit": id, "output": {"detail": "normal_map"}});
        request.as_object_mut().unwrap().extend(frames.as_object().unwrap().clone());
        server.drape(&request).assert_problem(422, "single-pose-only", Some("/output/detail"));
    }
}
