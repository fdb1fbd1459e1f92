//! Slow clients, too many clients, and stopping.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use toile_tests::{Server, ServerOptions};

/// Reads until the server closes the connection.
fn read_to_end(mut stream: TcpStream) -> String {
    let mut bytes = Vec::new();
    // A reset is a way to close it too.
    let _ = stream.read_to_end(&mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A drape that takes a while.
fn long_drape(outfit: &str) -> Value {
    let pose = json!({"kind": "preset", "id": "squat"});
    json!({"outfit": outfit, "poses": vec![pose; 128], "output": {"method": "deepsd-concat"}})
}

#[test]
fn a_client_that_never_ends_its_head_is_cut_off() {
    let server = ServerOptions::default().with(&["--header-timeout", "0.4"]).start();
    for head in ["", "GET /healthz HTTP/1.1\r\nHost: toile\r\nX-Slow:"] {
        let mut stream = server.connect();
        stream.write_all(head.as_bytes()).unwrap();
        let begun = Instant::now();
        read_to_end(stream);
        assert!(begun.elapsed() < Duration::from_secs(5), "it was left open: {head:?}");
    }
    server.get("/healthz").with_status(200);
}

#[test]
fn a_client_that_never_ends_its_body_is_told_so() {
    let server = ServerOptions::default().with(&["--body-timeout", "0.4"]).start();
    let mut stream = server.connect();
    let head = "POST /v1/drapes HTTP/1.1\r\nHost: toile\r\nContent-Type: application/json\r\n\
                Content-Length: 1000\r\nConnection: close\r\n\r\n{\"outfit\":";
    stream.write_all(head.as_bytes()).unwrap();
    let answer = read_to_end(stream);
    assert!(answer.starts_with("HTTP/1.1 408"), "{answer}");
    assert!(answer.contains("\"code\":\"request-timeout\""), "{answer}");
}

#[test]
fn an_overloaded_server_refuses_at_once_and_says_when_to_come_back() {
    let server = ServerOptions::default().with(&["--workers", "1", "--queue", "1"]).start();
    let request = long_drape(&server.upload_skirt());
    let answers: Vec<_> = std::thread::scope(|scope| {
        let clients: Vec<_> = (0..8).map(|_| scope.spawn(|| server.drape(&request))).collect();
        clients.into_iter().map(|client| client.join().unwrap()).collect()
    });
    let refused: Vec<_> = answers.iter().filter(|answer| answer.status != 200).collect();
    assert!(!refused.is_empty() && refused.len() < answers.len(), "{} were refused", refused.len());
    for answer in refused {
        answer.assert_problem(503, "overloaded", None);
        assert!(answer.header("retry-after").parse::<u32>().unwrap() >= 1);
    }
    server.drape(&json!({"outfit": request["outfit"]})).with_status(200);
}

#[test]
fn a_server_told_to_stop_finishes_what_it_began_and_refuses_the_rest() {
    let server = Server::start();
    let request = long_drape(&server.upload_skirt());
    let mut idle = server.connect();
    idle.write_all(b"GET /healthz HTTP/1.1\r\nHost: toile\r\n\r\n").unwrap();
    assert!(idle.read(&mut [0; 1024]).unwrap() > 0);
    std::thread::scope(|scope| {
        let client = scope.spawn(|| server.drape(&request));
        std::thread::sleep(Duration::from_millis(150));
        server.terminate();
        let address = server.url.trim_start_matches("http://");
        let begun = Instant::now();
        while TcpStream::connect(address).is_ok() {
            assert!(begun.elapsed() < Duration::from_secs(5), "it still takes connections");
            std::thread::sleep(Duration::from_millis(5));
        }
        let answer = client.join().unwrap().with_status(200);
        assert!(answer.bytes.starts_with(b"glTF"));
    });
    assert_eq!(server.wait(), 0, "{}", server.log());
    assert!(server.log().contains("stopped"), "{}", server.log());
}

#[test]
fn a_request_that_arrives_while_the_server_stops_is_told_to_go_elsewhere() {
    let server = Server::start();
    let mut stream = server.connect();
    stream.write_all(b"GET /v1/poses HTTP/1.1\r\nHost: toile\r\n").unwrap();
    std::thread::sleep(Duration::from_millis(200));
    server.terminate();
    let address = server.url.trim_start_matches("http://");
    while TcpStream::connect(address).is_ok() {
        std::thread::sleep(Duration::from_millis(5));
    }
    stream.write_all(b"\r\n").unwrap();
    let answer = read_to_end(stream);
    assert!(answer.starts_with("HTTP/1.1 503"), "{answer}");
    assert!(
        answer.contains("\"code\":\"stopping\"") && answer.to_lowercase().contains("retry-after"),
        "{answer}"
    );
    assert_eq!(server.wait(), 0, "{}", server.log());
}
