//! Features of a GeoJSON FeatureCollection (RFC 7946).

use super::placed::PlacedFeature;
use crate::error::{MissionError, MissionResult};
use crate::sources::DataFile;
use apex_runtime::parse_unique_json;
use geojson::{FeatureCollection, GeoJson};

/// Reads a FeatureCollection.
///
/// # Errors
/// Text that is not GeoJSON, or another GeoJSON object.
pub(super) fn read(file: &DataFile) -> MissionResult<Vec<PlacedFeature>> {
    let place = &file.place;
    let text = file.text()?;
    let unfit = |error: String| {
        MissionError::data(format!("{place} is not GeoJSON")).because(error).help(
            "export it as a GeoJSON FeatureCollection with WGS84 longitude and latitude, or as .kml, .kmz or .csv",
        )
    };
    // A repeated key would silently lose one of its values.
    parse_unique_json(&text).map_err(|error| unfit(error.to_string()))?;
    let parsed: GeoJson = text.parse().map_err(|error: geojson::Error| unfit(error.to_string()))?;
    let GeoJson::FeatureCollection(FeatureCollection { features, .. }) = parsed else {
        return Err(MissionError::data(format!("{place} is not a FeatureCollection"))
            .help("put the feature into {\"type\": \"FeatureCollection\", \"features\": [..]}"));
    };
    Ok(features.into_iter().zip(1..).map(|(feature, number)| (format!("{place}: feature {number}"), feature)).collect())
}
