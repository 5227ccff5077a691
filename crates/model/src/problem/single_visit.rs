//! The single-visit problem: observe a subset of targets once each, in the best order and way (paper, section II.B).

use super::{AirspaceZone, LandingPlace, LeftOut, Position, TimeWindow, TravelTimes, WindField};
use crate::value::Value;
use serde::{Deserialize, Serialize};

/// Choose targets, order and manoeuvres for the highest mission score.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SingleVisitProblem {
    /// Targets that may be observed; names are unique.
    pub targets: Vec<SingleVisitTarget>,
    /// Vehicle.
    pub vehicle: SingleVisitVehicle,
    /// Position of the vehicle at the beginning of the plan.
    pub start: Position,
    /// Altitude of the start above mean sea level.
    pub start_altitude_m: f64,
    /// Beginning of the plan.
    pub start_s: f64,
    /// Required end of the flight; `None`: the flight may end anywhere.
    pub base: Option<Position>,
    /// Latest time at which the vehicle must have landed; `None` if only endurance and fuel limit it.
    pub end_s: Option<f64>,
    /// Name of the limit `end_s`; `None`: the end of the mission.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_limit: Option<NamedLimit>,
    /// Civil time (seconds since 1970-01-01T00:00Z) of the problem's time zero, for the position of the sun.
    pub zero_unix_s: f64,
    /// `(earlier, later)`: if `later` is observed, then after `earlier`.
    pub precedence: Vec<(String, String)>,
    /// Airspace to keep out of and to stay in.
    pub zones: Vec<AirspaceZone>,
    /// Distance kept from zones' edges.
    pub zone_margin_m: f64,
    /// Emergency landing places.
    pub landing_places: Vec<LandingPlace>,
    /// Greatest distance from the nearest landing place; `None`: unlimited.
    pub landing_distance_m_max: Option<f64>,
    /// The wind as forecast.
    pub wind: WindField,
    /// Members of the mission's crew: their hours cost.
    pub crew: Vec<CrewMember>,
    /// Cost of a failure.
    pub failure: FailureTerm,
    /// Given travel times: from the start, between targets (from the end of an observation to the beginning of the next), to the base.
    /// Airspace, wind and altitudes are then ignored, and positions are for display. `None`: the vehicle flies, and times follow from
    /// speed, wind and airspace.
    pub travel: Option<TravelTimes>,
}

/// Name of a limit on the time of a flight, as reasons of plans state it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedLimit {
    /// Noun for what the limit leaves or allows, for example `the battery`.
    pub name: String,
    /// Cause of the limit, for example `it has 40 min above its reserve of 11 min and its landing`.
    pub cause: String,
}

impl SingleVisitProblem {
    /// Returns the points that missing every target costs: the benefits of a plan without visits, with the opposite sign.
    pub fn miss_costs(&self) -> f64 {
        self.targets.iter().map(SingleVisitTarget::miss_cost).fold(0.0, std::ops::Add::add)
    }
}

/// A target to be observed once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SingleVisitTarget {
    /// Its name.
    pub name: String,
    /// Its middle.
    pub position: Position,
    /// Worth of a perfect observation.
    pub value: f64,
    /// Ways to observe it, best guess first; at least one.
    pub manoeuvres: Vec<Manoeuvre>,
    /// Windows, both ends included, in one of which the observation must begin; empty for any time. Other windows of time are half-open
    /// ([`TimeWindow`]).
    pub windows: Vec<TimeWindow>,
    /// Required light from the beginning to the end of the observation.
    pub light: Light,
    /// `(time_s, factor 0..1)` by rising time: the timing factor `o(t)` of an observation that begins at `time_s`; linear between points,
    /// constant outside. Empty means 1.
    pub timing: Vec<(f64, f64)>,
    /// Cost of missing it; `None` for a target that may be left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub must: Option<MustVisit>,
}

/// Cost of a target that must be observed and is missed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MustVisit {
    /// It is missed unless the product of quality and timing is above this, 0 to 1.
    pub factor_min: f64,
    /// Points that a miss costs.
    pub cost: f64,
}

impl SingleVisitTarget {
    /// Returns what a visit adds to the benefits of a plan, given the product of its quality and timing: its worth, and the cost of a miss
    /// that it avoids.
    pub fn gain(&self, product: f64) -> f64 {
        self.value * product + if self.is_missed_by(product) { 0.0 } else { self.miss_cost() }
    }

    /// Returns the points that missing the target costs.
    pub fn miss_cost(&self) -> f64 {
        self.must.map_or(0.0, |must| must.cost)
    }

    /// Returns true if a target that must be observed counts as missed by a visit of this product of quality and timing.
    pub fn is_missed_by(&self, product: f64) -> bool {
        self.must.is_some_and(|must| product <= must.factor_min)
    }

    /// Returns the timing factor of an observation that begins at `begin_s`.
    pub fn timing_at(&self, begin_s: f64) -> f64 {
        let after = self.timing.iter().position(|(time_s, _)| *time_s > begin_s);
        let Some(after) = after else { return self.timing.last().map_or(1.0, |(_, factor)| *factor) };
        let next = self.timing.get(after);
        let before = after.checked_sub(1).and_then(|index| self.timing.get(index));
        match (before, next) {
            (Some((t0, f0)), Some((t1, f1))) if t1 > t0 => f0 + (f1 - f0) * (begin_s - t0) / (t1 - t0),
            (_, Some((_, factor))) => *factor,
            _ => 1.0,
        }
    }
}

/// Light that an observation needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Light {
    /// Any.
    #[default]
    Any,
    /// The sun is up.
    Day,
    /// The sun is at least 6 degrees below the horizon.
    Night,
}

/// One way to observe a target: lines flown at an altitude, with their predicted results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manoeuvre {
    /// Its name, for example `sweep-7000m`.
    pub name: String,
    /// Altitude of the lines above mean sea level.
    pub altitude_m: f64,
    /// Straight lines `(from, to)` in order; the last `to` is the exit, and the first `from` the entry unless `entry` says
    /// otherwise. Empty means overhead at the target's position.
    pub lines: Vec<(Position, Position)>,
    /// Beginning of the manoeuvre: on the extension of the first line, at the distance that levelling the wings needs. `None`: the
    /// beginning of the first line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entry: Option<Position>,
    /// Time from entry to exit, turns included.
    pub duration_s: f64,
    /// Distance over ground from entry to exit.
    pub length_m: f64,
    /// Predicted coverage, resolution and clarity.
    pub quality: QualityFactors,
    /// The pictures that are taken; `None`: a line scanner records the lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pictures: Option<PictureWork>,
}

/// Pictures of a manoeuvre: by distance along its lines, or a number of them from the point where its only line begins and ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureWork {
    /// Name of the camera.
    pub camera: String,
    /// Name of the place that the camera points at; `None`: straight down.
    pub at: Option<String>,
    /// Number of pictures.
    pub count: u32,
    /// Distance over ground between pictures; `None` if they are taken from a hover.
    pub every_m: Option<f64>,
    /// True airspeed along the lines, m/s; with a `form` that of the manoeuvre, of a rotorcraft its ground speed.
    pub true_airspeed_mps: f64,
    /// The manoeuvre whose path is flown, in PDL, for example `(orbit :radius 60m :height 40m)`; `None` for the lines. The lines follow
    /// its path for the checks of airspace.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub form: Option<Value>,
}

/// Factors 0..1 that discount a target's value, each with its cause.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QualityFactors {
    /// Share of the wanted ground that is seen.
    pub coverage: QualityFactor,
    /// Obtained resolution in comparison with the wanted one.
    pub resolution: QualityFactor,
    /// Clarity: wings level and smooth air.
    pub clarity: QualityFactor,
}

impl QualityFactors {
    /// Returns the product of the three.
    pub fn product(&self) -> f64 {
        self.coverage.factor * self.resolution.factor * self.clarity.factor
    }
}

/// A factor with its cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QualityFactor {
    /// From 0 (worthless) to 1 (as wanted).
    pub factor: f64,
    /// Cause of a factor other than 1, for example "roll 12 deg for 8 s on leg 3"; empty if it is 1.
    pub cause: String,
}

impl Default for QualityFactor {
    fn default() -> QualityFactor {
        QualityFactor { factor: 1.0, cause: String::new() }
    }
}

/// Vehicle, as far as a planner needs it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SingleVisitVehicle {
    /// Cruise speed through the air.
    pub true_airspeed_mps: f64,
    /// Altitude of transit above mean sea level.
    pub cruise_altitude_m: f64,
    /// Rate of climb; 0 or less: altitude changes take no time.
    pub climb_rate_mps: f64,
    /// Rate of descent, positive; 0 or less: altitude changes take no time.
    pub descent_rate_mps: f64,
    /// Usable fuel when the plan begins.
    pub fuel_kg: f64,
    /// Fuel that must be left at the end.
    pub fuel_reserve_kg: f64,
    /// Fuel burnt per second of flight; 0 for no limit by fuel.
    pub fuel_flow_kg_per_s: f64,
    /// Flight time from the plan's beginning to empty.
    pub endurance_s: f64,
    /// Flight time that must be left at the end.
    pub endurance_reserve_s: f64,
    /// Name of the limit that endurance and its reserve set; `None`: endurance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub endurance_limit: Option<NamedLimit>,
    /// Least radius of a turn through the air, from speed and greatest roll angle; 0: turns take neither time nor space. With a radius,
    /// targets are left and reached in the directions of their lines.
    #[serde(default)]
    pub turn_radius_m: f64,
}

/// Member of the crew whose hours cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrewMember {
    /// Role, for example `sensor operator`.
    pub role: String,
    /// Pay per hour, in units of target value.
    pub wage_per_hour: f64,
    /// Hours worked independently of the flight (briefing, standby).
    pub fixed_hours: f64,
    /// Share of the flight time that they work.
    pub flight_share: f64,
}

/// The failure term `P (R C_v + M C_m)` of the mission score.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FailureTerm {
    /// P: probability of failure in an hour of flight; over a mission `1 - exp(-P hours)`.
    pub probability_per_hour: f64,
    /// R: share of the vehicle to be replaced.
    pub vehicle_share: f64,
    /// C_v: cost of the vehicle.
    pub vehicle_cost: f64,
    /// M: share of the mission lost.
    pub mission_share: f64,
    /// C_m: cost of the mission.
    pub mission_cost: f64,
}

impl FailureTerm {
    /// Returns the failure costs in points, if they are given in money and one point represents `money_per_point`.
    pub fn in_points(self, money_per_point: f64) -> FailureTerm {
        FailureTerm {
            vehicle_cost: self.vehicle_cost / money_per_point,
            mission_cost: self.mission_cost / money_per_point,
            ..self
        }
    }
}

/// One observation, with the path to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedVisit {
    /// The target's name.
    pub target: String,
    /// Index into the target's manoeuvres.
    pub manoeuvre: usize,
    /// Way points from the preceding exit to this entry, both included; detours around airspace are in between.
    pub route: Vec<Position>,
    /// Flown path between both ends of the route, turns included: its points deviate from the flight by at most a thousandth of the
    /// vehicle's turn radius. Empty if turns are not limited: the route itself is then flown.
    #[serde(default)] // never skipped: the flight record stores plans without the names of fields
    pub path: Vec<Position>,
    /// Departure from the preceding exit, or from the start; after the end of the preceding visit if the vehicle holds first.
    pub depart_s: f64,
    /// Arrival at the entry.
    pub arrive_s: f64,
    /// Begin of the observation; later than the arrival if the vehicle has to wait.
    pub begin_s: f64,
    /// End of the observation.
    pub end_s: f64,
    /// The timing factor `o(t)`.
    pub timing: f64,
    /// Value times all factors.
    pub worth: f64,
    /// Predicted coverage, resolution and clarity of the manoeuvre; `None` if the planner did not copy them.
    #[serde(default)]
    pub quality: Option<QualityFactors>,
}

/// A subset of targets in order, with times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SingleVisitPlan {
    /// Name of the planner.
    pub solver: String,
    /// The observations in order.
    pub visits: Vec<PlannedVisit>,
    /// Way points from the last exit to the base, both included; empty where there is no base.
    pub return_route: Vec<Position>,
    /// Flown path to the base, as [`PlannedVisit::path`].
    #[serde(default)]
    pub return_path: Vec<Position>,
    /// Departure from the last exit to the base; later than the end of the last visit if the vehicle holds first.
    pub return_depart_s: f64,
    /// End of the flight: at the base, or at the last exit if there is no base.
    pub end_s: f64,
    /// Fuel burnt.
    pub fuel_used_kg: f64,
    /// Sum of the visits' worths.
    pub benefits: f64,
    /// Expected personnel and failure costs.
    pub costs: f64,
    /// Benefits minus costs: the mission score expected.
    pub score: f64,
    /// No plan can have more benefits than this, where a bound is known.
    pub benefits_bound: Option<f64>,
    /// Targets not visited, with reasons.
    pub left_out: Vec<LeftOut>,
    /// One line for operators.
    pub summary: String,
}

impl SingleVisitPlan {
    /// Returns how much more benefit the best plan may have, as a share of the bound: 0 means proven optimal. `None` if no bound is
    /// known.
    pub fn gap(&self) -> Option<f64> {
        let bound = self.benefits_bound?;
        Some(if bound > 0.0 { ((bound - self.benefits) / bound).max(0.0) } else { 0.0 })
    }
}
