//! A plan printed: for people, for the executive, for maps and for ground stations.

pub mod chart;
mod civil;
pub mod geojson;
pub mod json;
pub mod kml;
pub mod proof;
pub mod qgc;
pub mod table;
pub mod turns;
mod watch;
