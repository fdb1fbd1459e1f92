//! What is the same for every route.

use serde_json::json;
use toile_tests::{Server, ServerOptions};

#[test]
fn a_server_that_is_up_says_so() {
    let server = Server::shared();
    assert_eq!(server.get("/healthz").with_status(200).json(), json!({"status": "ok"}));
    assert_eq!(server.get("/readyz").with_status(200).json(), json!({"status": "ready"}));
}

#[test]
fn what_does_not_exist_is_a_problem() {
    let server = Server::shared();
    for path in ["/v1", "/v1/", "/v1/nothing", "/v1/outfits/x/y"] {
        server.get(path).assert_problem(404, "not-found", None);
    }
    server.request("POST", "/v1/nothing", &[], &[]).assert_problem(404, "not-found", None);
    server.get("/missing.js").assert_problem(404, "not-found", None);
}

#[test]
fn a_method_that_a_route_does_not_take_is_a_problem_and_the_others_are_named() {
    let server = Server::shared();
    for (method, path, allowed) in [
        ("DELETE", "/v1/outfits", "POST"),
        ("GET", "/v1/drapes", "POST"),
        ("PUT", "/v1/body", "GET"),
        ("POST", "/healthz", "GET"),
        ("POST", "/", "GET"),
    ] {
        let answer = server.request(method, path, &[], &[]);
        answer.assert_problem(405, "method-not-allowed", None);
        assert!(answer.header("allow").contains(allowed), "{method} {path}: {:?}", answer.header("allow"));
    }
}

#[test]
fn a_json_body_that_is_too_long_is_a_problem() {
    // Barely too long: a server may close before a longer one is sent whole, and then there is no answer to read.
    let body = json!({"outfit": "x".repeat(4 * 1024 * 1024)});
    Server::shared().drape(&body).assert_problem(413, "too-large", None);
}

#[test]
fn every_answer_and_its_log_lines_have_the_request_id() {
    let server = Server::start();
    let own = server.get("/v1/nothing");
    assert_eq!(own.header("x-request-id").len(), 16);
    let given = server.get_with("/v1/body", &[("x-request-id", "order-17")]);
    assert_eq!(given.header("x-request-id"), "order-17");
    let harmful = server.get_with("/v1/body", &[("x-request-id", "a b=\"c\"")]);
    assert_eq!(harmful.header("x-request-id").len(), 16);
    let log = server.log();
    assert!(log.contains("order-17") && log.contains(own.header("x-request-id")), "{log}");
    assert!(!log.contains("a b="), "{log}");
}

#[test]
fn a_page_of_another_origin_may_drape_and_read_the_figures() {
    let server = Server::shared();
    let preflight = server.request(
        "OPTIONS",
        "/v1/drapes",
        &[
            ("origin", "https://shop.example"),
            ("access-control-request-method", "POST"),
            ("access-control-request-headers", "content-type"),
        ],
        &[],
    );
    assert_eq!(preflight.status, 200);
    assert_eq!(preflight.header("access-control-allow-origin"), "*");
    assert!(preflight.header("access-control-allow-methods").contains("POST"));
    assert!(!preflight.header("access-control-allow-methods").contains("DELETE"));
    let answer = server.get_with("/v1/poses", &[("origin", "https://shop.example")]);
    assert_eq!(answer.header("access-control-allow-origin"), "*");
    let exposed = answer.header("access-control-expose-headers").to_lowercase();
    for header in ["server-timing", "x-toile-quality", "x-request-id"] {
        assert!(exposed.contains(header), "{exposed}");
    }
}

#[test]
fn the_page_is_served_with_its_assets_kept_for_good() {
    let page = tempfile::tempdir().unwrap();
    std::fs::create_dir(page.path().join("assets")).unwrap();
    std::fs::write(page.path().join("index.html"), "<title>Toile</title>").unwrap();
    std::fs::write(page.path().join("assets/page-1a2b.js"), "export {}").unwrap();
    let server = ServerOptions::default().with(&["--web", page.path().to_str().unwrap()]).start();
    for path in ["/", "/index.html", "/outfits/some-page"] {
        let answer = server.get(path).with_status(200);
        assert_eq!(answer.text(), "<title>Toile</title>", "{path}");
        assert_eq!(answer.header("cache-control"), "public, no-cache");
        assert!(answer.header("content-type").starts_with("text/html"));
    }
    let script = server.get("/assets/page-1a2b.js").with_status(200);
    assert!(script.header("cache-control").contains("immutable"));
    assert!(script.header("content-type").contains("javascript"));
    server.get("/assets/missing.js").assert_problem(404, "not-found", None);
    server.get("/%2e%2e/Cargo.toml").assert_problem(404, "not-found", None);
    assert_eq!(server.get("/%2e%2e/%2e%2e/%2e%2e/etc/passwd").text(), "<title>Toile</title>");
}

#[test]
fn without_a_page_the_server_says_how_to_build_it() {
    let empty = tempfile::tempdir().unwrap();
    let server = ServerOptions::default().with(&["--web", empty.path().to_str().unwrap()]).start();
    let answer = server.get("/");
    answer.assert_problem(404, "not-found", None);
    assert!(answer.json()["detail"].as_str().unwrap().contains("make build"));
}
