//! The question as answered by Apex: text, checker, a session of monitors.

use crate::print;
use apex_definition::{Bindings, Outcome, Question, Time, Value as Theirs, What};
use apex_executive::MonitorSession;
use apex_executive::state::clause::MonitorId;
use apex_executive::state::monitors::monitor::{Satisfaction, Verdict};
use apex_model::condition::Condition;
use apex_model::event::StateVariable;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::time;
use apex_model::value::Value;
use apex_pdl::{CheckOptions, Diagnostic, Severity, SourceText};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A condition that the checker has accepted.
#[derive(Clone, Debug)]
pub struct Accepted {
    library: Arc<Library>,
    condition: Condition,
}

/// Code of the checker for a condition that can never hold.
const IMPOSSIBLE: &str = "E0703";

/// Reason of a refusal by the checker.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// The checker calls the condition impossible.
    Never,
    /// The text is wrong: these messages.
    Wrong(String),
}

/// Report at an instant.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// The condition is satisfied; its first result is this one.
    Satisfied(Outcome),
    /// The condition has not been satisfied so far.
    NotSatisfied,
    /// The data do not decide the condition.
    Unknown,
}

/// Checks the text of the question.
///
/// # Errors
/// The reason of the refusal.
pub fn accepted(question: &Question) -> Result<Accepted, Refusal> {
    let source = |name: &str, text: String| SourceText { name: name.into(), text };
    let mut resolve = |_| Err("nothing is required".into());
    let options = CheckOptions { fragment: false, host: &[], resolve: &mut resolve };
    let declarations = vec![source("declarations.pdl", print::declarations(question))];
    let text = vec![source("condition.pdl", print::condition(&question.condition))];
    let read = apex_pdl::check_conditions(declarations, text, options);
    let errors: Vec<&Diagnostic> =
        read.checked.diagnostics.iter().filter(|each| each.severity == Severity::Error).collect();
    if errors.iter().any(|each| each.code == IMPOSSIBLE) {
        return Err(Refusal::Never);
    }
    let mut conditions = read.conditions;
    match conditions.pop() {
        Some(condition) if errors.is_empty() && conditions.is_empty() => {
            Ok(Accepted { library: Arc::new(read.checked.library), condition })
        }
        _ => Err(Refusal::Wrong(apex_pdl::render(&read.checked.diagnostics, &read.checked.library.sources, false))),
    }
}

/// A session that receives the arrivals up to the compared instants.
pub struct Watch<'a> {
    session: MonitorSession,
    id: MonitorId,
    question: &'a Question,
    handed: usize,
}

impl<'a> Watch<'a> {
    /// Begins to watch.
    ///
    /// # Errors
    /// A condition that cannot be watched.
    pub fn new(accepted: &Accepted, question: &'a Question) -> Result<Watch<'a>, String> {
        let mut session = MonitorSession::new(Arc::clone(&accepted.library), HostFunctions::default())?;
        let created = time::Time(question.created);
        let id = session.watch(accepted.condition.clone(), created).map_err(|trouble| trouble.message)?;
        Ok(Watch { session, id, question, handed: 0 })
    }

    /// Passes on the arrivals up to `now`, without advancing time.
    pub fn hand(&mut self, now: Time) {
        while let Some(arrival) = self.question.arrivals.get(self.handed).filter(|arrival| arrival.arrives <= now) {
            self.handed += 1;
            let at = time::Time(arrival.at);
            if arrival.at < arrival.arrives {
                // A message without a receiver advances time to the instant at which the late arrival comes.
                self.session.event(Value::list([Value::symbol("tick")]), time::Time(arrival.arrives));
            }
            match &arrival.what {
                What::Sample(attribute, object, value) => {
                    let variable = StateVariable::new(Symbol::new(attribute), Value::symbol(object));
                    let value = value.as_ref().map_or(Value::Real(f64::NAN), value_of);
                    self.session.sample(&variable, value, at);
                }
                What::Message(words) => self.session.event(Value::list(words.iter().map(value_of)), at),
                What::Moved(..) => {}
            }
        }
    }

    /// Evaluates the condition at `now`, after every earlier input.
    pub fn say(&mut self, now: Time) -> Said {
        self.hand(now);
        self.session.advance(time::Time(now));
        match self.session.verdict(self.id).map(|judgement| judgement.verdict) {
            Some(Verdict::Satisfied(satisfaction)) => Said::Satisfied(outcome(&satisfaction)),
            Some(Verdict::NotSatisfied) => Said::NotSatisfied,
            Some(Verdict::Unknown) | None => Said::Unknown,
        }
    }
}

fn outcome(satisfaction: &Satisfaction) -> Outcome {
    let mut variables = Bindings::new();
    let mut tags = BTreeMap::new();
    for (name, value) in satisfaction.bindings.iter() {
        match value {
            Value::Interval(start, end) => drop(tags.insert(name.to_string(), (start.0, end.0))),
            value => drop(variables.insert(name.to_string(), theirs_of(value))),
        }
    }
    let (start, end) = satisfaction.interval;
    Outcome { interval: (start.0, end.0), recognised_at: satisfaction.recognised_at.0, variables, tags }
}

fn value_of(value: &Theirs) -> Value {
    match value {
        Theirs::Number(number) if number.fract() == 0.0 => Value::Integer(*number as i64),
        Theirs::Number(number) => Value::Real(*number),
        Theirs::Symbol(name) => Value::symbol(name),
        Theirs::Text(text) => Value::text(text),
    }
}

fn theirs_of(value: &Value) -> Theirs {
    match value {
        Value::Integer(number) => Theirs::Number(*number as f64),
        Value::Real(number) => Theirs::Number(*number),
        Value::Symbol(name) => Theirs::symbol(name.folded()),
        other => Theirs::Text(other.to_string()),
    }
}
