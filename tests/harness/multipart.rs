//! A multipart form.

use serde_json::Value;

const BOUNDARY: &str = "toile-test-boundary-1f0c";

/// The parts of a form, in order.
#[derive(Clone, Debug, Default)]
pub struct Form {
    parts: Vec<(String, Vec<u8>)>,
}

impl Form {
    /// A form with one file.
    pub fn file(name: &str, bytes: &[u8]) -> Self {
        Self::default().part(&format!("name=\"file\"; filename=\"{name}\""), bytes)
    }

    /// The form with metadata as well.
    #[must_use]
    pub fn metadata(self, metadata: &Value) -> Self {
        self.part("name=\"metadata\"", metadata.to_string().as_bytes())
    }

    /// The form with any part.
    #[must_use]
    pub fn part(mut self, disposition: &str, bytes: &[u8]) -> Self {
        self.parts.push((disposition.to_owned(), bytes.to_vec()));
        self
    }

    /// Media type and body.
    pub fn encode(&self) -> (String, Vec<u8>) {
        let mut body = Vec::new();
        for (disposition, bytes) in &self.parts {
            body.extend(
                format!("--{BOUNDARY}\r\nContent-Disposition: form-data; {disposition}\r\n\r\n").bytes(),
            );
            body.extend(bytes);
            body.extend(b"\r\n");
        }
        body.extend(format!("--{BOUNDARY}--\r\n").bytes());
        (format!("multipart/form-data; boundary={BOUNDARY}"), body)
    }
}
