//! A running server on a free port.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;
use ureq::Agent;
use ureq::http::Request;

use crate::binary;
use crate::{Answer, Form, Mesh, skirt};

/// How long a server may take to start or to stop.
const PATIENCE: Duration = Duration::from_secs(60);

/// How a server is started.
#[derive(Debug, Default)]
pub struct ServerOptions {
    arguments: Vec<String>,
    data: Option<PathBuf>,
    gallery: bool,
}

impl ServerOptions {
    /// With further arguments.
    #[must_use]
    pub fn with(mut self, arguments: &[&str]) -> Self {
        self.arguments.extend(arguments.iter().map(|argument| (*argument).to_owned()));
        self
    }

    /// On a data directory that outlives the server.
    #[must_use]
    pub fn on(mut self, data: &Path) -> Self {
        self.data = Some(data.to_owned());
        self
    }

    /// With the demo outfits.
    #[must_use]
    pub fn with_gallery(mut self) -> Self {
        self.gallery = true;
        self
    }

    /// Starts the server and waits until it is ready.
    pub fn start(self) -> Server {
        let server = self.start_unready();
        let begun = Instant::now();
        while server.get("/readyz").status != 200 {
            assert!(begun.elapsed() < PATIENCE * 3, "the server does not get ready:\n{}", server.log());
            std::thread::sleep(Duration::from_millis(20));
        }
        server
    }

    /// Starts the server and waits until it listens.
    pub fn start_unready(self) -> Server {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let log = folder.path().join("log");
        let data = self.data.clone().unwrap_or_else(|| folder.path().join("data"));
        let mut command = Command::new(binary::path());
        command.args(["serve", "--listen", "127.0.0.1:0", "--data"]).arg(&data);
        if !self.arguments.iter().any(|argument| argument == "--workers") {
            command.args(["--workers", "2"]);
        }
        if !self.gallery {
            command.arg("--no-gallery");
        }
        command.args(&self.arguments).env("RUST_LOG", "info").current_dir(binary::repository());
        command.stdout(Stdio::piped()).stderr(std::fs::File::create(&log).expect("a log file"));
        let mut child = command.spawn().expect("toile starts");
        let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
        let first = lines.next().and_then(Result::ok).unwrap_or_default();
        let log_text = || std::fs::read_to_string(&log).unwrap_or_default();
        let url = first.strip_prefix("listening on ").unwrap_or_else(|| panic!("no address: {}", log_text()));
        Server { url: url.to_owned(), child: Mutex::new(child), data, agent: agent(), folder }
    }
}

/// A running server. It is killed when dropped.
#[derive(Debug)]
pub struct Server {
    /// `http://127.0.0.1:port`.
    pub url: String,
    /// Its data directory.
    pub data: PathBuf,
    child: Mutex<Child>,
    agent: Agent,
    folder: TempDir,
}

impl Server {
    /// A server of one's own, without demo outfits.
    pub fn start() -> Self {
        ServerOptions::default().start()
    }

    /// A server that tests share; use it where nothing else may matter than what the test itself did.
    pub fn shared() -> Arc<Self> {
        static SHARED: Mutex<Weak<Server>> = Mutex::new(Weak::new());
        let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
        shared.upgrade().unwrap_or_else(|| {
            let server = Arc::new(Self::start());
            *shared = Arc::downgrade(&server);
            server
        })
    }

    /// GET.
    pub fn get(&self, path: &str) -> Answer {
        self.request("GET", path, &[], &[])
    }

    /// GET with headers.
    pub fn get_with(&self, path: &str, headers: &[(&str, &str)]) -> Answer {
        self.request("GET", path, headers, &[])
    }

    /// POST of JSON.
    pub fn post(&self, path: &str, body: &Value) -> Answer {
        self.post_with(path, body, &[])
    }

    /// POST of JSON with further headers.
    pub fn post_with(&self, path: &str, body: &Value, headers: &[(&str, &str)]) -> Answer {
        let headers = [headers, &[("content-type", "application/json")]].concat();
        self.request("POST", path, &headers, body.to_string().as_bytes())
    }

    /// Any request.
    pub fn request(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        let mut request = Request::builder().method(method).uri(format!("{}{path}", self.url));
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let answer = match body {
            [] => self.agent.run(request.body(()).expect("a request")),
            _ => self.agent.run(request.body(body).expect("a request")),
        };
        Answer::read(answer.unwrap_or_else(|error| panic!("{method} {path}: {error}\n{}", self.log())))
    }

    /// POST of a form to `/v1/outfits`.
    pub fn upload(&self, form: &Form) -> Answer {
        let (media_type, body) = form.encode();
        self.request("POST", "/v1/outfits", &[("content-type", &media_type)], &body)
    }

    /// Uploads a mesh as a GLB and returns the outfit's id.
    #[track_caller]
    pub fn upload_mesh(&self, mesh: &Mesh) -> String {
        let answer = self.upload(&Form::file("skirt.glb", &mesh.glb()));
        assert!([200, 201].contains(&answer.status), "{}", answer.text());
        answer.json()["id"].as_str().expect("an id").to_owned()
    }

    /// Uploads the sample outfit and returns its id.
    #[track_caller]
    pub fn upload_skirt(&self) -> String {
        self.upload_mesh(&skirt(1.0))
    }

    /// POST to `/v1/drapes`, for a GLB.
    pub fn drape(&self, request: &Value) -> Answer {
        self.post_with("/v1/drapes", request, &[("accept", "model/gltf-binary")])
    }

    /// POST to `/v1/drapes`, for JSON.
    pub fn drape_json(&self, request: &Value) -> Answer {
        self.post_with("/v1/drapes", request, &[("accept", "application/json")])
    }

    /// A bare connection.
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.url.trim_start_matches("http://")).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        stream
    }

    /// Whatever the server has logged.
    pub fn log(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("log")).unwrap_or_default()
    }

    /// Sends SIGTERM.
    pub fn terminate(&self) {
        let id = self.lock().id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id]).status().expect("kill runs").success());
    }

    /// Waits for the server to end and returns its exit code.
    pub fn wait(&self) -> i32 {
        let begun = Instant::now();
        loop {
            if let Some(status) = self.lock().try_wait().expect("a child") {
                return status.code().unwrap_or(-1);
            }
            assert!(begun.elapsed() < PATIENCE, "the server does not stop:\n{}", self.log());
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Sends SIGTERM and waits for a clean end.
    pub fn stop(&self) {
        self.terminate();
        assert_eq!(self.wait(), 0, "{}", self.log());
    }

    /// Names of the files in a folder of the data directory, sorted.
    pub fn files(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.data.join(folder)).expect("a folder");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Child> {
        self.child.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let mut child = self.lock();
        // It may have ended already.
        let _ = child.kill();
        let _ = child.wait();
    }
}

fn agent() -> Agent {
    Agent::config_builder()
        .http_status_as_error(false)
        .timeout_global(Some(Duration::from_secs(180)))
        .build()
        .new_agent()
}
