//! Trees of conditions (M&I)
//! What: states for each part of a condition whether it holds, its value, its limits, and since when.
//! Runs: when an operator inspects the monitors of an instant.
//! Reads: the monitor, histories, evaluation context.
//! Writes: nothing.
//! Bound: linear in the condition and in the objects it follows.
//! PDL: all conditions.
//! Paper: section V, explanation of behaviour.

use crate::monitoring::combination::logic;
use crate::monitoring::combination::unmet::{newest, state, text};
use crate::monitoring::part::Truth;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::monitors::monitor::{Part, PartKind, Test};
use apex_forms::print::Style::Brief;
use apex_model::condition::{Constraint, Relation};
use apex_model::event::StateVariable;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};

/// A part of a condition with its present state. The root is the whole condition.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionNode {
    /// Kind of the part: `and`, `or`, `measurement`, `episode`, `event`, ..
    pub kind: &'static str,
    /// The part as PDL text.
    pub text: String,
    /// True if the part holds; `None` if the data do not decide.
    pub holds: Option<bool>,
    /// The state variable that the part watches, if it watches one.
    pub variable: Option<String>,
    /// The newest value of that variable, with its unit.
    pub value: Option<String>,
    /// Constraints on the value, with variables and constants resolved: `> 15deg`, `for 5s`.
    pub limits: Vec<String>,
    /// Present state as text; empty if the other members contain everything.
    pub now: String,
    /// Instant since which the part holds, or since which its present state has been known.
    pub since: Option<Time>,
    /// Instant at which the part becomes true by time alone, if nothing changes before.
    pub until: Option<Time>,
    /// Place in the source.
    pub place: Place,
    /// Its parts, in written order.
    pub parts: Vec<ConditionNode>,
}

/// Returns the tree of `part` at the instant of `query`.
pub(crate) fn tree(part: &Part, query: &mut VerdictQuery<'_>) -> ConditionNode {
    let holds = match logic::truth(part, query) {
        Truth::True => Some(true),
        Truth::False => Some(false),
        Truth::Unknown => None,
    };
    let known = state(part, query);
    let since = match holds {
        Some(true) => logic::results(part, query).first().map(|result| result.recognised_at).or(known.since),
        Some(false) | None => known.since,
    };
    let watched = watched(part);
    let newest = watched.as_ref().and_then(|(known, attribute, _)| newest(*known, attribute, query));
    let fallback = watched.as_ref().and_then(|(known, ..)| known.map(ToString::to_string));
    let (variable, value) = match newest {
        Some((variable, sample)) => (Some(variable), Some(sample.value.to_string())),
        None => (fallback, None),
    };
    ConditionNode {
        kind: kind(part),
        text: text(part),
        holds,
        variable,
        value,
        limits: watched.map(|(.., limits)| limits).unwrap_or_default(),
        now: known.now,
        since,
        until: known.until,
        place: part.place,
        parts: parts(part).iter().map(|part| tree(part, query)).collect(),
    }
}

fn kind(part: &Part) -> &'static str {
    match &part.kind {
        PartKind::Measurement(_) => "measurement",
        PartKind::Episode(_) => "episode",
        PartKind::Persisted(_) => "persisted",
        PartKind::Regression(_) => "regression",
        PartKind::Statistical(_) => "statistics",
        PartKind::Cyclic(_) => "cyclic",
        PartKind::Event(_) => "event",
        PartKind::TaskEnded(_) => "task-ended",
        PartKind::TaskState(_) => "task-state",
        PartKind::Timestamp(_) => "timestamp",
        PartKind::Delay(_) => "delay",
        PartKind::And(_) => "and",
        PartKind::Or(_) => "or",
        PartKind::InOrder(_) => "in-order",
        PartKind::Not(_) => "not",
        PartKind::Allen(leaf) => leaf.relation.word(),
        PartKind::Absent(_) => "absent",
        PartKind::Function(_) => "function",
    }
}

fn parts(part: &Part) -> &[Part] {
    match &part.kind {
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => &composite.parts,
        PartKind::Allen(leaf) => &leaf.parts,
        PartKind::Not(inner) => std::slice::from_ref(&**inner),
        PartKind::Absent(leaf) => std::slice::from_ref(&leaf.part),
        _ => &[],
    }
}

/// The state variable of a leaf (`None`: its object is unknown), its attribute, and the tests of its values as text.
type WatchedVariable<'a> = (Option<&'a StateVariable>, &'a Symbol, Vec<String>);

fn watched(part: &Part) -> Option<WatchedVariable<'_>> {
    Some(match &part.kind {
        PartKind::Measurement(leaf) => {
            (leaf.variable.as_ref(), &leaf.condition.variable.attribute, asked(&leaf.tests, &leaf.condition.value))
        }
        PartKind::Persisted(leaf) => {
            (leaf.variable.as_ref(), &leaf.condition.variable.attribute, asked(&leaf.tests, &leaf.condition.value))
        }
        PartKind::Episode(leaf) => {
            let mut limits = asked(&leaf.tests, &leaf.condition.value);
            if leaf.duration_min > Duration::ZERO {
                limits.push(format!("for {}", leaf.duration_min));
            }
            (leaf.variable.as_ref(), &leaf.condition.variable.attribute, limits)
        }
        PartKind::Statistical(leaf) => {
            let condition = &leaf.condition;
            let values = condition.value.iter().map(|each| Brief.constraint(each));
            let figures = condition.stats.iter().chain(&condition.trend);
            let figures = figures.flat_map(|(name, asked)| asked.iter().map(move |each| (name, each)));
            let figures = figures.map(|(name, each)| format!("{name} {}", Brief.constraint(each)));
            (leaf.variable.as_ref(), &condition.variable.attribute, values.chain(figures).collect())
        }
        _ => return None,
    })
}

/// Returns the value tests as text: with values for operands that are known in advance, the others as written.
fn asked(tests: &[Test], written: &[Constraint]) -> Vec<String> {
    let text = |test: &Test| match test {
        Test::Fixed { relation, right } => Some(format!("{} {right}", sign(*relation))),
        Test::General(index) => written.get(*index as usize).map(|each| Brief.constraint(each)),
    };
    tests.iter().filter_map(text).collect()
}

/// Returns the relation in PDL.
fn sign(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::Different => "/=",
        Relation::Less => "<",
        Relation::LessOrEqual => "<=",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => ">=",
    }
}
