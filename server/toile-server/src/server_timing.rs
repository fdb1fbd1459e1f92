//! The `Server-Timing` header: stage names and milliseconds, in the order in which they ran.

use std::fmt::Write;
use std::time::Instant;

use axum::http::{HeaderName, HeaderValue};
use axum::response::{IntoResponseParts, ResponseParts};
use serde::{Serialize, Serializer};

/// Name of the header.
pub const HEADER: HeaderName = HeaderName::from_static("server-timing");

/// Stages of one request.
#[derive(Clone, Debug, Default)]
pub struct ServerTiming {
    stages: Vec<(&'static str, f64, Option<&'static str>)>,
}

impl ServerTiming {
    /// Adds a stage of `milliseconds`.
    pub fn add(&mut self, stage: &'static str, milliseconds: f64) {
        self.stages.push((stage, milliseconds, None));
    }

    /// Adds a stage that began at `started` and ends now, with a word on how it went.
    pub fn add_since(&mut self, stage: &'static str, started: Instant, description: Option<&'static str>) {
        self.stages.push((stage, milliseconds_since(started), description));
    }

    /// Names and milliseconds.
    pub fn stages(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.stages.iter().map(|&(name, milliseconds, _)| (name, milliseconds))
    }

    fn value(&self) -> String {
        let mut value = String::new();
        for (name, milliseconds, description) in &self.stages {
            let comma = if value.is_empty() { "" } else { ", " };
            // Writing to a String cannot fail.
            let _ = write!(value, "{comma}{name};dur={milliseconds:.3}");
            if let Some(description) = description {
                let _ = write!(value, ";desc=\"{description}\"");
            }
        }
        value
    }
}

/// Milliseconds since `started`.
pub fn milliseconds_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

/// As JSON: names and milliseconds.
impl Serialize for ServerTiming {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer
            .collect_map(self.stages().map(|(name, milliseconds)| (name, (milliseconds * 1e3).round() / 1e3)))
    }
}

impl IntoResponseParts for ServerTiming {
    type Error = std::convert::Infallible;

    fn into_response_parts(self, mut parts: ResponseParts) -> Result<ResponseParts, Self::Error> {
        if let Ok(value) = HeaderValue::from_str(&self.value()) {
            parts.headers_mut().insert(HEADER, value);
        }
        Ok(parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_is_written_as_the_standard_says() {
        let mut timing = ServerTiming::default();
        timing.add("parse", 0.25);
        timing.stages.push(("static", 1.0, Some("memory")));
        assert_eq!(timing.value(), "parse;dur=0.250, static;dur=1.000;desc=\"memory\"");
    }
}
