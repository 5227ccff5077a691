//! Areas that flown paths avoid in addition to the mission's zones, as the situation publishes them.

use crate::storm;
use apex_geo::location::Location;
use apex_model::problem::{AirspaceZone, Position, TimeWindow, ZoneKind};
use apex_model::value::Value;

/// Returns the areas in the values published by the situation: weak links and storms; other items are ignored.
pub(super) fn avoided_areas(value: &Value) -> (Vec<AirspaceZone>, Vec<AirspaceZone>) {
    let items = value.as_list().unwrap_or_default();
    let storms: Vec<AirspaceZone> = items.iter().filter_map(storm::area_of).collect();
    let weak = items.iter().filter(|item| storm::area_of(item).is_none());
    (weak.filter_map(weak_area).collect(), storms)
}

fn weak_area(item: &Value) -> Option<AirspaceZone> {
    let [Value::Text(name), top, corners @ ..] = item.as_list()? else { return None };
    let (altitude_m_max, _) = top.as_number()?;
    let corners: Vec<Position> = corners.iter().filter_map(|at| Location::of(at).ok()).map(|at| at.position).collect();
    (corners.len() >= 3).then(|| AirspaceZone {
        name: name.to_string(),
        kind: ZoneKind::Restricted,
        corners,
        altitude_m_min: 0.0,
        altitude_m_max,
        active: TimeWindow::ALWAYS,
    })
}
