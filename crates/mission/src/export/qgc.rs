//! A plan as a `.plan` file of QGroundControl (version 1): mission items for an autopilot, and a fence.
//!
//! An autopilot knows neither conditions nor procedures: the file contains the plan as made, without monitoring, replanning or repeated
//! lines.

use super::chart::{Chart, ChartPoint, ChartVisit, digits};
use crate::vehicle::Airframe;
use apex_model::problem::{AirspaceZone, ZoneKind};
use serde_json::{Value, json};

/// Shortest wait that gets a separate item, s.
const WAIT_S_MIN: f64 = 1.0;
/// Commands of MAVLink (`MAV_CMD`).
const WAYPOINT: u16 = 16;
const LOITER_TIME: u16 = 19;
const RETURN_TO_LAUNCH: u16 = 20;
const LAND: u16 = 21;
const TAKEOFF: u16 = 22;
const DO_JUMP: u16 = 177;
/// Frames of MAVLink (`MAV_FRAME`): above mean sea level, above home, and for items without a place.
const GLOBAL: u8 = 0;
const GLOBAL_RELATIVE: u8 = 3;
const MISSION: u8 = 2;
/// `MAV_AUTOPILOT_GENERIC`: the plan is for whichever autopilot is connected.
const FIRMWARE: u8 = 0;
/// Pitch of a fixed wing's take-off in degrees: QGroundControl's default.
const TAKEOFF_PITCH_DEG: f64 = 15.0;
/// Speed if none is known: QGroundControl's default; autopilots use their own parameters.
const SPEED_MPS_DEFAULT: f64 = 15.0;

/// Returns the chart as a plan file. Without known altitudes, everything is flown at `height_m` above the start.
///
/// # Errors
/// A message if the plan visits nothing, or its altitudes are unknown and no height is given.
pub fn write(chart: &Chart, height_m: Option<f64>) -> Result<String, String> {
    let path = chart.path();
    let (Some(first), Some(visit)) = (path.iter().find(|place| Some(**place) != chart.start), chart.visits.first())
    else {
        return Err("the plan visits nothing".into());
    };
    let home = chart.start.or(visit.way.first().copied()).unwrap_or(*first);
    let known = path.iter().filter(|place| Some(**place) != chart.start).all(|place| place.altitude_m.is_some());
    let relative_m = match (height_m, known) {
        (Some(height_m), _) => Some(height_m),
        (None, true) => None,
        (None, false) => return Err("its altitudes are unknown".into()),
    };
    let mut items = Items { items: Vec::new(), relative_m };
    let rotorcraft = chart.airframe == Some(Airframe::Rotorcraft);
    let up = ChartPoint { position: home.position, altitude_m: first.altitude_m };
    items.at(TAKEOFF, if rotorcraft { 0.0 } else { TAKEOFF_PITCH_DEG }, up);
    fly(&mut items, chart);
    // `MAV_TYPE`.
    let class = match chart.airframe {
        Some(Airframe::FixedWing) => 1,
        Some(Airframe::Rotorcraft) => 4,
        None => 0,
    };
    let speed_mps = chart.speed_mps.unwrap_or(SPEED_MPS_DEFAULT);
    let plan = json!({
        "fileType": "Plan",
        "groundStation": "QGroundControl",
        "version": 1,
        "geoFence": {"version": 2, "circles": [], "polygons": fence(chart, relative_m.is_some())},
        "rallyPoints": {"version": 2, "points": []},
        "mission": {
            "version": 2,
            "firmwareType": FIRMWARE,
            "vehicleType": class,
            "cruiseSpeed": speed_mps,
            "hoverSpeed": speed_mps,
            "globalPlanAltitudeMode": items.mode(),
            "plannedHomePosition": [digits(home.position.latitude_deg), digits(home.position.longitude_deg), home.altitude_m.unwrap_or(0.0)],
            "items": items.items,
        },
    });
    // A value of JSON is always written.
    Ok(serde_json::to_string_pretty(&plan).unwrap_or_default() + "\n")
}

/// Items in order.
struct Items {
    items: Vec<Value>,
    relative_m: Option<f64>,
}

impl Items {
    /// Returns the altitude reference of QGroundControl: 1 above home, 2 above mean sea level.
    fn mode(&self) -> u8 {
        if self.relative_m.is_some() { 1 } else { 2 }
    }

    /// Returns the number that the next item gets.
    fn next(&self) -> usize {
        self.items.len() + 1
    }

    /// Adds an item at a place; its first parameter depends on the command: a pitch, or seconds.
    fn at(&mut self, command: u16, parameter: f64, place: ChartPoint) {
        let altitude_m = self.relative_m.or(place.altitude_m).unwrap_or(0.0);
        let altitude_m = if command == LAND && self.relative_m.is_some() { 0.0 } else { altitude_m };
        let (latitude_deg, longitude_deg) = (digits(place.position.latitude_deg), digits(place.position.longitude_deg));
        // The fourth parameter is the heading, which `null` leaves to the autopilot; of loitering it states where the circle is left.
        let fourth = if command == LOITER_TIME { json!(0) } else { Value::Null };
        let item = json!({
            "type": "SimpleItem",
            "autoContinue": true,
            "command": command,
            "doJumpId": self.next(),
            "frame": if self.relative_m.is_some() { GLOBAL_RELATIVE } else { GLOBAL },
            "params": [parameter, 0, 0, fourth, latitude_deg, longitude_deg, altitude_m],
            "Altitude": altitude_m,
            "AltitudeMode": self.mode(),
            "AMSLAltAboveTerrain": null,
        });
        self.items.push(item);
    }

    /// Adds an item without a place.
    fn anywhere(&mut self, command: u16, first: usize, second: usize) {
        let item = json!({
            "type": "SimpleItem",
            "autoContinue": true,
            "command": command,
            "doJumpId": self.next(),
            "frame": MISSION,
            "params": [first, second, 0, 0, 0, 0, 0],
        });
        self.items.push(item);
    }

    fn visit(&mut self, visit: &ChartVisit) {
        if let Some(circle) = &visit.circle {
            circle.bends.iter().for_each(|bend| self.at(WAYPOINT, 0.0, *bend));
            return self.at(LOITER_TIME, (visit.end_s - visit.begin_s).round(), circle.centre);
        }
        let entry = visit.way.len().saturating_sub(1);
        for bend in visit.way.iter().take(entry).skip(1) {
            self.at(WAYPOINT, 0.0, *bend);
        }
        let Some(entry) = visit.way.last() else { return };
        let wait_s = if visit.lines.is_empty() { visit.end_s - visit.arrive_s } else { visit.begin_s - visit.arrive_s };
        if wait_s >= WAIT_S_MIN {
            self.at(LOITER_TIME, wait_s.round(), *entry);
        } else {
            self.at(WAYPOINT, 0.0, *entry);
        }
        let mut before = *entry;
        for place in visit.lines.iter().skip(1) {
            if *place != before {
                self.at(WAYPOINT, 0.0, *place);
            }
            before = *place;
        }
    }
}

/// Adds the visits, repeated rounds as a jump back, then the flight to the base with the landing, or the return to the start.
fn fly(items: &mut Items, chart: &Chart) {
    let count = chart.visits.len();
    let (round, rounds) =
        chart.round.filter(|round| *round > 0 && count >= 2 * round).map_or((count, 1), |round| (round, count / round));
    let first = items.next();
    chart.visits.iter().take(round).for_each(|visit| items.visit(visit));
    if rounds > 1 {
        items.anywhere(DO_JUMP, first, rounds - 1);
    }
    chart.visits.iter().skip(round * rounds).for_each(|visit| items.visit(visit));
    match chart.base {
        Some(base) => {
            let bends = chart.return_way.len().saturating_sub(2);
            chart.return_way.iter().skip(1).take(bends).for_each(|bend| items.at(WAYPOINT, 0.0, *bend));
            items.at(LAND, 0.0, base);
        }
        None => items.anywhere(RETURN_TO_LAUNCH, 0, 0),
    }
}

/// Returns zones as fence polygons. A fence has neither heights nor times, so zones above, below, before or after the flight are left
/// out: they would forbid parts of the plan. Heights above the start cannot be compared with those of zones; all zones are then included.
fn fence(chart: &Chart, relative: bool) -> Vec<Value> {
    let heights: Vec<f64> =
        chart.path().iter().filter(|place| Some(**place) != chart.start).filter_map(|place| place.altitude_m).collect();
    let lowest_m = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let highest_m = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let concerns = |zone: &&AirspaceZone| {
        let high = relative || (zone.altitude_m_min <= highest_m && lowest_m <= zone.altitude_m_max);
        high && zone.active.overlaps(0.0, chart.end_s)
    };
    let polygon = |zone: &AirspaceZone| {
        let corners: Vec<Value> = zone
            .corners
            .iter()
            .map(|corner| json!([digits(corner.latitude_deg), digits(corner.longitude_deg)]))
            .collect();
        json!({"version": 1, "inclusion": zone.kind == ZoneKind::Permitted, "polygon": corners})
    };
    chart.zones.iter().filter(concerns).map(polygon).collect()
}
