//! Independent check of a flight: finds positions that its mission forbids.
//!
//! The check reads the vehicle's reported positions, and true ones where the record contains them (from a simulator, while navigation
//! fails). It shares no arithmetic with the travel computation that chose the paths: a position is inside a zone if the bearings of its
//! corners make a full turn, on the sphere; distances are those of Lambert's formula for long lines on the ellipsoid, with errors of
//! about ten metres at a thousand kilometres.
//! Bound: O(corners + landing places) per position.

mod result;
mod sphere;

pub use result::{CheckResult, Finding, ReportedViolation, Violation};

use crate::error::{MissionError, MissionResult};
use crate::in_air::AirState;
use crate::recording::read;
use crate::situation::MissionEvent;
use crate::vehicle::Airframe;
use crate::{Mission, TargetKind};
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind};
use apex_model::planned::Location;
use apex_model::problem::{AirspaceZone, Position, ZoneKind};
use apex_model::time::{Duration, Time};
use apex_runtime::ports::Observer;
use apex_runtime::record::RecordReader;
use sphere::{is_around, lambert_distance_m};

/// Least height over ground in cruise of missions without the requirement `terrain`: for large fixed wings; for rotorcraft and small
/// aircraft.
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
/// Greatest wind that carries a vehicle: more than the jet stream.
const WIND_M_S: f64 = 120.0;
/// Distance between positions that needs no time: errors of receivers, and coarse reports.
const POSITION_ERROR_M: f64 = 500.0;
/// Findings kept with place and time; all are counted.
const FINDINGS_KEPT: usize = 1_000;

/// A flight's positions held against the requirements of its mission.
#[derive(Clone, Debug)]
pub struct FlightCheck {
    zones: Vec<AirspaceZone>,
    landing_places: Vec<Position>,
    landing_distance_m_max: Option<f64>,
    ground_margin_m: f64,
    /// `None` for a vehicle that does not report it.
    phase: Option<String>,
    height_m: Option<f64>,
    is_climbing: bool,
    /// Last instant at which a small height was permitted.
    near_ground_until: Time,
    air: AirState,
    is_crashed: bool,
    is_flying_agent: bool,
    /// `None` for a vehicle that does not report it.
    ground_speed_m_s: Option<f64>,
    /// The last position that differs from the one before, and the last instant at which the position was known.
    known: Option<Location>,
    known_at: Time,
    /// The last reported position.
    reported: Option<(Time, Location)>,
    /// Greatest speed over the ground.
    speed_m_s_max: f64,
    /// Instant of the last step.
    now: Time,
    result: CheckResult,
}

impl FlightCheck {
    /// Returns a check of flights of `mission`.
    pub fn new(mission: &Mission) -> FlightCheck {
        let is_place = |target: &&crate::Target| matches!(target.kind, TargetKind::Base);
        let bases = mission.targets.iter().filter(is_place).map(|base| base.position);
        let fixed_wing = mission.model.airframe == Airframe::FixedWing;
        let is_large = fixed_wing && mission.model.mass_kg >= SMALL_AIRCRAFT_KG;
        let usual_m = if is_large { GROUND_MARGIN_M.0 } else { GROUND_MARGIN_M.1 };
        let ground_margin_m = mission.requirements.terrain_clearance_m.unwrap_or(usual_m);
        FlightCheck {
            zones: mission.zones.clone(),
            landing_places: mission.airfields.iter().map(|field| field.position).chain(bases).collect(),
            landing_distance_m_max: mission.requirements.landing_distance_m_max(),
            ground_margin_m,
            phase: None,
            height_m: None,
            is_climbing: false,
            near_ground_until: Time::ZERO,
            air: AirState::default(),
            is_crashed: false,
            is_flying_agent: true,
            ground_speed_m_s: None,
            known: None,
            known_at: Time::ZERO,
            reported: None,
            speed_m_s_max: mission.model.true_airspeed_m_s_max + WIND_M_S,
            now: Time::ZERO,
            result: CheckResult { ground_margin_m, ..CheckResult::default() },
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
                && let Some(MissionEvent::RequirementBroken { names, why }) = MissionEvent::read(form)
            {
                self.result.said_broken.push(ReportedViolation { t_s: batch.now.seconds(), names, why });
            }
        }
        let (mut here, mut truth) = (None, None);
        let was_airborne = self.is_airborne();
        self.now = batch.now;
        self.result.steps += 1;
        for event in &batch.events {
            let EventKind::Measurement(variable, value) = &event.kind else {
                self.air.hear(&event.kind);
                let is_crash = matches!(&event.kind, EventKind::Occurrence(form) if form.head().is_some_and(|head| head.is(CRASHED)));
                if is_crash && self.phase.is_none() {
                    self.phase = Some(CRASHED.to_string());
                }
                continue;
            };
            self.air.measure(variable.attribute.folded(), value);
            match variable.attribute.folded() {
                "location" => {
                    if let Some(location) = Location::from_value(value) {
                        here = Some((event.at, location));
                        self.find_jump(event.at, location);
                    }
                }
                "truth-location" => {
                    truth = Location::from_value(value).map(|location| (event.at, location)).or(truth);
                }
                "flight-phase" => {
                    if let Some(word) = value.as_symbol() {
                        self.phase = Some(word.folded().to_string());
                    }
                }
                "vertical-speed" => {
                    self.is_climbing = value.as_number().is_some_and(|(speed, _)| speed > CLIMB_M_S);
                }
                "height-above-ground" => self.height_m = value.as_number().map(|(metres, _)| metres),
                "ground-speed" => self.ground_speed_m_s = value.as_number().map(|(speed, _)| speed),
                _ => {}
            }
        }
        self.find_gap(was_airborne, truth.or(here));
        if let Some((at, location)) = truth.or(here) {
            self.find_crash(at, location);
            if self.is_airborne() {
                self.look(at, location);
            }
        }
        effects.iter().for_each(|effect| self.air.take(effect));
    }

    fn is_airborne(&self) -> bool {
        !self.air.is_on_ground()
    }

    /// Finds a reported position to which the vehicle cannot have flown from the one before: one of the two is wrong.
    fn find_jump(&mut self, at: Time, here: Location) {
        let Some((before, from)) = self.reported.replace((at, here)) else { return };
        let reach_m = POSITION_ERROR_M + self.speed_m_s_max * (at - before).seconds().abs();
        let is_far = (here.altitude_m - from.altitude_m).abs() > reach_m
            || here.position != from.position && lambert_distance_m(from.position, here.position) > reach_m;
        if is_far {
            self.result.jumps += 1;
            self.result.first_jump_s.get_or_insert(at.seconds());
        }
    }

    /// Finds the end of a part of the flight without a new position: a position, the landing, or the end of the record. A position that
    /// repeats the one before it, although the vehicle moves, is not a new one.
    fn find_gap(&mut self, was_airborne: bool, position: Option<(Time, Location)>) {
        if !was_airborne {
            self.known_at = self.now;
        }
        let repeats = position.is_some_and(|(_, here)| self.known == Some(here));
        self.result.repeats_unjudged += u64::from(was_airborne && repeats && self.ground_speed_m_s.is_none());
        let stands = self.ground_speed_m_s.is_none_or(|speed_m_s| speed_m_s < MOVING_M_S);
        let is_new = |here: Location| stands || self.known != Some(here);
        let new = position.filter(|(_, here)| is_new(*here));
        if new.is_some() || was_airborne && !self.is_airborne() {
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
        if self.is_airborne() {
            self.end_gap(self.now);
        }
        self.result
    }

    /// Finds the end of the flight in the ground, which is reported with the vehicle on the ground.
    fn find_crash(&mut self, at: Time, here: Location) {
        if self.phase.as_deref() != Some(CRASHED) || std::mem::replace(&mut self.is_crashed, true) {
            return;
        }
        self.result.positions += u64::from(!self.is_airborne());
        self.result.near_ground += 1;
        self.keep(at.seconds(), here, vec![Violation::Crashed]);
    }

    fn look(&mut self, at: Time, here: Location) {
        let t_s = at.seconds();
        let counts = |zone: &&AirspaceZone| {
            zone.active.contains(t_s) && zone.altitude_m_min <= here.altitude_m && here.altitude_m < zone.altitude_m_max
        };
        self.result.positions += 1;
        self.result.air_derived += u64::from(!self.air.is_reported());
        self.result.height_unknown += u64::from(self.height_m.is_none());
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
        let is_near_on_purpose = match &self.phase {
            Some(phase) => NEAR_GROUND.contains(&phase.as_str()),
            None => self.air.takes_off_or_lands(),
        };
        if is_near_on_purpose {
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
