//! What a server answered.

use serde_json::Value;
use ureq::http::{HeaderMap, Response};

/// An HTTP answer, read whole.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Status code.
    pub status: u16,
    /// Headers.
    pub headers: HeaderMap,
    /// Body.
    pub bytes: Vec<u8>,
}

impl Answer {
    pub(crate) fn read(response: Response<ureq::Body>) -> Self {
        let (parts, mut body) = response.into_parts();
        let bytes = body.with_config().limit(1 << 30).read_to_vec().expect("the answer can be read");
        Self { status: parts.status.as_u16(), headers: parts.headers, bytes }
    }

    /// A header's value, empty when it is not there.
    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().expect("a readable header"))
    }

    /// The body as JSON.
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.bytes).unwrap_or_else(|error| panic!("{error}: {}", self.text()))
    }

    /// The body as text.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.bytes).chars().take(2000).collect()
    }

    /// The same answer, if it has this status.
    #[track_caller]
    pub fn with_status(self, status: u16) -> Self {
        assert_eq!(self.status, status, "{}", self.text());
        self
    }

    /// Milliseconds and description of a stage in `Server-Timing`.
    pub fn stage(&self, name: &str) -> Option<(f64, Option<String>)> {
        self.header("server-timing").split(", ").find_map(|stage| {
            let mut parts = stage.split(';');
            (parts.next() == Some(name)).then_some(())?;
            let milliseconds = parts.next()?.strip_prefix("dur=")?.parse().ok()?;
            let description = parts.next().and_then(|part| part.strip_prefix("desc="));
            Some((milliseconds, description.map(|word| word.trim_matches('"').to_owned())))
        })
    }

    /// Asserts that this is a problem (RFC 9457) with this status, code and JSON pointer.
    #[track_caller]
    pub fn assert_problem(&self, status: u16, code: &str, pointer: Option<&str>) {
        let text = self.text();
        assert_eq!(self.status, status, "{text}");
        assert_eq!(self.header("content-type"), "application/problem+json", "{text}");
        let problem = self.json();
        assert_eq!(problem["code"], code, "{text}");
        assert_eq!(problem["status"], status, "{text}");
        assert_eq!(problem["pointer"].as_str(), pointer, "{text}");
        for field in ["type", "title", "detail"] {
            assert!(problem[field].as_str().is_some_and(|text| text.len() > 5), "{field} is empty: {text}");
        }
    }
}
