//! The body: parameters, reference mesh, measurements, poses.

use serde_json::{Value, json};
use toile_tests::{Form, Glb, Mesh, Server, assert_valid_glb, skirt};

const MEASUREMENTS: [&str; 11] = [
    "height",
    "weight",
    "chest",
    "underbust",
    "waist",
    "hip",
    "inseam",
    "shoulder_width",
    "arm_length",
    "neck",
    "thigh",
];
const POSES: [&str; 14] = [
    "a-pose",
    "t-pose",
    "standing",
    "contrapposto",
    "walk-1",
    "walk-2",
    "walk-3",
    "walk-4",
    "arms-up",
    "hands-on-hips",
    "sitting",
    "squat",
    "reach",
    "lunge",
];

fn names(list: &Value, field: &str) -> Vec<String> {
    list.as_array().unwrap().iter().map(|entry| entry[field].as_str().unwrap().to_owned()).collect()
}

fn solve(server: &Server, request: &Value) -> Value {
    server.post("/v1/bodies", request).with_status(200).json()
}

#[test]
fn the_parameters_of_the_body_are_listed_with_their_ranges() {
    let body = Server::shared().get("/v1/body").with_status(200).json();
    assert_eq!(
        names(&body["phenotypes"], "name"),
        ["gender", "age", "muscle", "weight", "height", "proportions"]
    );
    assert_eq!(names(&body["measurements"], "name"), MEASUREMENTS);
    assert_eq!(body["local_changes"].as_array().unwrap().len(), 20);
    for list in ["phenotypes", "measurements", "local_changes"] {
        for entry in body[list].as_array().unwrap() {
            let [min, default, max] = ["min", "default", "max"].map(|field| entry[field].as_f64().unwrap());
            assert!(min < default && default < max, "{entry}");
        }
    }
    assert_eq!(body["joints"][0], json!({"name": "hips", "parent": null}));
    let joints = names(&body["joints"], "name");
    for joint in ["spine", "head", "leftUpperArm", "rightFoot"] {
        assert!(joints.iter().any(|name| name == joint), "no {joint}");
    }
    assert!(body["vertices"].as_u64().unwrap() > 10_000);
}

#[test]
fn the_reference_body_is_valid_gltf_and_as_large_as_its_parameters_say() {
    let server = Server::shared();
    let body = server.get("/v1/body").json();
    let answer = server.get("/v1/body/reference.glb").with_status(200);
    assert_eq!(answer.header("content-type"), "model/gltf-binary");
    assert_valid_glb(&answer.bytes);
    let positions = Glb::parse(&answer.bytes).positions("body");
    assert_eq!(body["vertices"], positions.len());
    let top = positions.iter().map(|p| p[1]).fold(f32::MIN, f32::max);
    let height = body["measurements"][0]["default"].as_f64().unwrap();
    assert!((f64::from(top) * 100.0 - height).abs() < 1.0, "{top} m and {height} cm");
    let known = server.get_with("/v1/body/reference.glb", &[("if-none-match", answer.header("etag"))]);
    known.with_status(304);
}

#[test]
fn measurements_are_met_and_the_solved_shape_can_be_sent_back() {
    let server = Server::shared();
    let wanted = json!({"height": 168, "bust": 92, "waist": 74, "hip": 100});
    let solved = solve(&server, &json!({"measurements": wanted, "gender": 1.0}));
    assert_eq!(solved["phenotypes"]["gender"], 1.0);
    for (name, value) in [("height", 168.0), ("chest", 92.0), ("waist", 74.0), ("hip", 100.0)] {
        let of = &solved["measurements"][name];
        let [requested, achieved, residual] =
            ["requested", "achieved", "residual"].map(|field| of[field].as_f64().unwrap());
        assert!((requested - value).abs() < 1e-3, "{name}: {of}");
        assert!((achieved - value).abs() < 1.0, "{name}: {of}");
        assert!((achieved - requested - residual).abs() < 1e-3, "{name}: {of}");
    }
    assert!(solved["measurements"]["neck"]["requested"].is_null());
    assert!(solved["measurements"]["neck"]["achieved"].as_f64().unwrap() > 20.0);

    let request = json!({"outfit": server.upload_skirt(), "body": solved["shape"]});
    let drape = server.drape_json(&request).with_status(200).json();
    let height = drape["body"]["measurements"]["height"].as_f64().unwrap();
    assert!((height - solved["measurements"]["height"]["achieved"].as_f64().unwrap()).abs() < 0.01);
}

#[test]
fn no_measurements_are_the_reference_body() {
    let server = Server::shared();
    let solved = solve(&server, &json!({"measurements": {}}));
    let body = server.get("/v1/body").json();
    for entry in body["measurements"].as_array().unwrap() {
        let achieved = &solved["measurements"][entry["name"].as_str().unwrap()]["achieved"];
        assert!(
            (achieved.as_f64().unwrap() - entry["default"].as_f64().unwrap()).abs() < 0.2,
            "{entry}: {achieved}"
        );
    }
}

#[test]
fn metres_instead_of_centimetres_are_asked_about() {
    let answer = Server::shared().post("/v1/bodies", &json!({"measurements": {"height": 1.68}}));
    answer.assert_problem(422, "measurement-units", Some("/measurements/height"));
    assert!(answer.json()["detail"].as_str().unwrap().contains("did you mean 168 cm?"), "{}", answer.text());
}

#[test]
fn wrong_measurements_are_refused() {
    let server = Server::shared();
    let refused = |request: &Value, status, code, pointer| {
        server.post("/v1/bodies", request).assert_problem(status, code, Some(pointer));
    };
    refused(&json!({"measurements": {"wrist": 16}}), 400, "unknown-measurement", "/measurements/wrist");
    refused(&json!({"measurements": {"chest": 90, "bust": 91}}), 400, "invalid-field", "/measurements/chest");
    refused(&json!({"measurements": {"waist": 500}}), 422, "measurement-out-of-range", "/measurements/waist");
    refused(&json!({"measurements": {"waist": "slim"}}), 400, "invalid-field", "/measurements/waist");
    refused(&json!({"measurements": {}, "gender": 2}), 400, "phenotype-out-of-range", "/gender");
    refused(&json!({"measurements": {}, "age": 0.5}), 400, "unknown-field", "/age");
    refused(&json!({}), 400, "missing-field", "");
}

#[test]
fn the_poses_and_motions_are_listed_and_a_pose_can_be_sent_back() {
    let server = Server::shared();
    let poses = server.get("/v1/poses").with_status(200).json();
    let ids = names(&poses["data"], "id");
    assert!(POSES.iter().all(|pose| ids.iter().any(|id| id == pose)), "{ids:?}");
    assert!(names(&poses["data"], "label").iter().all(|label| !label.is_empty()));
    let motions = server.get("/v1/motions").with_status(200).json();
    let walk = motions["data"].as_array().unwrap().iter().find(|motion| motion["id"] == "walk").unwrap();
    assert!(walk["frames"].as_u64().unwrap() >= 12 && walk["frame_rate"].as_f64().unwrap() >= 12.0);

    let squat = server.get("/v1/poses/squat").with_status(200).json();
    let outfit = server.upload_skirt();
    let joints = json!({"kind": "joints", "rotations": squat["rotations"]});
    let sent_back = server.drape(&json!({"outfit": outfit, "pose": joints})).with_status(200);
    let by_name = server.drape(&json!({"outfit": outfit, "pose": {"kind": "preset", "id": "squat"}}));
    let [sent_back, by_name] = [sent_back, by_name].map(|drape| Glb::parse(&drape.bytes).positions("skirt"));
    // The preset may also move the hips sideways, which rotations do not say: shapes agree, places need not.
    let drop = |positions: &[[f32; 3]]| positions[0][1] - positions[positions.len() - 1][1];
    assert!((drop(&sent_back) - drop(&by_name)).abs() < 0.01);
    server.get("/v1/poses/moonwalk").assert_problem(404, "not-found", None);
}

/// The draped body of some values as a mesh of other vertices and triangles: every second of its triangles, unwelded.
fn scan_of(server: &Server, values: &Value) -> Mesh {
    let body = json!({"kind": "phenotypes", "values": values});
    let outfit = server.upload_skirt();
    let request = json!({"outfit": outfit, "body": body, "output": {"include": ["body"]}});
    let glb = Glb::parse(&server.drape(&request).with_status(200).bytes);
    let (positions, triangles) = (glb.positions("body"), glb.triangles("body"));
    let corners: Vec<[f32; 3]> =
        triangles.iter().step_by(2).flatten().map(|&i| positions[i as usize]).collect();
    let count = corners.len() as u32;
    Mesh { positions: corners, triangles: (0..count / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect() }
}

#[test]
fn a_scan_becomes_the_body_that_is_nearest_to_it() {
    let server = Server::shared();
    let values = json!({"gender": 1.0, "weight": 0.7, "height": 0.35});
    let due = server.drape_json(
        &json!({"outfit": server.upload_skirt(), "body": {"kind": "phenotypes", "values": values}}),
    );
    let scan = scan_of(&server, &values).map(|p| p.map(|x| 100.0 * x));
    for form in [
        Form::file("scan.obj", &scan.obj()),
        Form::file("scan.glb", &scan.glb()).metadata(&json!({"units": "cm"})),
    ] {
        let (kind, bytes) = form.encode();
        let answer =
            server.request("POST", "/v1/bodies", &[("content-type", &kind)], &bytes).with_status(200).json();
        assert!(answer["scan"]["distance_mm"].as_f64().unwrap() < 5.0, "{}", answer["scan"]);
        assert!(answer["scan"]["unseen_percent"].as_f64().unwrap() < 10.0, "{}", answer["scan"]);
        for name in MEASUREMENTS.iter().filter(|name| **name != "weight") {
            let (got, due) =
                (&answer["measurements"][name]["achieved"], &due.json()["body"]["measurements"][name]);
            assert!(
                (got.as_f64().unwrap() - due.as_f64().unwrap()).abs() < 1.5,
                "{name}: {got} instead of {due}"
            );
        }
        server.drape(&json!({"outfit": server.upload_skirt(), "body": answer["shape"]})).with_status(200);
    }
}

#[test]
fn what_is_no_scan_is_refused() {
    let server = Server::shared();
    let post = |form: Form| {
        let (kind, bytes) = form.encode();
        server.request("POST", "/v1/bodies", &[("content-type", &kind)], &bytes)
    };
    let cloth = skirt(1.0).glb();
    post(Form::file("a.glb", &cloth)).assert_problem(422, "wrong-units", Some("/file"));
    let tower = skirt(1.0).map(|[x, y, z]| [x, 3.0 * (y - 0.58), z]).glb();
    let stated = Form::file("a.glb", &tower).metadata(&json!({"units": "m", "up": "y"}));
    post(stated).assert_problem(422, "not-a-body", Some("/file"));
    post(Form::file("a.glb", b"glTF")).assert_problem(422, "truncated", Some("/file"));
    post(Form::file("a.glb", &cloth).metadata(&json!({"units": "ell"}))).assert_problem(
        400,
        "invalid-field",
        Some("/metadata/units"),
    );
    post(Form::file("a.glb", &cloth).metadata(&json!({"name": "Ada"}))).assert_problem(
        400,
        "unknown-field",
        Some("/metadata/name"),
    );
    post(Form::default()).assert_problem(400, "missing-field", Some("/file"));
}

#[test]
fn what_a_scan_knows_beyond_the_parameters_is_draped_on() {
    let server = Server::shared();
    let belly = |[x, y, z]: [f32; 3]| {
        let squared = x * x + (y - 1.12).powi(2) + (z - 0.12).powi(2);
        [x, y, z + 0.04 * (-squared / 0.012).exp()]
    };
    let (kind, bytes) = Form::file("scan.glb", &scan_of(&server, &json!({})).map(belly).glb()).encode();
    let answer =
        server.request("POST", "/v1/bodies", &[("content-type", &kind)], &bytes).with_status(200).json();
    let drape = |body: &Value| {
        let output = json!({"include": ["outfit", "body"]});
        let pose = json!({"kind": "preset", "id": "sitting"});
        let request = json!({"outfit": server.upload_skirt(), "body": body, "pose": pose, "output": output});
        server.drape(&request).with_status(200)
    };
    let parameters = json!({"kind": "phenotypes", "values": answer["phenotypes"]});
    let (scanned, plain) = (drape(&answer["shape"]), drape(&parameters));
    assert_valid_glb(&scanned.bytes);
    let [scanned, plain] = [scanned, plain].map(|answer| Glb::parse(&answer.bytes).positions("body"));
    let farthest = scanned.iter().zip(&plain).map(|(a, b)| (a[2] - b[2]).abs()).fold(0.0, f32::max);
    assert!((0.01..0.1).contains(&farthest), "the belly is {farthest} m out");

    let forgotten = json!({"outfit": server.upload_skirt(), "body": {"kind": "scan", "id": "0123"}});
    server.drape(&forgotten).assert_problem(404, "unknown-scan", Some("/body/id"));
    let valued = json!({"outfit": server.upload_skirt(), "body": {"kind": "scan", "id": "0", "values": {"gender": 1.0}}});
    server.drape(&valued).assert_problem(400, "unknown-field", Some("/body/values"));
    let named = json!({"outfit": server.upload_skirt(), "body": {"kind": "phenotypes", "id": "0"}});
    server.drape(&named).assert_problem(400, "unknown-field", Some("/body/id"));
    let fitted = Form::file("a.glb", &skirt(1.0).glb()).metadata(&json!({"fitted_on": answer["shape"]}));
    server.upload(&fitted).assert_problem(400, "invalid-field", Some("/metadata/fitted_on/kind"));
}
