//! apex-geo
