//! The cells of a flight as remembered by the situation.
//!
//! A radar reports the nearest cell; others are remembered with their drift until they are expected nearer than the nearest one. Published
//! as an input of the next batch, so that the record contains it: `(storm-areas AIRCRAFT)`, in flights that pursue `(guard against
//! storms)`, which says `(avoiding-storms AIRCRAFT)`.

use super::areas;
use super::cell::{AHEAD_S, StormTrack};
use crate::Mission;
use crate::position::PositionFilter;
use crate::vehicle::turn_radius_m;
use apex_geo::geodesy;
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind, StateVariable};
use apex_model::planned::Location;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use serde::{Deserialize, Serialize};

/// Maximum number of remembered cells.
const CELLS_MAX: usize = 12;
/// Without a report for this long no cell is on the radar.
const SILENCE_S: f64 = 300.0;
/// A cell that was not the nearest one for this long is forgotten.
const UNSEEN_S: f64 = 3_600.0;
/// A cell that is expected nearer than the nearest one by this, and by this for each second since its sighting, has dissolved.
const NEARER_M: f64 = 3_000.0;
const NEARER_MPS: f64 = 10.0;
/// Areas are published again if a cell is off its published course by this, now or in half an hour, or after this time.
const OFF_M: (f64, f64) = (1_000.0, 4_000.0);
const SOON_S: f64 = 1_800.0;
const RENEWED_S: f64 = 900.0;
/// Interval between instants at which a place is compared with the cells.
const STEP_S: f64 = 60.0;

/// Everything remembered of cells.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StormMemory {
    cells: Vec<StormTrack>,
    here: Option<Position>,
    positions: PositionFilter,
    /// True once the program has said that it avoids storms.
    is_avoiding: bool,
    /// The cells that were published last, and the instant.
    published: Option<(f64, Vec<StormTrack>)>,
}

impl StormMemory {
    /// Observes a step of the agent that flies; returns the inputs for the next batch.
    pub(crate) fn observe(&mut self, mission: &Mission, batch: &Batch, effects: &[Effect]) -> Option<Input> {
        let (mut distance_m, mut bearing_deg, mut radius_m) = (None, None, None);
        let mut moved = false;
        for event in &batch.events {
            let EventKind::Measurement(variable, value) = &event.kind else { continue };
            if variable.object.as_symbol() != Some(&mission.agent.name) {
                continue;
            }
            let number = |unit: Dimension| value.as_number().filter(|(_, found)| *found == unit).map(|(si, _)| si);
            match variable.attribute.folded() {
                "location" if self.positions.admits(mission, event.at.seconds(), "location", value) => {
                    self.here = Location::from_value(value).map(|at| at.position).or(self.here);
                    moved = true;
                }
                "storm-distance" => distance_m = number(Dimension::LENGTH),
                "storm-radius" => radius_m = number(Dimension::LENGTH),
                "storm-bearing" => bearing_deg = number(Dimension::ANGLE).map(f64::to_degrees),
                _ => {}
            }
        }
        for effect in effects {
            if let Effect::Inform { form, .. } = effect {
                self.is_avoiding |= form.head().is_some_and(|head| head.is("avoiding-storms"));
            }
        }
        let now_s = batch.now.seconds();
        if let (Some(here), Some(distance_m), Some(bearing_deg), Some(radius_m)) =
            (self.here, distance_m, bearing_deg, radius_m)
        {
            let middle = geodesy::destination(here, bearing_deg, (distance_m + radius_m).max(0.0));
            self.see(now_s, (here, distance_m), middle, radius_m);
        } else if moved && self.cells.iter().all(|cell| now_s - cell.seen_s > SILENCE_S) {
            self.cells.clear();
        }
        self.publish(mission, batch.now)
    }

    fn see(&mut self, now_s: f64, (here, nearest_m): (Position, f64), middle: Position, radius_m: f64) {
        let seen = self.cells.iter_mut().find(|cell| cell.is_at(now_s, middle, radius_m));
        match seen {
            Some(cell) => cell.follow(now_s, middle, radius_m),
            None => self.cells.push(StormTrack::new(now_s, middle, radius_m)),
        }
        self.cells.retain(|cell| {
            let age_s = now_s - cell.seen_s;
            let is_there = || cell.distance_m(here, now_s) > nearest_m - NEARER_M - NEARER_MPS * age_s;
            age_s <= 0.0 || (age_s < UNSEEN_S && is_there())
        });
        if self.cells.len() > CELLS_MAX {
            self.cells.remove(0);
        }
    }

    /// Returns the areas that paths avoid from now on; `None` if they have not changed.
    fn publish(&mut self, mission: &Mission, now: Time) -> Option<Input> {
        let now_s = now.seconds();
        let is_due = match &self.published {
            None => !self.cells.is_empty(),
            Some((at_s, cells)) => {
                let is_off = |(was, is): (&StormTrack, &StormTrack)| {
                    let off_m = |at_s: f64| geodesy::distance_m(was.middle_at(at_s), is.middle_at(at_s));
                    was.radius_m != is.radius_m || off_m(now_s) > OFF_M.0 || off_m(now_s + SOON_S) > OFF_M.1
                };
                let is_old = now_s - at_s >= RENEWED_S && !self.cells.is_empty();
                cells.len() != self.cells.len() || is_old || cells.iter().zip(&self.cells).any(is_off)
            }
        };
        if !self.is_avoiding || !is_due {
            return None;
        }
        self.published = Some((now_s, self.cells.clone()));
        let shown = areas::zones(&self.cells, now_s, None).iter().map(areas::area_value).collect::<Vec<Value>>();
        let variable = StateVariable::new(Symbol::new("storm-areas"), Value::symbol(mission.agent.name.printed()));
        Some(Input::new(now, EventKind::Measurement(variable, Value::list(shown))))
    }

    /// Returns the cells that are known.
    pub(crate) fn cells(&self) -> &[StormTrack] {
        &self.cells
    }

    /// Returns true if the program avoids storms.
    pub(crate) fn is_avoiding(&self) -> bool {
        self.is_avoiding
    }

    /// Returns the mission with the areas of the cells as zones, for a plan that begins `here` at `now_s`.
    pub(crate) fn without_storms(&self, mut mission: Mission, here: Position, now_s: f64) -> Mission {
        if self.is_avoiding {
            let margin_m = mission.requirements.zone_margin_m.max(mission.requirements.obstacle_margin_m);
            let around_m = margin_m + turn_radius_m(&mission.model);
            mission.zones.extend(areas::zones(&self.cells, now_s, Some((here, around_m))));
        }
        mission
    }

    /// Returns the next time in which a cell is nearer than `kept_m` to a place: its first instant, and the first one after it at which
    /// none is; `None` for an end that cannot be predicted.
    pub(crate) fn spell(&self, place: Position, kept_m: f64, now_s: f64) -> Option<(f64, Option<f64>)> {
        if self.cells.is_empty() {
            return None;
        }
        let is_near = |at_s: &f64| self.is_near(place, kept_m, (*at_s, *at_s));
        let mut instants = (0..=(AHEAD_S / STEP_S) as u32).map(|step| now_s + STEP_S * f64::from(step));
        let from_s = instants.find(is_near)?;
        Some((from_s, instants.find(|at_s| !is_near(at_s))))
    }

    /// Returns true if a cell comes nearer than `kept_m` to a place between two instants, as far as cells can be predicted.
    pub(crate) fn is_near(&self, place: Position, kept_m: f64, (from_s, until_s): (f64, f64)) -> bool {
        self.cells.iter().any(|cell| {
            let until_s = until_s.min(cell.seen_s + AHEAD_S);
            let count = libm::ceil((until_s - from_s).max(0.0) / STEP_S) as u32;
            from_s <= cell.seen_s + AHEAD_S
                && (0..=count).any(|step| {
                    let at_s = (from_s + STEP_S * f64::from(step)).min(until_s.max(from_s));
                    cell.distance_m(place, at_s) < kept_m
                })
        })
    }
}
