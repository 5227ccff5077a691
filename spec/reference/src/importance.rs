//! Ranks and priorities.

use crate::agent::Agent;
use crate::program::{Kind, Priority, SECOND, Time};
use crate::task::{Level, Origin, State, Task};
use crate::value::Value;

/// Workload of the agent.
const WORKLOAD: f64 = 5.0;

impl Agent<'_> {
    /// Returns the greatest value of the task's priority clauses and those of its uninterrupted ancestors; 0 if there are none.
    pub(crate) fn priority(&self, id: usize, at: Time) -> f64 {
        let mut greatest: Option<f64> = None;
        let mut next = Some(id);
        while let Some(each) = next {
            if each == id || self.tasks[each].state != State::Interrupted {
                greatest = self.own_priority(each, at).into_iter().chain(greatest).reduce(f64::max);
            }
            next = self.tasks[each].parent;
        }
        greatest.unwrap_or(0.0)
    }

    fn own_priority(&self, id: usize, at: Time) -> Option<f64> {
        let step = self.own_step(id)?;
        let values = step.priority.iter().filter_map(|clause| match clause {
            Priority::Number(expr) => match self.evaluate(expr, id, Level::Step) {
                Ok(Value::Number(number)) => Some(number),
                _ => None,
            },
            Priority::Urgency(urgency, importance) => {
                let urgency = urgency_at(*urgency, self.tasks[id].first_created, at);
                Some(combined(urgency, *importance))
            }
        });
        let greatest = values.reduce(f64::max)?;
        let recovery = step.repetition.as_ref().and_then(|clause| clause.recovery).zip(self.tasks[id].ended_before);
        let recovered = match recovery {
            Some((span, ended)) if span > 0 => (seconds(at - ended) / seconds(span)).clamp(0.0, 1.0),
            _ => 1.0,
        };
        Some(recovered * greatest)
    }

    /// Returns the interrupt cost of an ongoing task, at least zero.
    pub(crate) fn interrupt_cost(&self, id: usize) -> f64 {
        self.tasks[id].choice.as_ref().map_or(0.1, |choice| choice.interrupt_cost).max(0.0)
    }

    pub(crate) fn rank(&self, id: usize) -> Option<f64> {
        let step = self.own_step(id)?;
        if let Some(expr) = &step.rank {
            return match self.evaluate(expr, id, Level::Step) {
                Ok(Value::Number(number)) => Some(number),
                _ => None,
            };
        }
        let Origin::Step(procedure, number) = self.tasks[id].origin else { return None };
        let ranked = matches!(self.program.procedures[procedure].kind, Kind::Ranked | Kind::SoftSequential);
        ranked.then_some(number as f64 + 1.0)
    }

    /// Returns the task and its ancestors, from the root down.
    pub(crate) fn line(&self, id: usize) -> Vec<usize> {
        let mut line = self.tasks[id].parent.map(|parent| self.line(parent)).unwrap_or_default();
        line.push(id);
        line
    }

    pub(crate) fn is_below(&self, low: usize, high: usize) -> bool {
        let mut above = std::iter::successors(self.tasks[low].parent, |id| self.tasks[*id].parent);
        above.any(|id| id == high)
    }

    pub(crate) fn are_related(&self, a: usize, b: usize) -> bool {
        a == b || self.is_below(a, b) || self.is_below(b, a)
    }

    /// Returns the ranks of the two sibling ancestors, if both have a rank and the ranks differ.
    pub(crate) fn ranks(&self, a: usize, b: usize) -> Option<(f64, f64)> {
        let (first, second) = (self.line(a), self.line(b));
        let (first, second) = first.into_iter().zip(second).find(|(a, b)| a != b)?;
        Some((self.rank(first)?, self.rank(second)?)).filter(|(a, b)| a != b)
    }

    /// Returns the instant at which one priority overtakes another by time alone, including an interrupt cost. Momentary equality on the
    /// way does not count as overtaking. The instant is searched at many places between now and a distant instant, and then by halving,
    /// because priorities rise and eventually stop rising.
    pub(crate) fn priorities_cross(&self) -> Option<Time> {
        const PLACES: i64 = 64;
        let competes = |task: &Task| !matches!(task.state, State::Pending | State::Terminated);
        let competitors = self.ids(|task| competes(task) && !task.needs().is_empty());
        let until = self.rise_ends().into_iter().filter(|at| *at > self.now).max()?;
        let holders = competitors.iter().filter(|id| self.tasks[**id].state == State::Ongoing);
        let mut costs: Vec<f64> = holders.map(|id| self.interrupt_cost(*id)).collect();
        costs.push(0.0);
        let place = |number: i64| self.now + (until - self.now) / PLACES * number;
        let places: Vec<Time> = (0..PLACES).map(place).chain([until]).collect();
        let all: Vec<Vec<f64>> =
            places.iter().map(|at| competitors.iter().map(|id| self.priority(*id, *at)).collect()).collect();
        let beats = |own: f64, other: f64| costs.iter().map(|cost| own > other + cost).collect::<Vec<bool>>();
        let more = |then: &[bool], now: &[bool]| then.iter().zip(now).any(|(then, now)| *then && !now);
        let mut first: Option<Time> = None;
        for (a, b) in (0..competitors.len()).flat_map(|a| (0..competitors.len()).map(move |b| (a, b))) {
            let now = beats(all[0][a], all[0][b]);
            let ahead = |at: &usize| more(&beats(all[*at][a], all[*at][b]), &now);
            let Some(changed) = (1..places.len()).find(ahead) else { continue };
            let (mut low, mut high) = (places[changed - 1], places[changed]);
            while high - low > 1 {
                let middle = low + (high - low) / 2;
                let (own, other) = (self.priority(competitors[a], middle), self.priority(competitors[b], middle));
                if more(&beats(own, other), &now) { high = middle } else { low = middle }
            }
            first = Some(first.map_or(high, |before| before.min(high)));
        }
        first
    }

    /// Returns the instants at which priorities stop rising.
    fn rise_ends(&self) -> Vec<Time> {
        let mut ends = Vec::new();
        for (id, task) in self.living() {
            let Some(step) = self.own_step(id) else { continue };
            for clause in &step.priority {
                if let Priority::Urgency(urgency, _) = clause {
                    ends.push(deadline(*urgency, task.first_created));
                }
            }
            let recovery = step.repetition.as_ref().and_then(|clause| clause.recovery);
            if let (Some(span), Some(ended), false) = (recovery, task.ended_before, step.priority.is_empty()) {
                ends.push(ended + span);
            }
        }
        ends
    }
}

fn seconds(span: i64) -> f64 {
    span as f64 / SECOND as f64
}

fn deadline(urgency: f64, created_at: Time) -> Time {
    created_at + ((9.0 - urgency).exp2() * SECOND as f64).round() as i64
}

/// Returns the urgency at an instant, which rises as the deadline nears.
fn urgency_at(urgency: f64, created_at: Time, at: Time) -> f64 {
    let left = seconds(deadline(urgency, created_at) - at);
    if left <= 0.5 { 10.0 } else { (9.0 - left.log2()).clamp(0.0, 10.0) }
}

fn combined(urgency: f64, importance: f64) -> f64 {
    (importance * WORKLOAD * (1.0 - 1.0 / (1.0 + urgency))
        + urgency * (10.0 - WORKLOAD) * (1.0 - 1.0 / (1.0 + importance)))
        / 9.0
}
