//! Monitors against their definition: incremental detection must agree with a plain evaluation of the whole history.

mod against_definition;
mod backfill;
mod combinations;
mod limits;
mod numbers;
mod patterns;
mod relation_chains;
mod relations;
mod repeated_derivation;
mod statistics_by_definition;
mod stories;
mod thresholds;
mod traces;

use super::combination::interest::{interests, lasting_interest, threshold};
use super::combination::monitors::*;
use super::episodes::threshold_episode;
use super::memory::histories::{record_event, record_sample};
use super::memory::retention::prepare;
use super::part::{ConditionFaults, PartContext, Truth};
use super::stimulus::Stimulus;
use crate::state::clause::MonitorId;
use crate::state::episode_index::{EpisodeIndex, LeafId, Taken, ThresholdEpisode};
use crate::state::monitors::monitor::{Keep, Monitor, PartKind, Verdict, Window};
use crate::state::variable_index::VariableIndex;
use crate::test_support::TestView;
use apex_model::condition::{
    Condition, ConditionKind, Constraint, EpisodeCondition, MeasurementCondition, Quality, Relation, Timing,
    VariablePattern,
};
use apex_model::event::StateVariable;
use apex_model::expression::{Expr, ExprKind};
use apex_model::limits::MONITOR_RESULTS_MAX;
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Duration;
use apex_model::time::Time;
use apex_model::value::Value;
use std::sync::Arc;

/// Returns the expression of a constant.
fn constant(value: Value) -> Expr {
    Expr { kind: ExprKind::Constant(value), place: Place::default() }
}

fn int(number: i64) -> Expr {
    constant(Value::Integer(number))
}

fn span(nanoseconds: i64) -> Expr {
    constant(Value::Duration(Duration(nanoseconds)))
}

fn variable(name: &str) -> Expr {
    Expr { kind: ExprKind::Variable { name: Symbol::new(name), must_be_bound: false }, place: Place::default() }
}

fn call(function: &str, arguments: Vec<Expr>) -> Expr {
    Expr { kind: ExprKind::Call { function: Symbol::new(function), arguments }, place: Place::default() }
}

fn compare(relation: Relation, right: Expr) -> Constraint {
    Constraint::Compare { relation, right, tolerance: None }
}

fn of(attribute: &str, object: Pattern) -> VariablePattern {
    VariablePattern { attribute: Symbol::new(attribute), object }
}

fn uav(attribute: &str) -> VariablePattern {
    of(attribute, Pattern::Literal(Value::symbol("uav")))
}

fn measurement(variable: VariablePattern, value: Vec<Constraint>) -> MeasurementCondition {
    MeasurementCondition { variable, value, object: vec![], timestamp: vec![], estimation: None }
}

fn episode(
    variable: VariablePattern,
    value: Vec<Constraint>,
    gap: Option<i64>,
    duration: Vec<Constraint>,
) -> EpisodeCondition {
    EpisodeCondition {
        variable,
        quality: gap.map_or(Quality::NoConstraints, |gap| Quality::MaximumGap(span(gap))),
        any: false,
        value,
        first_value: vec![],
        last_value: vec![],
        object: vec![],
        timing: Timing { duration, ..Timing::default() },
        stats: vec![],
        trend: vec![],
    }
}

fn condition(kind: ConditionKind) -> Condition {
    Condition { tag: None, kind, place: Place::default() }
}

fn tagged(tag: &str, kind: ConditionKind) -> Condition {
    Condition { tag: Some(Symbol::new(tag)), kind, place: Place::default() }
}

fn event(parts: Vec<Pattern>) -> ConditionKind {
    ConditionKind::Event { pattern: Pattern::List(parts).into(), timing: Timing::default().into() }
}

fn word(name: &str) -> Pattern {
    Pattern::Literal(Value::symbol(name))
}

fn free(name: &str) -> Pattern {
    Pattern::Variable(Symbol::new(name))
}

/// A monitor with its environment: time, histories, arrival numbers. If an episode index can watch the monitor, it does; the twin receives
/// every sample directly, and both must be in the same state at every query.
struct World {
    view: TestView,
    monitor: Monitor,
    told: Monitor,
    bank: Option<EpisodeIndex>,
    sequence: u64,
}

const HERE: LeafId = LeafId { monitor: MonitorId(7), leaf: 0 };

impl World {
    fn new(condition: &Condition) -> World {
        World::in_view(condition, TestView::default())
    }

    fn in_view(condition: &Condition, view: TestView) -> World {
        let monitor = create(condition, Window::from(view.now), &view).unwrap();
        let mut world = World { view, told: monitor.clone(), monitor, bank: None, sequence: 0 };
        world.lie_down();
        world
    }

    /// Replaces the monitor by one for another condition.
    fn watch(&mut self, condition: &Condition, window: Window) {
        self.monitor = create(condition, window, &self.view).unwrap();
        (self.told, self.bank) = (self.monitor.clone(), None);
        self.lie_down();
    }

    /// Moves the monitor into an episode index, if its condition allows that. The index already holds another monitor, which
    /// has received no samples.
    fn lie_down(&mut self) {
        let Some((wanted, run)) = threshold_episode::bankable(&self.monitor, &self.view) else { return };
        let mut bank = EpisodeIndex::new(wanted.dimension);
        let other = ThresholdEpisode { gap_max: Duration(1), duration_min: Duration(1_000), ..wanted };
        assert!(bank.insert(LeafId::whole(MonitorId(3)), &other, None) && bank.insert(HERE, &wanted, run));
        self.bank = Some(bank);
        threshold_episode::lie_down(&mut self.monitor);
    }

    fn stand_up(&mut self) {
        if let Some(run) = self.bank.take().and_then(|mut bank| bank.take(HERE)) {
            threshold_episode::stand_up(&mut self.monitor, run);
        }
        let plain = threshold_episode::variable(&self.monitor).is_some();
        assert!(
            !plain || self.monitor.root == self.told.root,
            "{:#?}\nwas given {:#?}",
            self.monitor.root,
            self.told.root
        );
    }

    /// Records a sample of `(attribute object)` and passes it to the monitor and its twin.
    fn sample(&mut self, attribute: &str, object: &str, value: Value, at: i64) {
        self.view.now = self.view.now.max(Time(at));
        self.sequence += 1;
        let variable = StateVariable::new(Symbol::new(attribute), Value::symbol(object));
        let index = VariableIndex::new(&self.view.library);
        let recording = record_sample(&mut self.view.histories, &index, variable, value, Time(at), self.sequence);
        let Some(stimulus) = recording.stimulus else { return };
        notice(&mut self.told, &stimulus, &self.view);
        let Stimulus::Sample { variable, value, at, newest, .. } = &stimulus else { return };
        let watched = threshold_episode::variable(&self.monitor) == Some(variable);
        let Some(bank) = self.bank.as_mut().filter(|_| watched) else {
            return notice(&mut self.monitor, &stimulus, &self.view);
        };
        match bank.takes(*at, value).filter(|_| *newest) {
            Some(number) => {
                let (mut told, mut taken) = (Vec::new(), Taken::new());
                bank.sample(*at, number, &mut told);
                bank.take_decided(&told, &mut taken);
                if let Some((_, run)) = taken.into_iter().find(|(id, _)| *id == HERE) {
                    threshold_episode::stand_up(&mut self.monitor, run);
                    self.bank = None;
                }
            }
            None => {
                let run = bank.take(HERE).flatten();
                self.bank = None;
                threshold_episode::stand_up(&mut self.monitor, run);
                notice(&mut self.monitor, &stimulus, &self.view);
                self.lie_down();
            }
        }
    }

    fn event(&mut self, form: Value, at: i64) {
        self.view.now = self.view.now.max(Time(at));
        self.sequence += 1;
        let (stimulus, _) = record_event(&mut self.view.histories, form, Time(at), self.sequence);
        notice(&mut self.monitor, &stimulus, &self.view);
        notice(&mut self.told, &stimulus, &self.view);
    }

    fn ask(&mut self, now: i64) -> Verdict {
        self.view.now = Time(now);
        self.stand_up();
        let verdict = verdict(&mut self.monitor, &self.view);
        if !matches!(verdict, Verdict::Satisfied(_)) {
            self.lie_down();
        }
        verdict
    }

    /// Returns the wake instant of the monitor or of the index: at that instant the condition may change without a sample.
    fn wake(&self) -> Option<Time> {
        match &self.bank {
            Some(bank) => bank.due().map(|(at, _)| at),
            None => next_wake(&self.monitor).map(|(at, _)| at),
        }
    }

    /// Returns interval and instant of recognition if the monitor is satisfied at `now`.
    fn answer(&mut self, now: i64) -> Option<(i64, i64, i64)> {
        match self.ask(now) {
            Verdict::Satisfied(result) => Some((result.interval.0.0, result.interval.1.0, result.recognised_at.0)),
            Verdict::NotSatisfied | Verdict::Unknown => None,
        }
    }
}

/// Returns a view in which samples of `attribute` may arrive `lateness` nanoseconds late.
fn late_view(attribute: &str, lateness: i64) -> TestView {
    let mut view = TestView::default();
    let declaration = apex_model::library::StateVariableDeclaration {
        unit: None,
        dimension: apex_model::quantity::Dimension::NONE,
        value_type: None,
        lateness: Some(Value::Duration(Duration(lateness))),
        rate_per_s: None,
        place: Place::default(),
    };
    view.library.state_variables.insert(Symbol::new(attribute), declaration);
    prepare(&mut view.histories, &view.library, None);
    view
}

fn list(items: &[Value]) -> Value {
    Value::list(items.iter().cloned())
}
