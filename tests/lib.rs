//! End-to-end tests that drive the built `toile` binary over HTTP.
