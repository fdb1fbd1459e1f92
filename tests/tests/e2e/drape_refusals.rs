//! Drapes that are refused: each mistake with its own code and a pointer to it.

use serde_json::{Value, json};
use toile_tests::{Server, ServerOptions};

const NOBODY: &str = "0123456789abcdef0123456789abcdef";

/// Adds `fields` to a request for the sample outfit and asserts how it is refused.
#[track_caller]
fn assert_refused(fields: Value, status: u16, code: &str, pointer: &str) {
    let server = Server::shared();
    let mut request = json!({"outfit": server.upload_skirt()});
    request.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
    server.drape(&request).assert_problem(status, code, Some(pointer));
}

fn measurements(values: Value) -> Value {
    json!({"body": {"kind": "measurements", "values": values}})
}

fn phenotypes(values: Value) -> Value {
    json!({"body": {"kind": "phenotypes", "values": values}})
}

fn joints(rotations: Value) -> Value {
    json!({"pose": {"kind": "joints", "rotations": rotations}})
}

#[test]
fn an_unknown_outfit() {
    let answer = Server::shared().drape(&json!({"outfit": NOBODY}));
    answer.assert_problem(404, "unknown-outfit", Some("/outfit"));
}

#[test]
fn a_request_that_is_not_json() {
    let server = Server::shared();
    let json = [("content-type", "application/json")];
    server.request("POST", "/v1/drapes", &json, b"{\"outfit\": ").assert_problem(400, "invalid-json", None);
    server.request("POST", "/v1/drapes", &json, b"{\"outfit\": NaN}").assert_problem(
        400,
        "invalid-json",
        None,
    );
    let text = [("content-type", "text/plain")];
    server.request("POST", "/v1/drapes", &text, b"{}").assert_problem(415, "unsupported-media-type", None);
}

#[test]
fn a_field_that_is_not_known() {
    assert_refused(json!({"colour": "red"}), 400, "unknown-field", "/colour");
    assert_refused(json!({"output": {"format": "usdz"}}), 400, "unknown-field", "/output/format");
    let pose = json!({"pose": {"kind": "preset", "id": "squat", "speed": 2}});
    assert_refused(pose, 400, "unknown-field", "/pose/speed");
    let both = json!({"pose": {"kind": "preset", "id": "squat", "rotations": {}}});
    assert_refused(both, 400, "unknown-field", "/pose/rotations");
}

#[test]
fn a_field_that_is_missing() {
    Server::shared().drape(&json!({})).assert_problem(400, "missing-field", Some(""));
    assert_refused(json!({"pose": {"id": "squat"}}), 400, "missing-field", "/pose");
    assert_refused(json!({"pose": {"kind": "preset"}}), 400, "missing-field", "/pose");
    assert_refused(json!({"pose": {"kind": "joints"}}), 400, "missing-field", "/pose");
    assert_refused(json!({"body": {}}), 400, "missing-field", "/body");
    assert_refused(json!({"body": {"kind": "scan"}}), 400, "missing-field", "/body");
}

#[test]
fn a_field_of_the_wrong_kind() {
    assert_refused(json!({"body": {"kind": "portrait"}}), 400, "invalid-field", "/body/kind");
    assert_refused(joints(json!({"hips": [0, 0, 1]})), 400, "invalid-field", "/pose/rotations/hips");
    assert_refused(json!({"output": {"method": "magic"}}), 400, "invalid-field", "/output/method");
    assert_refused(json!({"output": {"include": []}}), 400, "invalid-field", "/output/include");
    assert_refused(json!({"output": {"include": ["hat"]}}), 400, "invalid-field", "/output/include/0");
    let both = json!({"pose": {"kind": "preset", "id": "squat"}, "motion": "walk"});
    assert_refused(both, 400, "invalid-field", "/motion");
    assert_refused(json!({"frame_rate": 24}), 400, "invalid-field", "/frame_rate");
    assert_refused(json!({"motion": "walk", "frame_rate": 0}), 400, "invalid-field", "/frame_rate");
}

#[test]
fn a_joint_that_is_not_known() {
    assert_refused(joints(json!({"tail": [0, 0, 0, 1]})), 400, "unknown-joint", "/pose/rotations/tail");
}

#[test]
fn a_quaternion_that_is_not_of_length_one() {
    let at = "/pose/rotations/leftUpperArm";
    assert_refused(joints(json!({"leftUpperArm": [0, 0, 0, 0]})), 400, "non-unit-quaternion", at);
    assert_refused(joints(json!({"leftUpperArm": [0.5, 0, 0, 1]})), 400, "non-unit-quaternion", at);
    assert_refused(joints(json!({"leftUpperArm": [1e30, 0, 0, 1]})), 400, "non-unit-quaternion", at);
}

#[test]
fn a_pose_or_motion_that_is_not_known() {
    let pose = json!({"kind": "preset", "id": "moonwalk"});
    assert_refused(json!({"pose": pose}), 400, "unknown-pose", "/pose/id");
    assert_refused(
        json!({"poses": [{"kind": "preset", "id": "squat"}, pose]}),
        400,
        "unknown-pose",
        "/poses/1/id",
    );
    assert_refused(json!({"motion": "moonwalk"}), 400, "unknown-motion", "/motion");
}

#[test]
fn a_sequence_that_is_empty_or_too_long() {
    assert_refused(json!({"poses": []}), 400, "empty-sequence", "/poses");
    let pose = json!({"kind": "preset", "id": "squat"});
    assert_refused(json!({"poses": vec![pose; 257]}), 400, "too-many-frames", "/poses");
}

#[test]
fn a_body_parameter_that_is_not_known_or_out_of_range() {
    assert_refused(phenotypes(json!({"charm": 1})), 400, "unknown-phenotype", "/body/values/charm");
    assert_refused(phenotypes(json!({"gender": 1.5})), 400, "phenotype-out-of-range", "/body/values/gender");
    assert_refused(phenotypes(json!({"age": 1e300})), 400, "phenotype-out-of-range", "/body/values/age");
    assert_refused(measurements(json!({"wrist": 16})), 400, "unknown-measurement", "/body/values/wrist");
}

#[test]
fn measurements_that_no_body_has() {
    assert_refused(measurements(json!({"height": 1.68})), 422, "measurement-units", "/body/values/height");
    assert_refused(
        measurements(json!({"height": 400})),
        422,
        "measurement-out-of-range",
        "/body/values/height",
    );
    assert_refused(
        measurements(json!({"height": 1e300})),
        422,
        "measurement-out-of-range",
        "/body/values/height",
    );
    let server = Server::shared();
    let request = json!({
        "outfit": server.upload_skirt(),
        "body": {"kind": "measurements", "values": {"height": 150, "inseam": 95, "weight": 45, "hip": 140}},
    });
    let answer = server.drape(&request);
    assert_eq!(answer.json()["code"], "unreachable-measurements", "{}", answer.text());
    assert_eq!(answer.status, 422);
    assert!(answer.json()["pointer"].as_str().unwrap().starts_with("/body/values/"));
}

#[test]
fn a_drape_whose_time_is_over() {
    let server = ServerOptions::default().with(&["--answers", "1"]).start();
    server.get("/v1/drapes/0123456789abcdef0123456789abcdef/drape.glb").assert_problem(
        404,
        "drape-expired",
        None,
    );
    let outfit = server.upload_skirt();
    let request = |weight: f64| {
        json!({"outfit": outfit, "body": {"kind": "phenotypes", "values": {"weight": weight}},
               "output": {"include": ["outfit", "body"]}})
    };
    let first = server.drape_json(&request(0.1)).with_status(200).json();
    for step in 2..8 {
        server.drape_json(&request(0.1 * f64::from(step))).with_status(200);
    }
    server.get(first["url"].as_str().unwrap()).assert_problem(404, "drape-expired", None);
}
