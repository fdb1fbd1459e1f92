//! Draping.

use serde_json::{Value, json};
use toile_tests::{Glb, Server, assert_valid_glb};

const STAGES: [&str; 8] = ["parse", "static", "body", "dynamic", "skinning", "resolve", "normals", "encode"];

fn preset(outfit: &str, pose: &str) -> Value {
    json!({"outfit": outfit, "pose": {"kind": "preset", "id": pose}})
}

#[test]
fn a_drape_is_valid_gltf_with_figures_and_stages_in_its_headers() {
    let server = Server::shared();
    let answer = server.drape(&preset(&server.upload_skirt(), "contrapposto")).with_status(200);
    assert_eq!(answer.header("content-type"), "model/gltf-binary");
    assert_valid_glb(&answer.bytes);
    for stage in STAGES {
        assert!(
            answer.stage(stage).is_some_and(|(ms, _)| ms >= 0.0),
            "{stage}: {}",
            answer.header("server-timing")
        );
    }
    let quality: Value = serde_json::from_str(answer.header("x-toile-quality")).unwrap();
    for figure in
        ["penetration_before_percent", "penetration_after_percent", "p95_edge_strain", "max_edge_stretch"]
    {
        assert!(quality[figure].as_f64().unwrap() >= 0.0, "{quality}");
    }
    assert!(quality["penetration_after_percent"].as_f64().unwrap() <= 0.5, "{quality}");
    assert!(quality["max_edge_stretch"].as_f64().unwrap() <= 2.0, "{quality}");
}

#[test]
fn a_json_answer_has_the_url_of_the_same_bytes_and_all_figures() {
    let server = Server::shared();
    let request = preset(&server.upload_skirt(), "walk-2");
    let binary = server.drape(&request).with_status(200);
    let answer = server.drape_json(&request).with_status(200);
    let json = answer.json();
    assert_eq!(json["method"], "deepsd");
    assert_eq!(json["bytes"], binary.bytes.len());
    let quality: Value = serde_json::from_str(binary.header("x-toile-quality")).unwrap();
    assert_eq!(json["quality"], quality);
    for stage in STAGES {
        assert!(json["timing"][stage].is_number(), "{stage}: {}", json["timing"]);
    }
    assert_eq!(json["body"]["phenotypes"]["gender"], 0.5);
    assert!((json["body"]["measurements"]["height"].as_f64().unwrap() - 183.8).abs() < 30.0);
    let url = json["url"].as_str().unwrap();
    let fetched = server.get(url).with_status(200);
    assert_eq!(fetched.bytes, binary.bytes);
    assert_eq!(fetched.header("content-type"), "model/gltf-binary");
    server.get_with(url, &[("if-none-match", fetched.header("etag"))]).with_status(304);
}

#[test]
fn the_same_request_gives_the_same_bytes_on_every_thread_and_server() {
    let server = Server::shared();
    let request = preset(&server.upload_skirt(), "lunge");
    let first = server.drape(&request).with_status(200);
    let others: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..6).map(|_| scope.spawn(|| server.drape(&request))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(others.iter().all(|other| other.bytes == first.bytes));
    let another = Server::start();
    another.upload_skirt();
    assert!(another.drape(&request).bytes == first.bytes, "another server answers differently");
}

#[test]
fn the_body_can_be_included_and_is_the_node_named_body() {
    let server = Server::shared();
    let mut request = preset(&server.upload_skirt(), "sitting");
    request["output"] = json!({"include": ["outfit", "body"]});
    let answer = server.drape(&request).with_status(200);
    assert_valid_glb(&answer.bytes);
    let glb = Glb::parse(&answer.bytes);
    assert_eq!(glb.nodes(), ["skirt", "body"]);
    let lowest = glb.positions("body").iter().map(|p| p[1]).fold(f32::MAX, f32::min);
    assert!(lowest.abs() < 1e-3, "the body stands at {lowest}");
    request["output"] = json!({"include": ["body"]});
    assert_eq!(Glb::parse(&server.drape(&request).bytes).nodes(), ["body"]);
}

#[test]
fn the_pose_moves_the_cloth_and_the_shape_widens_it() {
    let server = Server::shared();
    let outfit = server.upload_skirt();
    let positions =
        |request: &Value| Glb::parse(&server.drape(request).with_status(200).bytes).positions("skirt");
    let width = |positions: &[[f32; 3]]| {
        let x = positions.iter().map(|p| p[0]);
        x.clone().fold(f32::MIN, f32::max) - x.fold(f32::MAX, f32::min)
    };
    let standing = positions(&json!({"outfit": outfit}));
    let sitting = positions(&preset(&outfit, "sitting"));
    let heavy =
        positions(&json!({"outfit": outfit, "body": {"kind": "phenotypes", "values": {"weight": 1.0}}}));
    let front = |positions: &[[f32; 3]]| positions.iter().map(|p| p[2]).fold(f32::MIN, f32::max);
    let waist = |positions: &[[f32; 3]]| positions.iter().map(|p| p[1]).fold(f32::MIN, f32::max);
    assert!(front(&sitting) > front(&standing) + 0.05, "the skirt does not follow the thighs");
    assert!(waist(&sitting) < waist(&standing) - 0.2, "the skirt does not go down with the hips");
    assert!(width(&heavy) > width(&standing) + 0.01, "{} and {}", width(&heavy), width(&standing));
}

#[test]
fn nothing_stated_is_the_reference_body_in_the_a_pose() {
    let server = Server::shared();
    let outfit = server.upload_skirt();
    let plain = server.drape(&json!({"outfit": outfit})).with_status(200);
    let stated = server.drape(&json!({
        "outfit": outfit,
        "body": {"kind": "phenotypes", "values": {}},
        "pose": {"kind": "preset", "id": "a-pose"},
        "output": {"include": ["outfit"], "method": "deepsd"},
    }));
    let joints = server.drape(&json!({"outfit": outfit, "pose": {"kind": "joints", "rotations": {}}}));
    let measured = server.drape(&json!({"outfit": outfit, "body": {"kind": "measurements", "values": {}}}));
    assert!(plain.bytes == stated.bytes, "an explicit default differs");
    assert!(plain.bytes == joints.bytes, "no rotations differ from the A-pose");
    assert!(plain.bytes == measured.bytes, "no measurements differ from the reference body");
}

#[test]
fn joint_rotations_pose_the_body() {
    let server = Server::shared();
    let outfit = server.upload_skirt();
    let quarter = std::f32::consts::FRAC_PI_4;
    let request = json!({
        "outfit": outfit,
        "pose": {"kind": "joints", "rotations": {"leftUpperLeg": [-quarter.sin(), 0.0, 0.0, quarter.cos()]}},
        "output": {"include": ["body"]},
    });
    let body = Glb::parse(&server.drape(&request).with_status(200).bytes).positions("body");
    let front = body.iter().map(|p| p[2]).fold(f32::MIN, f32::max);
    assert!(front > 0.5, "the left leg is not raised forwards: {front}");
}

#[test]
fn every_method_drapes_and_each_in_its_own_way() {
    let server = Server::shared();
    let mut request = preset(&server.upload_skirt(), "squat");
    let mut answers = Vec::new();
    for method in ["deepsd", "deepsd-concat", "skinning"] {
        request["output"] = json!({"method": method});
        let answer = server.drape(&request).with_status(200);
        assert_valid_glb(&answer.bytes);
        answers.push(answer.bytes);
    }
    assert!(answers[0] != answers[1] && answers[1] != answers[2] && answers[0] != answers[2]);
}

#[test]
fn every_preset_drapes() {
    let server = Server::shared();
    let outfit = server.upload_skirt();
    let poses = server.get("/v1/poses").json();
    for pose in poses["data"].as_array().unwrap() {
        let answer = server.drape(&preset(&outfit, pose["id"].as_str().unwrap()));
        assert_eq!(answer.status, 200, "{pose}: {}", answer.text());
    }
}

#[test]
fn attributes_are_added_when_asked_for() {
    let server = Server::shared();
    let mut request = preset(&server.upload_skirt(), "lunge");
    let plain = Glb::parse(&server.drape(&request).bytes);
    assert!(!plain.has_attribute("skirt", "_STRAIN") && !plain.has_attribute("skirt", "_PENETRATION"));
    request["output"] = json!({"attributes": ["strain", "penetration"]});
    let answer = server.drape(&request).with_status(200);
    assert_valid_glb(&answer.bytes);
    let glb = Glb::parse(&answer.bytes);
    let strain = glb.attribute("skirt", "_STRAIN");
    assert_eq!(strain.len(), glb.positions("skirt").len());
    assert!(strain.iter().any(|value| value.abs() > 1e-4) && strain.iter().all(|value| value.abs() < 1.0));
    assert!(glb.attribute("skirt", "_PENETRATION").iter().all(|depth| (0.0..0.3).contains(depth)));
}

#[test]
fn several_poses_are_one_animation() {
    let server = Server::shared();
    let outfit = server.upload_skirt();
    let pose = |id: &str| json!({"kind": "preset", "id": id});
    let request = json!({
        "outfit": outfit,
        "poses": [pose("standing"), pose("walk-1"), pose("squat")],
        "frame_rate": 2,
        "output": {"include": ["outfit", "body"]},
    });
    let answer = server.drape(&request).with_status(200);
    assert_valid_glb(&answer.bytes);
    let glb = Glb::parse(&answer.bytes);
    assert_eq!(glb.json["animations"].as_array().unwrap().len(), 1);
    assert!(glb.primitive("skirt")["targets"].as_array().is_some_and(|targets| targets.len() >= 2));
    let times = &glb.json["animations"][0]["samplers"][0]["input"];
    let last = &glb.json["accessors"][times.as_u64().unwrap() as usize]["max"][0];
    assert!((last.as_f64().unwrap() - 1.0).abs() < 1e-6, "three frames at 2 a second end at {last}");
}

#[test]
fn a_motion_is_an_animation_of_all_its_frames() {
    let server = Server::shared();
    let motions = server.get("/v1/motions").json();
    let walk = motions["data"].as_array().unwrap().iter().find(|motion| motion["id"] == "walk").unwrap();
    let answer = server.drape(&json!({"outfit": server.upload_skirt(), "motion": "walk"})).with_status(200);
    assert_valid_glb(&answer.bytes);
    let glb = Glb::parse(&answer.bytes);
    let times = &glb.json["animations"][0]["samplers"][0]["input"];
    let count = &glb.json["accessors"][times.as_u64().unwrap() as usize]["count"];
    assert_eq!(count, &walk["frames"]);
}
