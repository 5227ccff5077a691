//! A plan as a table, JSON, maps (GeoJSON, KML) and a plan file of a ground station.

pub mod chart;
mod civil;
pub mod geojson;
pub mod json;
pub mod kml;
pub mod qgc;
pub mod table;
mod watch;
