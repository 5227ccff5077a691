//! airspace
