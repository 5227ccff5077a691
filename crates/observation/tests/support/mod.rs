//! Targets, sensors and checks that several test programs share.

#![allow(dead_code, reason = "each test program uses a part")]

use apex_geo::geodesy::Position;
use apex_observation::footprint::offset_position;
use apex_observation::result::LookResult;
use apex_observation::sensor::ScannerMode;
use apex_observation::strip::ScannerSetting;
use apex_observation::target::{ObservedTarget, Polygon, TargetArea, WantedLook};

/// Middle of the targets: near the Zaca fire.
pub(crate) const CENTRE: Position = Position::new(34.716, -119.783);
/// 2007-09-08T00:00:00Z, 17:00 PDT.
pub(crate) const ZERO_UNIX_S: f64 = 1_189_209_600.0;

/// Fails unless two numbers are within a tolerance.
pub(crate) fn near(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual - expected).abs() <= tolerance, "{actual}, expected {expected} +- {tolerance}");
}

/// Returns the position east and north of the middle.
pub(crate) fn offset(east_m: f64, north_m: f64) -> Position {
    offset_position(CENTRE, north_m, east_m)
}

/// Returns a rectangle around the middle, width by depth in metres, at sea level.
pub(crate) fn rectangle(name: &str, (width_m, depth_m): (f64, f64), looks: Vec<WantedLook>) -> ObservedTarget {
    let (x, y) = (0.5 * width_m, 0.5 * depth_m);
    let outer = [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(east, north)| offset(east, north)).to_vec();
    ObservedTarget {
        name: name.to_string(),
        area: TargetArea::Polygons(vec![Polygon { outer, holes: Vec::new() }]),
        elevation_m: 0.0,
        is_water: false,
        looks,
        after: Vec::new(),
    }
}

/// Returns a scanner with 1.25 mrad and 86 degrees.
pub(crate) fn wide_scanner(scan_rates_hz: &[f64]) -> ScannerSetting {
    let mode = ScannerMode {
        name: "wide".to_string(),
        pixel_mrad: 1.25,
        field_of_view_deg: 86.0,
        scan_rates_hz: scan_rates_hz.to_vec(),
        line_overlap: 0.0,
    };
    ScannerSetting { mode, roll: None, rates: None, scan_rate_hz: None, is_ready: true }
}

/// Fails unless the losses of a look and its points add up to its value.
pub(crate) fn losses_add_up(look: &LookResult) {
    let lost: f64 = look.losses.iter().map(|loss| loss.points).sum();
    near(lost + look.points, look.value, 1e-6 * look.value.max(1.0));
}
