//! A cause with its parts: the names, values and instants of its text, and the observations on which it rests.

use apex_model::because::{Because, ConflictRule, EqualsRule, Evidence, Share, Strength};
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use serde::Serialize;

/// A cause, taken from the decision itself. Its text is in the member `because` of the same object.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct CauseDetail {
    /// The kind of cause; `docs/reference/trace.md` lists them.
    pub kind: String,
    /// Things that the text names.
    pub parts: Vec<CausePart>,
    /// Observations, in the order of the text.
    pub evidence: Vec<Observation>,
    /// The observations as text, without the cause that they prove; empty if there are none.
    pub observed: String,
}

/// A part of a cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct CausePart {
    /// Role of the part in the cause: `parent`, `resource`, `clause`.
    pub role: &'static str,
    /// The part.
    #[serde(flatten)]
    pub value: PartValue,
}

/// The value of a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum PartValue {
    /// A task.
    Task {
        /// `T3`
        task: String,
    },
    /// A goal, a resource, or a value, as PDL text.
    Form {
        /// The text.
        form: String,
    },
    /// A clause, an activity, a variable, a solver, or a rule.
    Name {
        /// The name.
        name: String,
    },
    /// A count, or the number of a command, request or question.
    Number {
        /// The number.
        number: u64,
    },
    /// A stretch of time.
    Span {
        /// Its length in seconds.
        seconds: f64,
    },
    /// Strength of a task in a conflict.
    Strength {
        /// Its priority or rank.
        priority: f64,
        /// Its interrupt cost; 0 unless it holds the resource.
        interrupt_cost: f64,
    },
    /// Granted share of a task.
    Share {
        /// The resource.
        resource: String,
        /// The amount with its unit; null means the whole amount.
        amount: Option<String>,
    },
    /// A message of a vehicle, a solver, or the executive.
    Message {
        /// The sentence.
        message: String,
    },
}

/// An observation. Instants are seconds of mission time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Observation {
    /// A sample.
    Sample {
        /// The state variable.
        variable: String,
        /// Its value with its unit.
        value: String,
        /// Instant of the measurement.
        at: f64,
    },
    /// A message.
    Event {
        /// Its form.
        form: String,
        /// Arrival.
        at: f64,
    },
    /// A change of a task's state.
    TaskState {
        /// The task, `T3`.
        task: String,
        /// The word of the state.
        word: String,
        /// Instant of the change.
        at: f64,
    },
    /// The end of a task.
    TaskEnd {
        /// The task, `T3`.
        task: String,
        /// Its number, 3 for `T3`.
        task_number: u64,
        /// Instant of the end.
        at: f64,
    },
    /// A run of samples.
    Run {
        /// The state variable.
        variable: String,
        /// The first sample's instant.
        from: f64,
        /// The last sample's instant.
        to: f64,
        /// Number of samples.
        samples: u64,
    },
    /// An instant that was waited for.
    Instant {
        /// Start of the delay, if there is one.
        from: Option<f64>,
        /// The instant.
        at: f64,
    },
    /// An expression that was evaluated.
    Function {
        /// The expression as PDL text.
        expression: String,
        /// Its value.
        value: String,
        /// Instant.
        at: f64,
    },
    /// A condition that did not become true.
    Absence {
        /// The condition as PDL text.
        condition: String,
        /// Instant up to which it was not true.
        at: f64,
    },
    /// A value between or beyond samples.
    Estimate {
        /// The state variable.
        variable: String,
        /// The estimated value.
        value: String,
        /// The estimator, by its PDL name.
        estimator: String,
        /// The instant of the estimate.
        at: f64,
    },
    /// A statistic or trend of samples.
    Aggregate {
        /// The state variable.
        variable: String,
        /// The statistic, by its PDL name without the colon.
        name: String,
        /// Its value.
        value: String,
        /// Start of its interval.
        from: f64,
        /// End of its interval.
        to: f64,
        /// Number of samples.
        samples: u64,
    },
}

impl CauseDetail {
    /// Returns the detail of a decision's cause.
    pub(super) fn of(because: &Because) -> CauseDetail {
        CauseDetail {
            kind: because.cause.kind().to_string(),
            parts: super::cause_parts::parts(&because.cause),
            observed: because.evidence.iter().map(Evidence::text).collect::<Vec<_>>().join(", "),
            evidence: because.evidence.iter().map(Observation::of).collect(),
        }
    }
}

impl Observation {
    fn of(evidence: &Evidence) -> Observation {
        let seconds = |at: &Time| at.seconds();
        match evidence {
            Evidence::Sample { variable, value, at } => {
                Observation::Sample { variable: variable.to_string(), value: value.to_string(), at: seconds(at) }
            }
            Evidence::Event { form, at, .. } => Observation::Event { form: form.to_string(), at: seconds(at) },
            Evidence::TaskState { task, state, at } => {
                Observation::TaskState { task: task.to_string(), word: state.to_string(), at: seconds(at) }
            }
            Evidence::TaskEnd { task, at } => {
                Observation::TaskEnd { task: task.to_string(), task_number: task.0, at: seconds(at) }
            }
            Evidence::Run { variable, start, end, samples } => Observation::Run {
                variable: variable.to_string(),
                from: seconds(start),
                to: seconds(end),
                samples: *samples,
            },
            Evidence::Instant { since, at } => {
                Observation::Instant { from: since.as_ref().map(seconds), at: seconds(at) }
            }
            Evidence::Function { what, value, at } => {
                Observation::Function { expression: what.clone(), value: value.to_string(), at: seconds(at) }
            }
            Evidence::Absence { what, at } => Observation::Absence { condition: what.clone(), at: seconds(at) },
            Evidence::Estimate(estimate) => Observation::Estimate {
                variable: estimate.variable.to_string(),
                value: estimate.value.to_string(),
                estimator: estimate.estimator.to_string(),
                at: estimate.at.seconds(),
            },
            Evidence::Aggregate(aggregate) => Observation::Aggregate {
                variable: aggregate.variable.to_string(),
                name: aggregate.name.clone(),
                value: aggregate.value.to_string(),
                from: aggregate.interval.0.seconds(),
                to: aggregate.interval.1.seconds(),
                samples: aggregate.samples,
            },
        }
    }
}

impl From<TaskId> for PartValue {
    fn from(task: TaskId) -> PartValue {
        PartValue::Task { task: task.to_string() }
    }
}

impl From<&Value> for PartValue {
    fn from(value: &Value) -> PartValue {
        PartValue::Form { form: value.to_string() }
    }
}

impl From<u64> for PartValue {
    fn from(number: u64) -> PartValue {
        PartValue::Number { number }
    }
}

impl From<Duration> for PartValue {
    fn from(span: Duration) -> PartValue {
        PartValue::Span { seconds: span.seconds() }
    }
}

impl From<Strength> for PartValue {
    fn from(strength: Strength) -> PartValue {
        PartValue::Strength { priority: strength.priority, interrupt_cost: strength.interrupt_cost }
    }
}

impl From<&Share> for PartValue {
    fn from(share: &Share) -> PartValue {
        let amount = share.amount.as_ref().map(Value::to_string);
        PartValue::Share { resource: share.resource.to_string(), amount }
    }
}

impl From<ConflictRule> for PartValue {
    fn from(rule: ConflictRule) -> PartValue {
        let name = match rule {
            ConflictRule::Rank => "rank",
            ConflictRule::Priority => "priority",
            ConflictRule::Incumbent => "incumbent",
            ConflictRule::Begun => "begun",
            ConflictRule::WrittenOrder => "written-order",
            ConflictRule::CreationOrder => "creation-order",
            ConflictRule::Capacity => "capacity",
            ConflictRule::GoesBefore { .. } => "goes-before",
        };
        PartValue::Name { name: name.into() }
    }
}

impl From<EqualsRule> for PartValue {
    fn from(rule: EqualsRule) -> PartValue {
        let name = match rule {
            EqualsRule::MadeInFlight => "made-in-flight",
            EqualsRule::Procedure => "procedure",
            EqualsRule::FirstInLibrary => "first-in-library",
        };
        PartValue::Name { name: name.into() }
    }
}
