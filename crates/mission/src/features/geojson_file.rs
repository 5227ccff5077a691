//! Features of a GeoJSON FeatureCollection (RFC 7946).

use super::placed::PlacedFeature;
use crate::error::{MissionError, MissionResult};
use crate::sources::DataFile;
use geojson::{FeatureCollection, GeoJson};

/// Reads a FeatureCollection.
///
/// # Errors
/// Text that is not GeoJSON, or another GeoJSON object.
pub(super) fn read(file: &DataFile) -> MissionResult<Vec<PlacedFeature>> {
    let place = &file.place;
    let parsed: GeoJson = file.text()?.parse().map_err(|error| {
        MissionError::data(format!("{place} is not GeoJSON")).because(error).help(
            "export it as a GeoJSON FeatureCollection with WGS84 longitude and latitude, or as .kml, .kmz or .csv",
        )
    })?;
    let GeoJson::FeatureCollection(FeatureCollection { features, .. }) = parsed else {
        return Err(MissionError::data(format!("{place} is not a FeatureCollection"))
            .help("put the feature into {\"type\": \"FeatureCollection\", \"features\": [..]}"));
    };
    Ok(features.into_iter().zip(1..).map(|(feature, number)| (format!("{place}: feature {number}"), feature)).collect())
}
