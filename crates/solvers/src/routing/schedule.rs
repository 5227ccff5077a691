//! Evaluates an order of visits: times, feasibility and score.

use super::flight_limit::FlightLimit;
use super::travel::{PointKey, Times, Travel};
use apex_geo::{geodesy, sun};
use apex_metrics::mission_score;
use apex_model::problem::{FailureTerm, Light, SingleVisitProblem, TimeWindow};
use apex_planning::solver::Budget;

/// Work units charged for one leg. The preparation of a path is charged separately.
pub(crate) const UNITS_PER_LEG: u64 = 2;
/// Times that differ by at most this are equal, so that sums of decimals do not decide.
const SAME_S: f64 = 1e-9;

/// One visit of a plan under construction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Choice {
    /// Index of the target.
    pub(crate) target: usize,
    /// Index of its manoeuvre.
    pub(crate) manoeuvre: usize,
    /// Earliest beginning of the observation, for a better timing factor; negative infinity to begin at once.
    pub(crate) not_before_s: f64,
}

/// Times of a visit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Timed {
    /// Departure from the preceding place.
    pub(crate) depart_s: f64,
    /// Arrival at the entry of the manoeuvre.
    pub(crate) arrive_s: f64,
    /// Beginning of the observation.
    pub(crate) begin_s: f64,
    /// End of the observation.
    pub(crate) end_s: f64,
    /// Value of the target times the factors of quality and timing.
    pub(crate) worth: f64,
}

/// The outcome of judging a whole order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Judged {
    /// The visits' times.
    pub(crate) visits: Vec<Timed>,
    /// End of the flight.
    pub(crate) end_s: f64,
    /// Benefits minus costs.
    pub(crate) score: f64,
}

impl Judged {
    /// Returns true if this evaluation is better than `other`: a higher score, or the same score in less time.
    pub(crate) fn beats(&self, other: &Judged) -> bool {
        let close = 1e-9 * (1.0 + self.score.abs());
        self.score > other.score + close || (self.score > other.score - close && self.end_s < other.end_s - 1e-6)
    }
}

/// Reason for which an order cannot be flown.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Infeasibility {
    /// No path; the phrase states why.
    Impossible(String),
    /// The last time window of a target closes too early.
    Closed {
        /// The target's index.
        target: usize,
    },
    /// The flight would end too late.
    TooLate {
        /// Time by which it would exceed its limit.
        over_s: f64,
    },
    /// A target that must precede another one comes later, or is missing.
    Order,
}

/// A validated problem with its travel model and windows.
pub(crate) struct Schedule<'a> {
    pub(crate) problem: &'a SingleVisitProblem,
    pub(crate) travel: Travel<'a>,
    /// For each target and manoeuvre the spans in which the observation may begin.
    windows: Vec<Vec<Vec<TimeWindow>>>,
    /// For each target the targets that must precede it.
    earlier: Vec<Vec<usize>>,
    costs: Costs,
    /// Latest end of the flight, and the limit that causes it.
    pub(crate) limit_s: f64,
    pub(crate) limit: FlightLimit<'a>,
}

impl<'a> Schedule<'a> {
    /// Prepares `problem`.
    ///
    /// # Errors
    /// An error message if the problem is invalid, no time to fly remains, or the vehicle must not be at its start or its base.
    pub(crate) fn new(problem: &'a SingleVisitProblem) -> Result<Schedule<'a>, String> {
        apex_planning::validate::single_visit(problem)?;
        let mut travel = Travel::new(problem)?;
        let (limit_s, limit) = FlightLimit::earliest(problem);
        if limit_s <= problem.start_s {
            return Err(format!("there is no time to fly: {limit} allows no flight after the beginning of the plan"));
        }
        let ends = [(Some(problem.start), "start"), (problem.base, "base")];
        for (position, name) in ends.into_iter().filter_map(|(position, name)| Some((position?, name))) {
            // The vehicle is at its start now; at the base it has to be once, at the latest at the end.
            let (altitude_m, until_s) = match name {
                "base" => (problem.vehicle.cruise_altitude_m, limit_s),
                _ => (problem.start_altitude_m, problem.start_s),
            };
            let at = (position, altitude_m);
            let trouble = if problem.travel.is_none() { travel.place_trouble(at, until_s)? } else { None };
            if let Some(trouble) = trouble {
                return Err(format!("the {name} cannot be used: {trouble}"));
            }
        }
        let index = |name: &String| problem.targets.iter().position(|target| target.name == *name);
        let mut earlier = vec![Vec::new(); problem.targets.len()];
        for (before, after) in &problem.precedence {
            if let (Some(before), Some(after)) = (index(before), index(after).and_then(|after| earlier.get_mut(after)))
            {
                after.push(before);
            }
        }
        let windows = begin_windows(problem, limit_s);
        Ok(Schedule { problem, travel, windows, earlier, costs: Costs::new(problem), limit_s, limit })
    }

    /// Judges `order` from its beginning.
    ///
    /// # Errors
    /// The reason for which the order cannot be flown.
    pub(crate) fn judge(&mut self, order: &[Choice], budget: &mut dyn Budget) -> Result<Judged, Infeasibility> {
        self.judge_after(&[], order, budget)
    }

    /// Like [`Schedule::judge`], if the first visits of `order` are known to happen as in `known`.
    ///
    /// # Errors
    /// The reason for which the order cannot be flown.
    pub(crate) fn judge_after(
        &mut self,
        known: &[Timed],
        order: &[Choice],
        budget: &mut dyn Budget,
    ) -> Result<Judged, Infeasibility> {
        self.judge_visits((known, order), false, budget)
    }

    /// Like [`Schedule::judge_after`], for the first visits of a plan: if there is no way to the base in time at the end of the last one,
    /// the flight ends there, because later visits may have a way.
    ///
    /// # Errors
    /// The reason for which the order cannot be flown.
    pub(crate) fn judge_part(
        &mut self,
        known: &[Timed],
        order: &[Choice],
        budget: &mut dyn Budget,
    ) -> Result<Judged, Infeasibility> {
        self.judge_visits((known, order), true, budget)
    }

    fn judge_visits(
        &mut self,
        (known, order): (&[Timed], &[Choice]),
        is_part: bool,
        budget: &mut dyn Budget,
    ) -> Result<Judged, Infeasibility> {
        self.check_order(order)?;
        let same = known.len().min(order.len());
        let mut visits = Vec::with_capacity(order.len());
        visits.extend(known.iter().take(same).copied());
        let (mut node, mut time_s) = (PointKey::Start, self.problem.start_s);
        let last = same.checked_sub(1).and_then(|last| Some((order.get(last)?, known.get(last)?)));
        if let Some((choice, timed)) = last {
            (node, time_s) = (PointKey::Exit(choice.target, choice.manoeuvre), timed.end_s);
        }
        for choice in order.iter().skip(same) {
            budget.charge(UNITS_PER_LEG + self.travel.take_work());
            let visit = self.visit(node, time_s, *choice)?;
            (node, time_s) = (PointKey::Exit(choice.target, choice.manoeuvre), visit.end_s);
            visits.push(visit);
        }
        budget.charge(UNITS_PER_LEG + self.travel.take_work());
        let end_s = match self.home_at_s(node, time_s) {
            Err(Infeasibility::Impossible(_)) if is_part => time_s,
            Ok(home_s) if is_part && self.is_late(home_s) => time_s,
            home => home?,
        };
        if end_s > self.limit_s + SAME_S {
            return Err(Infeasibility::TooLate { over_s: end_s - self.limit_s });
        }
        let benefits: f64 = visits.iter().map(|visit| visit.worth).sum();
        let score = benefits - self.costs.of_flight(end_s - self.problem.start_s);
        Ok(Judged { visits, end_s, score })
    }

    /// Returns a flight without visits: home, if the vehicle is elsewhere. If travel times are given, or the vehicle is at the base, there
    /// is nothing to fly.
    ///
    /// # Errors
    /// No way leads home, or the flight would end too late.
    pub(crate) fn idle(&mut self) -> Result<Judged, Infeasibility> {
        let start_s = self.problem.start_s;
        let is_at_base = self.problem.base.is_none_or(|base| geodesy::distance_m(self.problem.start, base) <= 1.0);
        let end_s = match self.problem.travel.is_some() || is_at_base {
            true => start_s,
            false => self.home_at_s(PointKey::Start, start_s)?,
        };
        if end_s > self.limit_s + SAME_S {
            return Err(Infeasibility::TooLate { over_s: end_s - self.limit_s });
        }
        Ok(Judged { visits: Vec::new(), end_s, score: -self.costs.of_flight(end_s - start_s) })
    }

    /// Returns a message that states why the problem has no plan, from the result of [`Schedule::idle`].
    pub(crate) fn no_plan(&self, idle: &Infeasibility) -> String {
        match idle {
            Infeasibility::TooLate { over_s } => format!(
                "there is no plan: the flight back to the base alone, without a visit, ends {over_s:.0} s after what {} allows",
                self.limit
            ),
            Infeasibility::Impossible(why) => format!("there is no plan: {why}"),
            Infeasibility::Closed { target } => format!("there is no plan: {}", self.closed_window(*target)),
            Infeasibility::Order => "there is no plan: the order of the targets cannot be kept".to_string(),
        }
    }

    /// Returns the times of the visit `choice` by a vehicle that is ready to leave `node` at `ready_s`.
    pub(crate) fn visit(&mut self, node: PointKey, ready_s: f64, choice: Choice) -> Result<Timed, Infeasibility> {
        let entry = PointKey::Entry(choice.target, choice.manoeuvre);
        let Ok(Times { depart_s, arrive_s }) = self.travel.times(node, entry, ready_s) else {
            return Err(Infeasibility::Impossible("no way leads there".to_string()));
        };
        let begin_s = self.begin_s(choice, arrive_s.max(choice.not_before_s))?;
        let target = self.problem.targets.get(choice.target);
        let manoeuvre = target.and_then(|target| target.manoeuvres.get(choice.manoeuvre));
        let (Some(target), Some(manoeuvre)) = (target, manoeuvre) else {
            return Err(Infeasibility::Impossible("there is no such manoeuvre".to_string()));
        };
        let end_s = begin_s + manoeuvre.duration_s;
        if end_s > self.limit_s + SAME_S {
            return Err(Infeasibility::TooLate { over_s: end_s - self.limit_s });
        }
        self.check_lines(choice, begin_s, end_s)?;
        let worth = target.gain(manoeuvre.quality.product() * target.timing_at(begin_s));
        Ok(Timed { depart_s, arrive_s, begin_s, end_s, worth })
    }

    /// Returns the first time from `ready_s` on at which the observation may begin.
    fn begin_s(&self, choice: Choice, ready_s: f64) -> Result<f64, Infeasibility> {
        let windows = self.windows.get(choice.target).and_then(|windows| windows.get(choice.manoeuvre));
        let open = windows.into_iter().flatten().find(|window| ready_s <= window.until_s + SAME_S);
        open.map(|window| window.from_s.max(ready_s.min(window.until_s))).ok_or_else(|| self.closed(choice, ready_s))
    }

    /// Returns the reason for which an observation cannot begin from `ready_s` on: the flight ends before, or its windows have closed.
    fn closed(&self, choice: Choice, ready_s: f64) -> Infeasibility {
        let Some(target) = self.problem.targets.get(choice.target) else {
            return Infeasibility::Impossible("there is no such target".to_string());
        };
        let duration_s = target.manoeuvres.get(choice.manoeuvre).map_or(0.0, |manoeuvre| manoeuvre.duration_s);
        let later = target.windows.iter().filter(|window| ready_s <= window.until_s);
        let opens_s = later.map(|window| window.from_s.max(ready_s)).reduce(f64::min);
        let begin_s = if target.windows.is_empty() { Some(ready_s) } else { opens_s };
        match begin_s.map(|begin_s| begin_s + duration_s - self.limit_s).filter(|over_s| *over_s > 0.0) {
            Some(over_s) => Infeasibility::TooLate { over_s },
            None => Infeasibility::Closed { target: choice.target },
        }
    }

    /// Returns the phrase that the windows of a target have closed.
    pub(crate) fn closed_window(&self, target: usize) -> String {
        let name = self.problem.targets.get(target).map_or("the target", |target| &target.name);
        format!("the last time window of {name} closes before the vehicle can be there")
    }

    /// Checks that the manoeuvre's lines are allowed while they are flown.
    fn check_lines(&mut self, choice: Choice, begin_s: f64, end_s: f64) -> Result<(), Infeasibility> {
        if self.problem.zones.is_empty() && self.problem.landing_distance_m_max.is_none() {
            return Ok(());
        }
        let trouble = self.travel.lines_trouble(choice.target, choice.manoeuvre, begin_s, end_s);
        trouble.map_or(Ok(()), |trouble| Err(Infeasibility::Impossible(trouble)))
    }

    /// Returns the arrival at the base of a vehicle that can leave `node` at `ready_s`; `ready_s` if there is no base.
    pub(crate) fn home_at_s(&mut self, node: PointKey, ready_s: f64) -> Result<f64, Infeasibility> {
        if self.problem.base.is_none() {
            return Ok(ready_s);
        }
        let home = self.travel.times(node, PointKey::Base, ready_s);
        home.map(|times| times.arrive_s)
            .map_err(|_| Infeasibility::Impossible("no way leads back to the base".to_string()))
    }

    /// Checks that every target comes after those that must precede it.
    fn check_order(&self, order: &[Choice]) -> Result<(), Infeasibility> {
        if self.problem.precedence.is_empty() {
            return Ok(());
        }
        for (at, choice) in order.iter().enumerate() {
            let earlier = self.earlier.get(choice.target).into_iter().flatten();
            let seen = |target: &usize| order.iter().take(at).any(|before| before.target == *target);
            if !earlier.into_iter().all(seen) {
                return Err(Infeasibility::Order);
            }
        }
        Ok(())
    }

    /// Returns true if a flight that ends at `end_s` ends too late.
    pub(crate) fn is_late(&self, end_s: f64) -> bool {
        end_s > self.limit_s + SAME_S
    }

    /// Returns the cost of a flight that ends at `end_s`.
    pub(crate) fn flight_cost(&self, end_s: f64) -> f64 {
        self.costs.of_flight(end_s - self.problem.start_s)
    }

    /// Returns the cost of flying until `later_s` instead of `end_s`.
    pub(crate) fn delay_cost(&self, end_s: f64, later_s: f64) -> f64 {
        let start_s = self.problem.start_s;
        self.costs.of_flight(later_s - start_s) - self.costs.of_flight(end_s - start_s)
    }

    /// Returns the spans in which the observation of a target by a manoeuvre may begin.
    pub(crate) fn windows(&self, target: usize, manoeuvre: usize) -> &[TimeWindow] {
        let windows = self.windows.get(target).and_then(|windows| windows.get(manoeuvre));
        windows.map_or(&[], Vec::as_slice)
    }

    /// Returns the targets that must precede `target`.
    pub(crate) fn earlier(&self, target: usize) -> &[usize] {
        self.earlier.get(target).map_or(&[], Vec::as_slice)
    }
}

/// Cost of a flight, prepared for many evaluations; equal to [`mission_score::flight_cost`].
#[derive(Clone, Copy, Debug)]
struct Costs {
    fixed: f64,
    per_hour: f64,
    failure: FailureTerm,
}

impl Costs {
    fn new(problem: &SingleVisitProblem) -> Costs {
        Costs {
            fixed: problem.crew.iter().map(|member| member.fixed_hours * member.wage_per_hour).sum(),
            per_hour: problem.crew.iter().map(|member| member.flight_share * member.wage_per_hour).sum(),
            failure: problem.failure,
        }
    }

    fn of_flight(&self, flight_s: f64) -> f64 {
        let hours = flight_s / 3600.0;
        let failure = &self.failure;
        let loss = failure.vehicle_share * failure.vehicle_cost + failure.mission_share * failure.mission_cost;
        self.fixed + self.per_hour * hours + mission_score::failure_probability(failure, hours) * loss
    }
}

/// Returns the intervals in which each observation may begin, both ends included: the target's windows, restricted to the light that must
/// last to its end.
fn begin_windows(problem: &SingleVisitProblem, limit_s: f64) -> Vec<Vec<Vec<TimeWindow>>> {
    let of_target = |target: &apex_model::problem::SingleVisitTarget| {
        let light =
            sun::light_windows(target.light, target.position, problem.zero_unix_s, problem.start_s, limit_s + 1.0);
        let mut wanted = target.windows.clone();
        if wanted.is_empty() {
            wanted.push(TimeWindow::ALWAYS);
        }
        wanted.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
        let of_manoeuvre = |duration_s: f64| {
            let tail_s = if target.light == Light::Any { 0.0 } else { duration_s };
            let cut = wanted.iter().flat_map(|window| {
                light.iter().map(move |lit| TimeWindow {
                    from_s: window.from_s.max(lit.from_s),
                    until_s: window.until_s.min(lit.until_s - tail_s),
                })
            });
            cut.filter(|window| window.from_s <= window.until_s).collect()
        };
        target.manoeuvres.iter().map(|manoeuvre| of_manoeuvre(manoeuvre.duration_s)).collect()
    };
    problem.targets.iter().map(of_target).collect()
}
