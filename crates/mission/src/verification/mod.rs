//! Independent check of a flight: finds positions that its mission forbids.
//!
//! The check reads the vehicle's reported positions, and true ones where the record contains them (from a simulator, while navigation
//! fails). It shares no arithmetic with the travel computation that chose the paths: a position is inside a zone if the bearings of its
//! corners make a full turn, on the sphere; distances are those of Lambert's formula for long lines on the ellipsoid, with errors of
//! about ten metres at a thousand kilometres.
//! Bound: O(corners + landing places) per position.

use crate::error::{MissionError, MissionResult};
use crate::recording::read;
use crate::text::plain_duration;
use crate::vehicle::Airframe;
use crate::{Mission, TargetKind};
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind};
use apex_model::planned::Location;
use apex_model::problem::{AirspaceZone, Position, ZoneKind};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::ports::Observer;
use apex_runtime::record::RecordReader;
use libm::{atan, atan2, cos, sin, sqrt, tan};
use serde::Serialize;
use std::fmt;

/// Least height over ground in cruise: for large fixed wings; for rotorcraft and small aircraft. It does not depend on the requirements
/// of the mission, by which the flight itself was planned.
const GROUND_MARGIN_M: (f64, f64) = (300.0, 30.0);
/// Greatest mass of a small unmanned aircraft (14 CFR 107.3: 55 lb), which operates at most 122 m above the ground (14 CFR 107.51).
const SMALL_AIRCRAFT_KG: f64 = 25.0;
/// Phases of flight in which the ground may be near.
const NEAR_GROUND: [&str; 8] =
    ["parked", "taking-off", "climbing", "approaching", "landing", "hovering", "gliding", "crashed"];
/// The phase after a crash.
const CRASHED: &str = "crashed";
/// Climb rate above which the vehicle is leaving the ground, as after a landing that was interrupted.
const CLIMB_M_S: f64 = 0.5;
/// Time after a phase near the ground during which the height over ground is not checked.
const AFTER_GROUND: Duration = Duration(30_000_000_000);
/// Greatest time in the air without a new position that counts as verified: several of the slowest reports of a vehicle.
const UNVERIFIED_MIN: Duration = Duration(60_000_000_000);
/// Ground speed from which on a vehicle cannot be where it was.
const MOVING_M_S: f64 = 3.0;
/// Findings kept with place and time; all are counted.
const FINDINGS_KEPT: usize = 1_000;

/// Violation by a flight.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Violation {
    /// Inside this restricted zone while the zone was active.
    Inside(String),
    /// Outside of every permitted zone that was active.
    OutsidePermitted,
    /// Too near to the ground, without take-off, landing or climb.
    NearGround,
    /// The flight ended in the ground.
    Crashed,
    /// Farther from every landing place than the mission allows.
    BeyondLandingDistance,
}

impl Violation {
    /// Returns the requirement by its name in `(requirement-broken NAME WHY)`.
    pub fn requirement(&self) -> &str {
        match self {
            Violation::Inside(zone) => zone,
            Violation::OutsidePermitted => "permitted area",
            Violation::NearGround | Violation::Crashed => "ground",
            Violation::BeyondLandingDistance => "landing distance",
        }
    }
}

/// One position at which a requirement was violated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Instant.
    pub t_s: f64,
    /// Position.
    pub position: Position,
    /// Altitude above mean sea level.
    pub altitude_m: f64,
    /// Kind.
    pub violation: Violation,
}

/// A flight's positions held against the requirements of its mission.
#[derive(Clone, Debug)]
pub struct FlightCheck {
    zones: Vec<AirspaceZone>,
    landing_places: Vec<Position>,
    landing_distance_m_max: Option<f64>,
    ground_margin_m: f64,
    phase: String,
    height_m: Option<f64>,
    is_climbing: bool,
    /// Last instant at which a small height was permitted.
    near_ground_until: Time,
    is_airborne: bool,
    is_crashed: bool,
    is_flying_agent: bool,
    ground_speed_m_s: f64,
    /// The last position that differs from the one before, and the last instant at which the position was known.
    known: Option<Location>,
    known_at: Time,
    /// Instant of the last step.
    now: Time,
    result: CheckResult,
}

/// Findings of the check of a flight.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CheckResult {
    /// Positions in the air that were checked.
    pub positions: u64,
    /// Number of these positions inside active restricted zones.
    pub inside_zones: u64,
    /// Number of these positions outside of the permitted area.
    pub outside_permitted: u64,
    /// Number of these positions too near to the ground, without take-off, landing and climbs; a crash counts as one.
    pub near_ground: u64,
    /// Number of these positions beyond the required landing distance.
    pub beyond_landing_distance: u64,
    /// Parts of the flight in the air without a new position, s of mission time: nothing can be said about them.
    pub unverified_s: Vec<(f64, f64)>,
    /// Requirements that the flight announced as broken, in order.
    pub said_broken: Vec<(f64, String)>,
    /// The first findings, in order.
    pub findings: Vec<Finding>,
}

impl CheckResult {
    /// Returns the number of violations: a position counts once for each requirement that is violated there.
    pub fn violations(&self) -> u64 {
        self.inside_zones + self.outside_permitted + self.near_ground + self.beyond_landing_distance
    }

    /// Returns true if every position keeps the requirements, and no part of the flight in the air is without positions.
    pub fn is_verified(&self) -> bool {
        self.violations() == 0 && self.unverified_s.is_empty()
    }

    /// Returns the kept findings about requirements that the flight had not announced as broken before.
    pub fn unsaid(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| {
            let name = finding.violation.requirement();
            let names = |words: &str| words.split("; ").any(|part| part.strip_prefix(name).is_some_and(ends_name));
            !self.said_broken.iter().any(|(t_s, words)| *t_s <= finding.t_s && names(words))
        })
    }
}

impl FlightCheck {
    /// Returns a check of flights of `mission`.
    pub fn new(mission: &Mission) -> FlightCheck {
        let is_place = |target: &&crate::Target| matches!(target.kind, TargetKind::Base);
        let bases = mission.targets.iter().filter(is_place).map(|base| base.position);
        let fixed_wing = mission.model.airframe == Airframe::FixedWing;
        let is_large = fixed_wing && mission.model.mass_kg >= SMALL_AIRCRAFT_KG;
        let ground_margin_m = if is_large { GROUND_MARGIN_M.0 } else { GROUND_MARGIN_M.1 };
        FlightCheck {
            zones: mission.zones.clone(),
            landing_places: mission.airfields.iter().map(|field| field.position).chain(bases).collect(),
            landing_distance_m_max: mission.requirements.landing_distance_m_max(),
            ground_margin_m,
            phase: String::new(),
            height_m: None,
            is_climbing: false,
            near_ground_until: Time::ZERO,
            is_airborne: false,
            is_crashed: false,
            is_flying_agent: true,
            ground_speed_m_s: 0.0,
            known: None,
            known_at: Time::ZERO,
            now: Time::ZERO,
            result: CheckResult::default(),
        }
    }

    /// Returns the findings until now.
    pub fn result(&self) -> &CheckResult {
        &self.result
    }

    /// Checks the vehicle's reports in one batch, and the agent's announcements about requirements.
    pub fn take(&mut self, batch: &Batch, effects: &[Effect]) {
        for effect in effects {
            if let Effect::Inform { form, .. } = effect
                && let Some([head, name, why]) = form.as_list()
                && head.as_symbol().is_some_and(|head| head.is("requirement-broken"))
            {
                let text = |value: &Value| match value {
                    Value::Text(text) => text.to_string(),
                    other => other.to_string(),
                };
                self.result.said_broken.push((batch.now.seconds(), format!("{}: {}", text(name), text(why))));
            }
        }
        let (mut here, mut truth) = (None, None);
        let was_airborne = self.is_airborne;
        self.now = batch.now;
        for event in &batch.events {
            if let EventKind::Measurement(variable, value) = &event.kind {
                match variable.attribute.folded() {
                    "location" => here = Location::from_value(value).map(|location| (event.at, location)).or(here),
                    "truth-location" => {
                        truth = Location::from_value(value).map(|location| (event.at, location)).or(truth);
                    }
                    "flight-phase" => {
                        if let Some(word) = value.as_symbol() {
                            self.phase = word.folded().to_string();
                        }
                    }
                    "vertical-speed" => {
                        self.is_climbing = value.as_number().is_some_and(|(speed, _)| speed > CLIMB_M_S);
                    }
                    "height-above-ground" => self.height_m = value.as_number().map(|(metres, _)| metres),
                    "on-ground" => self.is_airborne = !value.is_true(),
                    "ground-speed" => self.ground_speed_m_s = value.as_number().map_or(0.0, |(speed, _)| speed),
                    _ => {}
                }
            }
        }
        self.find_gap(was_airborne, truth.or(here));
        if let Some((at, location)) = truth.or(here) {
            self.find_crash(at, location);
            if self.is_airborne {
                self.look(at, location);
            }
        }
    }

    /// Finds the end of a part of the flight without a new position: a position, the landing, or the end of the record. A position that
    /// repeats the one before it, although the vehicle moves, is not a new one.
    fn find_gap(&mut self, was_airborne: bool, position: Option<(Time, Location)>) {
        if !was_airborne {
            self.known_at = self.now;
        }
        let is_new = |here: Location| self.ground_speed_m_s < MOVING_M_S || self.known != Some(here);
        let new = position.filter(|(_, here)| is_new(*here));
        if new.is_some() || was_airborne && !self.is_airborne {
            self.end_gap(new.map_or(self.now, |(at, _)| at));
            self.known = new.map(|(_, here)| here).or(self.known);
        }
    }

    fn end_gap(&mut self, at: Time) {
        if at - self.known_at > UNVERIFIED_MIN {
            self.result.unverified_s.push((self.known_at.seconds(), at.seconds()));
        }
        self.known_at = self.known_at.max(at);
    }

    /// Ends the check with the last step of the flight.
    pub fn finish(mut self) -> CheckResult {
        if self.is_airborne {
            self.end_gap(self.now);
        }
        self.result
    }

    /// Finds the end of the flight in the ground, which is reported with the vehicle on the ground.
    fn find_crash(&mut self, at: Time, here: Location) {
        if self.phase != CRASHED || std::mem::replace(&mut self.is_crashed, true) {
            return;
        }
        self.result.positions += u64::from(!self.is_airborne);
        self.result.near_ground += 1;
        self.keep(at.seconds(), here, vec![Violation::Crashed]);
    }

    fn look(&mut self, at: Time, here: Location) {
        let t_s = at.seconds();
        let counts = |zone: &&AirspaceZone| {
            zone.active.contains(t_s) && zone.altitude_m_min <= here.altitude_m && here.altitude_m < zone.altitude_m_max
        };
        self.result.positions += 1;
        let mut found = Vec::new();
        let restricted = self.zones.iter().filter(|zone| zone.kind == ZoneKind::Restricted).filter(counts);
        let inside = restricted.filter(|zone| is_around(&zone.corners, here.position));
        found.extend(inside.map(|zone| Violation::Inside(zone.name.clone())));
        self.result.inside_zones += u64::from(!found.is_empty());
        let mut permitted = self.zones.iter().filter(|zone| zone.kind == ZoneKind::Permitted).peekable();
        if permitted.peek().is_some() && !permitted.filter(counts).any(|zone| is_around(&zone.corners, here.position)) {
            self.result.outside_permitted += 1;
            found.push(Violation::OutsidePermitted);
        }
        let near = self.height_m.is_some_and(|height_m| height_m < self.ground_margin_m);
        if NEAR_GROUND.contains(&self.phase.as_str()) {
            self.near_ground_until = at + AFTER_GROUND;
        } else if near && !self.is_climbing && at > self.near_ground_until {
            self.result.near_ground += 1;
            found.push(Violation::NearGround);
        }
        if let Some(limit_m) = self.landing_distance_m_max
            && !self.landing_places.iter().any(|place| lambert_distance_m(*place, here.position) <= limit_m)
        {
            self.result.beyond_landing_distance += 1;
            found.push(Violation::BeyondLandingDistance);
        }
        self.keep(t_s, here, found);
    }

    fn keep(&mut self, t_s: f64, here: Location, found: Vec<Violation>) {
        let room = FINDINGS_KEPT.saturating_sub(self.result.findings.len());
        let finding = |violation| Finding { t_s, position: here.position, altitude_m: here.altitude_m, violation };
        self.result.findings.extend(found.into_iter().take(room).map(finding));
    }
}

impl Observer for FlightCheck {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.is_flying_agent = agent == 0;
        Ok(())
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        if self.is_flying_agent {
            self.take(batch, effects);
        }
        Ok(())
    }
}

/// Checks the flight of a record.
///
/// # Errors
/// A record that cannot be read.
pub fn verify(reader: &RecordReader, mission: &Mission) -> MissionResult<CheckResult> {
    let mut check = FlightCheck::new(mission);
    for step in reader.steps_of_all(Time::END).map_err(read)? {
        let step = step.map_err(read)?;
        if step.agent == 0 {
            let effects = step.decoded_effects().map_err(|fault| {
                let path = reader.path().display();
                MissionError::record_file(format!("the flight record {path} is damaged")).because(fault)
            })?;
            check.take(&step.batch, &effects);
        }
    }
    Ok(check.finish())
}

impl fmt::Display for CheckResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} positions in the air:", self.positions)?;
        writeln!(f, "  {:6} inside an active restricted zone", self.inside_zones)?;
        writeln!(f, "  {:6} outside of the permitted area", self.outside_permitted)?;
        writeln!(f, "  {:6} under way below the height over ground, or crashed", self.near_ground)?;
        write!(f, "  {:6} beyond the landing distance", self.beyond_landing_distance)?;
        for (from_s, until_s) in &self.unverified_s {
            let [from, until] = [from_s, until_s].map(|at_s| Time::from_seconds(*at_s));
            let part = plain_duration(until - from);
            write!(
                f,
                "\nnot verified: from {from} to {until} ({part}) the vehicle was in the air and reported no new position"
            )?;
        }
        for finding in self.findings.iter().take(20) {
            let Position { latitude_deg, longitude_deg } = finding.position;
            let at = Time::from_seconds(finding.t_s);
            write!(
                f,
                "\n{at}: ({latitude_deg:.5} {longitude_deg:.5} {:.0} m) {:?}",
                finding.altitude_m, finding.violation
            )?;
        }
        for (t_s, words) in &self.said_broken {
            write!(f, "\n{}: the flight reported that it had to violate {words}", Time::from_seconds(*t_s))?;
        }
        Ok(())
    }
}

/// Returns true if a whole name is followed by nothing or by the reason.
fn ends_name(rest: &str) -> bool {
    rest.is_empty() || rest.starts_with(": ")
}

/// Returns true if a polygon contains a position: the bearings of its corners, followed edge by edge, then make a full turn.
fn is_around(corners: &[Position], here: Position) -> bool {
    let next = corners.iter().skip(1).chain(corners.first());
    let turned: f64 =
        corners.iter().zip(next).map(|(a, b)| half_turns(bearing_rad(here, *b) - bearing_rad(here, *a))).sum();
    turned.abs() > std::f64::consts::PI
}

fn half_turns(angle_rad: f64) -> f64 {
    atan2(sin(angle_rad), cos(angle_rad))
}

fn bearing_rad(from: Position, to: Position) -> f64 {
    let (phi_1, phi_2) = (from.latitude_deg.to_radians(), to.latitude_deg.to_radians());
    let east = (to.longitude_deg - from.longitude_deg).to_radians();
    atan2(sin(east) * cos(phi_2), cos(phi_1) * sin(phi_2) - sin(phi_1) * cos(phi_2) * cos(east))
}

/// Returns the distance by Lambert's formula (W. D. Lambert, "The distance between two widely separated points on the surface of the
/// earth", Journal of the Washington Academy of Sciences 32, 1942) on WGS84.
fn lambert_distance_m(a: Position, b: Position) -> f64 {
    const SEMI_MAJOR_M: f64 = 6_378_137.0;
    const FLATTENING: f64 = 1.0 / 298.257_223_563;
    let reduced = |position: Position| atan((1.0 - FLATTENING) * tan(position.latitude_deg.to_radians()));
    let (beta_1, beta_2) = (reduced(a), reduced(b));
    let east = (b.longitude_deg - a.longitude_deg).to_radians();
    let (half_north, half_east) = (sin(0.5 * (beta_2 - beta_1)), sin(0.5 * east));
    let chord = half_north * half_north + cos(beta_1) * cos(beta_2) * half_east * half_east;
    let sigma = 2.0 * atan2(sqrt(chord), sqrt((1.0 - chord).max(0.0)));
    if sigma < 1e-9 {
        return 0.0;
    }
    let (p, q) = (0.5 * (beta_1 + beta_2), 0.5 * (beta_2 - beta_1));
    let (half_sine, half_cosine) = (sin(0.5 * sigma), cos(0.5 * sigma));
    let square = |x: f64| x * x;
    let x = (sigma - sin(sigma)) * square(sin(p) * cos(q)) / square(half_cosine);
    let y = (sigma + sin(sigma)) * square(cos(p) * sin(q)) / square(half_sine);
    SEMI_MAJOR_M * (sigma - 0.5 * FLATTENING * (x + y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_vincenty() {
        // Flinders Peak to Buninyon: 54,972.271 m on GRS80, which differs from WGS84 by less than a millimetre here.
        let flinders =
            Position::new(-(37.0 + 57.0 / 60.0 + 3.720_30 / 3600.0), 144.0 + 25.0 / 60.0 + 29.524_40 / 3600.0);
        let buninyon =
            Position::new(-(37.0 + 39.0 / 60.0 + 10.156_10 / 3600.0), 143.0 + 55.0 / 60.0 + 35.383_90 / 3600.0);
        assert!((lambert_distance_m(flinders, buninyon) - 54_972.271).abs() < 1.0);
    }

    #[test]
    fn corners_go_around_what_is_inside() {
        let corners = [(37.3, -117.05), (37.88, -116.92), (37.88, -115.3), (36.85, -115.3), (36.85, -116.45)];
        let corners = corners.map(|(latitude, longitude)| Position::new(latitude, longitude));
        assert!(is_around(&corners, Position::new(37.4, -116.0)));
        assert!(!is_around(&corners, Position::new(36.95, -116.9)));
        assert!(!is_around(&corners, Position::new(37.4, -115.2)));
    }
}
