//! The command line.

use std::path::{Path, PathBuf};

use serde_json::json;
use toile_tests::{Glb, ServerOptions, assert_valid_glb, skirt, toile};

fn write(folder: &Path, name: &str, bytes: &[u8]) -> String {
    let path: PathBuf = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn ingested_outfits_are_what_a_server_on_the_same_data_has() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let files = [1.0, 1.2].map(|flare| write(folder.path(), &format!("{flare}.glb"), &skirt(flare).glb()));
    let arguments = ["ingest", &files[0], &files[1], "--data", data.to_str().unwrap()];
    let output = toile(&arguments);
    assert_eq!(output.code, 0, "{}", output.stderr);
    let lines: Vec<&str> = output.stdout.lines().collect();
    assert!(lines.len() == 2 && lines.iter().all(|line| line.contains("1008 vertices")), "{}", output.stdout);
    assert!(toile(&arguments).stdout.contains("known"));

    let server = ServerOptions::default().on(&data).start();
    let listed = server.get("/v1/outfits").json();
    for (line, outfit) in lines.iter().zip(listed["data"].as_array().unwrap()) {
        assert!(line.starts_with(outfit["id"].as_str().unwrap()), "{line}");
    }
}

#[test]
fn a_file_that_is_refused_is_named_and_the_others_are_taken() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let good = write(folder.path(), "good.glb", &skirt(1.0).glb());
    let bad = write(folder.path(), "bad.glb", b"glTF");
    let output = toile(&["ingest", &bad, &good, "--data", data.to_str().unwrap()]);
    assert_eq!(output.code, 1);
    assert!(output.stderr.contains("bad.glb") && output.stderr.contains("truncated"), "{}", output.stderr);
    assert_eq!(output.stdout.lines().count(), 1, "{}", output.stdout);
}

#[test]
fn a_drape_by_command_line_is_the_drape_of_the_server() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let outfit = write(folder.path(), "skirt.glb", &skirt(1.0).glb());
    let body = json!({"kind": "phenotypes", "values": {"weight": 0.7}});
    let pose = json!({"kind": "joints", "rotations": {"leftUpperLeg": [-0.383, 0.0, 0.0, 0.924]}});
    let (body_file, pose_file) = (
        write(folder.path(), "body.json", body.to_string().as_bytes()),
        write(folder.path(), "pose.json", pose.to_string().as_bytes()),
    );
    let server = ServerOptions::default().on(&data).start();
    let id = server.upload_skirt();
    let request = json!({
        "outfit": id, "body": body, "pose": pose,
        "output": {"include": ["outfit", "body"], "method": "deepsd-concat"},
    });
    let served = server.drape(&request).with_status(200).bytes;
    for source in [outfit.as_str(), id.as_str()] {
        let out = folder.path().join("out.glb");
        let output = toile(&[
            "drape",
            "--outfit",
            source,
            "--body",
            &body_file,
            "--pose",
            &pose_file,
            "--method",
            "deepsd-concat",
            "--include",
            "outfit,body",
            "--data",
            data.to_str().unwrap(),
            "-o",
            out.to_str().unwrap(),
        ]);
        assert_eq!(output.code, 0, "{}", output.stderr);
        let written = std::fs::read(&out).unwrap();
        assert_valid_glb(&written);
        assert!(written == served, "--outfit {source} gives other bytes");
        assert!(output.stderr.contains("penetration_after_percent"), "{}", output.stderr);
    }
}

#[test]
fn a_motion_can_be_draped_by_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let outfit = write(folder.path(), "skirt.obj", &skirt(1.0).obj());
    let out = folder.path().join("walk.glb");
    let output = toile(&["drape", "--outfit", &outfit, "--motion", "walk", "-o", out.to_str().unwrap()]);
    assert_eq!(output.code, 0, "{}", output.stderr);
    assert!(Glb::parse(&std::fs::read(&out).unwrap()).json["animations"].is_array());
}

#[test]
fn mistakes_are_explained_on_stderr_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let outfit = write(folder.path(), "skirt.glb", &skirt(1.0).glb());
    let out = folder.path().join("out.glb");
    let out_text = out.to_str().unwrap();
    let wrong_body =
        write(folder.path(), "body.json", br#"{"kind": "measurements", "values": {"height": 1.68}}"#);
    let cases: [(&[&str], &str); 6] = [
        (&["drape", "--outfit", &outfit, "--pose", "moonwalk", "-o", out_text], "moonwalk"),
        (&["drape", "--outfit", &outfit, "--body", &wrong_body, "-o", out_text], "did you mean 168 cm?"),
        (&["drape", "--outfit", &outfit, "--method", "magic", "-o", out_text], "deepsd-concat"),
        (&["drape", "--outfit", "/nowhere.glb", "--data", "/nowhere", "-o", out_text], "/nowhere.glb"),
        (&["drape", "--outfit", &outfit, "--onnxruntime", "/nowhere.so", "-o", out_text], "/nowhere.so"),
        (&["serve", "--artifacts", "/nowhere"], "--artifacts"),
    ];
    for (arguments, hint) in cases {
        let output = toile(arguments);
        assert_eq!(output.code, 1, "{arguments:?}: {}", output.stderr);
        assert!(output.stderr.contains(hint), "{arguments:?}: {}", output.stderr);
        assert!(!out.exists());
    }
    assert_eq!(toile(&["drape"]).code, 2);
}

#[test]
fn the_artifacts_can_be_checked_and_the_poses_listed() {
    let check = toile(&["check"]);
    assert_eq!(check.code, 0, "{}", check.stderr);
    for word in ["body", "onnxruntime", "networks", "gallery"] {
        assert!(check.stdout.contains(word), "{}", check.stdout);
    }
    let poses = toile(&["poses"]);
    assert_eq!(poses.code, 0, "{}", poses.stderr);
    assert!(poses.stdout.contains("contrapposto") && poses.stdout.contains("walk"), "{}", poses.stdout);
}

#[test]
fn the_stages_can_be_measured() {
    let folder = tempfile::tempdir().unwrap();
    let outfit = write(folder.path(), "skirt.glb", &skirt(1.0).glb());
    let output = toile(&["bench", "--outfit", &outfit, "--seconds", "0.05"]);
    assert_eq!(output.code, 0, "{}", output.stderr);
    for row in ["static pass", "| dynamic |", "| encode |", "warm drapes", "times as fast"] {
        assert!(output.stdout.contains(row), "no {row} in\n{}", output.stdout);
    }
}
