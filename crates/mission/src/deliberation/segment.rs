//! Decision about a segment of a line whose data were lost: fly it again, or keep its time for other targets (paper, section IV, example
//! 1).
//!
//! Runs: once for each `(segment-lost TARGET FROM TO END)` that the flying agent sends. The gain is what the segment adds to what has
//! been seen and to what the rest of the observation will see, in the turbulence that is measured. The price is the opportunity cost: the
//! difference between the values of the rest of the plan, begun now and begun after the segment. The answer
//! `(segment-weighed TARGET FROM TO again|leave GAIN PRICE TEXT)` enters the next batch, and is recorded like all inputs.
//! Bound: one planning problem with the n remaining visits of the plan, and O(n^2) evaluations of them.

use crate::ground::MissionGround;
use crate::observing::{ForecastAir, scanner_of};
use crate::problem::single_visits;
use crate::score::FlownScore;
use crate::situation::Situation;
use crate::ways::{Limits, Request, Segment};
use crate::{Fire, Mission, Target, TargetKind};
use apex_geo::geodesy::{self, Position};
use apex_geo::wind;
use apex_model::effect::Effect;
use apex_model::event::EventKind;
use apex_model::planned::Location;
use apex_model::problem::{Plan, PlannedVisit, SingleVisitPlan, SingleVisitProblem};
use apex_model::time::Time;
use apex_model::value::Value;
use apex_observation::footprint::Ground;
use apex_observation::predict::{AirConditions, Conditions, PlannedLine, PredictionContext, gain_after};
use apex_observation::target::{ObservedTarget, WantedLook};
use apex_runtime::ports::Input;
use apex_solvers::planners::single_visit::{OrderValue, OrderedVisit, order_value};

/// Seconds until the wings are level after a disturbance: segments closer than twice the distance flown in this time are merged.
const SETTLE_S: f64 = 5.0;
/// Assumed time in seconds of a turn between two lines. It gives the instant at which the rest of the plan begins.
const TURN_S: f64 = 100.0;
/// Tolerance in metres for the middle of a segment on another one: the detour over the middle from end to end of the other one.
const SAME_M: f64 = 100.0;

/// A segment whose data were lost, and the end of its line.
#[derive(Clone, Debug, PartialEq)]
struct LostSegment {
    target: String,
    from: Value,
    to: Value,
    begin: Location,
    until: Location,
    line_end: Location,
}

/// Segments whose data were lost, with the answers so far.
#[derive(Clone, Debug, Default)]
pub(super) struct LostSegments {
    /// Segments that are not yet decided, with the instant of the loss.
    open: Vec<(Time, LostSegment)>,
    /// Decided segments; true if the segment is flown again.
    weighed: Vec<(LostSegment, bool)>,
}

/// Gain and price of flying a segment again.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Trade {
    /// Points that the segment adds.
    pub(super) gain_points: f64,
    /// Points that its time takes from the rest of the plan.
    pub(super) price_points: f64,
    /// Time for flying the segment again.
    pub(super) flight_s: f64,
    /// Targets that would be left out for it.
    pub(super) dropped: Vec<String>,
}

impl Trade {
    pub(super) fn is_worth_it(&self) -> bool {
        self.gain_points > self.price_points
    }

    fn text(&self) -> String {
        let Trade { gain_points, price_points, flight_s, dropped } = self;
        let less = match dropped.as_slice() {
            [] => "no target is left out".to_string(),
            [one] => format!("one target is left out: {one}"),
            more => format!("{} targets are left out: {}", more.len(), more.join(", ")),
        };
        format!(
            "flying the segment again adds {} points; its {flight_s:.0} s cost {} points of the rest of the plan ({less})",
            points(*gain_points),
            points(*price_points)
        )
    }
}

/// Returns points as text with one decimal; points below 0.95 have two significant digits, at most five decimals, so that a small gain can
/// be compared with a small price.
fn points(points: f64) -> String {
    let size = points.abs();
    let decimals = if (5e-6..0.95).contains(&size) { (1.0 - libm::floor(libm::log10(size))) as usize } else { 1 };
    format!("{points:.*}", decimals.min(5))
}

impl LostSegment {
    /// Reads `(segment-lost TARGET FROM TO END)`.
    fn read(form: &Value) -> Option<LostSegment> {
        let [head, target, from, to, end] = form.as_list()? else { return None };
        head.as_symbol().filter(|head| head.is("segment-lost"))?;
        Some(LostSegment {
            target: target.to_string(),
            begin: Location::from_value(from)?,
            until: Location::from_value(to)?,
            line_end: Location::from_value(end)?,
            from: from.clone(),
            to: to.clone(),
        })
    }

    fn length_m(&self) -> f64 {
        geodesy::distance_m(self.begin.position, self.until.position)
    }

    /// Returns true if the middle of this segment lies on `other`.
    fn is_on(&self, other: &LostSegment) -> bool {
        let middle = geodesy::midpoint(self.begin.position, self.until.position);
        let by_m =
            geodesy::distance_m(other.begin.position, middle) + geodesy::distance_m(middle, other.until.position);
        self.target == other.target && by_m <= other.length_m() + SAME_M
    }
}

impl LostSegments {
    /// Reads lost segments from the messages of the flying agent.
    pub(super) fn observe(&mut self, now: Time, effects: &[Effect]) {
        let said = effects.iter().filter_map(|effect| match effect {
            Effect::Inform { form, .. } => LostSegment::read(form),
            _ => None,
        });
        self.open.extend(said.map(|lost| (now, lost)));
    }

    /// Returns the answers about the segments lost in the last step.
    pub(super) fn weigh(&mut self, known: (&Mission, &Situation), flown: &FlownScore) -> Vec<Input> {
        let open = std::mem::take(&mut self.open);
        open.into_iter().map(|(at, lost)| self.answer(known, flown, lost, at)).collect()
    }

    fn answer(&mut self, known: (&Mission, &Situation), flown: &FlownScore, lost: LostSegment, at: Time) -> Input {
        let settle_m = 2.0 * SETTLE_S * known.0.model.true_airspeed_m_s_cruise;
        let near = |(other, is_again): &&(LostSegment, bool)| {
            let apart_m = geodesy::distance_m(other.until.position, lost.begin.position);
            !is_again && other.target == lost.target && other.line_end == lost.line_end && apart_m <= settle_m
        };
        // If a neighbouring segment was left before, both are flown again together.
        let merged = self.weighed.iter().rev().find(near).map(|(other, _)| LostSegment {
            begin: other.begin,
            from: other.from.clone(),
            ..lost.clone()
        });
        let was_offered = merged.is_none() && self.weighed.iter().any(|(other, _)| lost.is_on(other));
        let lost = merged.unwrap_or(lost);
        let trade = if was_offered {
            Err("the decision about this segment was made before".to_string())
        } else {
            trade(known, flown, &lost, at)
        };
        let (is_again, gain, price, text) = match trade {
            Ok(trade) => (trade.is_worth_it(), trade.gain_points, trade.price_points, trade.text()),
            Err(why) => (false, 0.0, 0.0, why),
        };
        let tenths = |points: f64| Value::Real(libm::round(10.0 * points) / 10.0);
        let form = Value::list([
            Value::symbol("segment-weighed"),
            Value::symbol(&lost.target),
            lost.from.clone(),
            lost.to.clone(),
            Value::symbol(if is_again { "again" } else { "leave" }),
            tenths(gain),
            tenths(price),
            Value::text(&text),
        ]);
        self.weighed.push((lost, is_again));
        Input::new(at, EventKind::Occurrence(form))
    }
}

/// Returns gain and price of flying a segment again whose data were lost at `at`.
///
/// # Errors
/// The reason for which it cannot be flown again.
fn trade(
    (mission, situation): (&Mission, &Situation),
    flown: &FlownScore,
    lost: &LostSegment,
    at: Time,
) -> Result<Trade, String> {
    let believed = flown.with_growth(situation.updates.believed(mission));
    let (target, fire) = wanted(&believed, &lost.target).ok_or("the target is not observed by scan lines")?;
    let here = situation.vehicle.position.ok_or("the vehicle has not reported its position")?;
    let altitude_m = lost.begin.altitude_m;
    let track_deg = geodesy::azimuth_deg(lost.begin.position, lost.until.position);
    let request = Request {
        from: here,
        from_altitude_m: situation.vehicle.altitude_m,
        from_track_rad: Some(track_deg.to_radians()),
        at_s: at.seconds(),
        to: here,
        to_altitude_m: altitude_m,
        to_track_rad: None,
        circle_radius_m: 0.0,
        stay_s: 0.0,
    };
    let segment = Segment {
        begin: lost.begin.position,
        until: lost.until.position,
        line_end: lost.line_end.position,
        altitude_m,
    };
    // The segment is flown within minutes, in the wind that blows here; the rest of the plan is compared in the wind of the plan.
    let measured = situation.in_measured_wind(believed.clone(), at.seconds());
    let again = Limits::of(&measured).segment_again(&request, &segment);
    let again = again.ok_or("no way back to the segment keeps the requirements")?;
    let rest = rest_of_lines(situation, lost, here);
    let leaves_s = at.seconds() + lines_s(&measured, &rest, altitude_m, at.seconds());
    let gain_points = gain((&measured, target, fire), situation, flown, (lost, &rest), at.seconds() + again.total_s)?;
    let from = rest.last().map_or(here, |(_, to)| *to);
    let (price_points, dropped) = match &situation.plan {
        Some(made) => match &made.plan {
            Plan::SingleVisit(plan) => {
                // Only targets that the plan still visits can be displaced.
                let is_ahead = |name: &str| visits_ahead(plan, &lost.target).any(|visit| visit.target == name);
                let delay = (at.seconds(), leaves_s, again.total_s);
                match single_visits(&believed, (situation, Some(flown), at), (&is_ahead, false)) {
                    Ok(problem) => price(&problem, plan, &lost.target, from, delay)?,
                    // No visits remain, so the time of the segment displaces nothing.
                    Err(_) => (0.0, Vec::new()),
                }
            }
            Plan::Surveillance(_) => (0.0, Vec::new()),
        },
        None => (0.0, Vec::new()),
    };
    Ok(Trade { gain_points, price_points, flight_s: again.total_s, dropped })
}

fn wanted<'a>(mission: &'a Mission, name: &str) -> Option<(&'a Target, &'a Fire)> {
    mission.targets.iter().find_map(|target| match &target.kind {
        TargetKind::Fire(fire) if fire.looks().any(|(look, _)| look == name) => Some((target, fire)),
        _ => None,
    })
}

/// Returns the lines that the observation still has to fly: the rest of the present one, and those that are entirely unseen.
fn rest_of_lines(situation: &Situation, lost: &LostSegment, here: Position) -> Vec<(Position, Position)> {
    let mut rest = vec![(here, lost.line_end.position)];
    let open = situation.visits.last().filter(|visit| visit.end.is_none() && visit.target == lost.target);
    let unseen = open.into_iter().flat_map(|visit| &visit.lines).filter(|line| line.count().1 == 0);
    rest.extend(unseen.map(|line| line.ends()));
    rest
}

/// Returns a line that is flown from `from_s` on.
fn planned(mission: &Mission, (from, to): (Position, Position), altitude_m: f64, from_s: f64) -> PlannedLine {
    let airspeed_mps = mission.model.true_airspeed_m_s_cruise;
    let track_deg = geodesy::azimuth_deg(from, to);
    let triangle = wind::triangle(track_deg, airspeed_mps, wind::at(&mission.forecast, from, altitude_m, from_s));
    let (ground_speed_mps, crab_deg) = triangle.map_or((airspeed_mps, 0.0), |triangle| {
        (triangle.ground_speed_mps, geodesy::wrap_180(triangle.heading_deg - track_deg))
    });
    let pitch_deg = mission.model.cruise_pitch_rad(altitude_m).to_degrees();
    PlannedLine { from, to, altitude_m, from_s, ground_speed_mps, crab_deg, pitch_deg, on_ground_s: None }
}

/// Returns the time for these lines with the turns between them.
fn lines_s(mission: &Mission, lines: &[(Position, Position)], altitude_m: f64, from_s: f64) -> f64 {
    let each = lines.iter().map(|line| {
        let line = planned(mission, *line, altitude_m, from_s);
        line.length_m() / line.ground_speed_mps
    });
    each.sum::<f64>() + TURN_S * lines.len().saturating_sub(1) as f64
}

/// The air as forecast, in the turbulence that is measured.
struct PresentAir<'a> {
    forecast: ForecastAir<'a>,
    edr: Option<f64>,
}

impl Conditions for PresentAir<'_> {
    fn at(&self, position: Position, altitude_m: f64, time_s: f64) -> AirConditions {
        let forecast = self.forecast.at(position, altitude_m, time_s);
        AirConditions { edr: self.edr.unwrap_or(forecast.edr), ..forecast }
    }
}

/// Returns the points that the segment adds to the ground seen so far and to the ground that the rest of the lines will see.
fn gain(
    (mission, target, fire): (&Mission, &Target, &Fire),
    situation: &Situation,
    flown: &FlownScore,
    (lost, rest): (&LostSegment, &[(Position, Position)]),
    again_s: f64,
) -> Result<f64, String> {
    let scanner = scanner_of(&mission.model).ok_or("the vehicle carries no line scanner")?;
    let observation = flown.observation();
    let grid = observation.grid(&target.id).ok_or("the target has no observable ground")?;
    let first_valid_s = observation.first_valid_s();
    let air = PresentAir { forecast: ForecastAir::new(mission), edr: situation.edr() };
    let ground: &dyn Ground = &MissionGround::new(mission.terrain.clone(), target.elevation_m);
    let context = PredictionContext {
        zero_unix_s: mission.settings.epoch_unix_s.unwrap_or(0.0),
        ground,
        conditions: &air,
        seen: observation.looks(&target.id),
        products: observation.products(),
        first_valid_s: &first_valid_s,
        is_explained: false,
    };
    // The arrival of the segment's image on the ground is unknown, and so is that of the other images: latency does not count here.
    let looks = fire.wanted.looks.iter().map(|look| WantedLook { latency: None, ..look.clone() }).collect();
    let wanted = ObservedTarget { looks, ..fire.wanted.clone() };
    let altitude_m = lost.begin.altitude_m;
    let lines: Vec<PlannedLine> = rest.iter().map(|line| planned(mission, *line, altitude_m, again_s)).collect();
    let again = planned(mission, (lost.begin.position, lost.until.position), altitude_m, again_s);
    Ok(gain_after(&wanted, grid, (&lines, &[again]), &scanner, &context).max(0.0))
}

/// Returns the points that a delay costs the later visits, and the targets that are then left out. Times: now, the departure to these
/// visits without the delay, and the length of the delay.
fn price(
    problem: &SingleVisitProblem,
    plan: &SingleVisitPlan,
    observed: &str,
    from: Position,
    (now_s, leaves_s, delay_s): (f64, f64, f64),
) -> Result<(f64, Vec<String>), String> {
    let order = ahead(problem, plan, observed);
    let value = |begin_s: f64| -> Result<OrderValue, String> {
        let spent_s = begin_s - now_s;
        let mut later = problem.clone();
        (later.start, later.start_s) = (from, begin_s);
        later.vehicle.endurance_s -= spent_s;
        later.vehicle.fuel_kg -= later.vehicle.fuel_flow_kg_per_s * spent_s;
        order_value(&later, &order)
    };
    let at_once = value(leaves_s)?;
    // If the delay leaves no time to fly, all remaining visits are lost.
    let delayed = value(leaves_s + delay_s).unwrap_or(OrderValue { score: 0.0, visited: Vec::new() });
    let lost = at_once.visited.iter().filter(|target| !delayed.visited.contains(target));
    let names = lost.filter_map(|target| problem.targets.get(*target)).map(|target| target.name.clone());
    Ok(((at_once.score - delayed.score).max(0.0), names.collect()))
}

/// Returns the visits of the plan after the one in progress; all of them if that is not in the plan.
fn visits_ahead<'a>(plan: &'a SingleVisitPlan, observed: &str) -> impl Iterator<Item = &'a PlannedVisit> {
    let after = plan.visits.iter().position(|visit| visit.target == observed).map_or(0, |at| at + 1);
    plan.visits.iter().skip(after)
}

/// Returns the open visits of the plan after the present one, each with the most similar manoeuvre of the problem.
fn ahead(problem: &SingleVisitProblem, plan: &SingleVisitPlan, observed: &str) -> Vec<OrderedVisit> {
    let visits = visits_ahead(plan, observed).filter_map(|visit| {
        let target = problem.targets.iter().position(|target| target.name == visit.target)?;
        let planned_s = visit.end_s - visit.begin_s;
        let manoeuvres = problem.targets.get(target)?.manoeuvres.iter().enumerate();
        let off_s = |duration_s: f64| (duration_s - planned_s).abs();
        let nearest = manoeuvres.min_by(|(_, a), (_, b)| off_s(a.duration_s).total_cmp(&off_s(b.duration_s)))?;
        let waits = visit.begin_s > visit.arrive_s + 1.0;
        let not_before_s = if waits { visit.begin_s } else { f64::NEG_INFINITY };
        Some(OrderedVisit { target, manoeuvre: nearest.0, not_before_s })
    });
    visits.collect()
}
