//! apex-server
