//! Choice of a method: the methods that a goal has now, best first, and the reason for which each other one is not taken.

use crate::expression::view::View;
use crate::monitoring::mismatch::first_mismatch;
use crate::monitoring::pattern_matching::match_pattern;
use crate::monitoring::specificity::{Specificity, specificity, why_before};
use crate::state::agent::Agent;
use crate::state::bindings::Bindings;
use crate::state::clause::Level;
use crate::state::index::IndexCandidate;
use crate::state::task::ProcedureRef;
use apex_forms::print::Style::Brief;
use apex_model::effect::Method;
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::task::TaskId;
use apex_model::value::Value;
use std::cmp::Reverse;

/// A procedure, primitive or solver that might serve a goal.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodOption {
    /// Method.
    pub method: Method,
    /// Its index, as PDL text.
    pub index: String,
    /// Position in the PDL text.
    pub place: Place,
    /// True if it matches the goal.
    pub matches: bool,
    /// Reason for its order: first, after the first, or not matching.
    pub because: String,
}

/// Returns every method whose index begins with the goal's first word or with a variable: matches first, the best of them first. Solvers
/// come last, because they are asked only when nothing else matches.
pub fn options(agent: &Agent, goal: &Value) -> Vec<MethodOption> {
    let stored = agent.index.methods.candidates(goal.head());
    let mut ways: Vec<IndexCandidate> = stored.chain(agent.generated_heads.candidates(goal.head())).collect();
    ways.sort_by_cached_key(|each| (Reverse(index(agent, *each).map(|(pattern, _)| specificity(pattern))), *each));
    let mut options = judged(agent, goal, &ways);
    let solvers: Vec<IndexCandidate> = agent.index.solvers.candidates(goal.head()).collect();
    let served = options.iter().any(|option| option.matches);
    for mut solver in judged(agent, goal, &solvers) {
        if solver.matches && served {
            solver.because = "a solver is asked only when no procedure or primitive matches".into();
        }
        options.push(solver);
    }
    options.sort_by_key(|option| !option.matches);
    options
}

fn judged(agent: &Agent, goal: &Value, candidates: &[IndexCandidate]) -> Vec<MethodOption> {
    let mut best: Option<(Specificity, IndexCandidate)> = None;
    let mut options: Vec<MethodOption> = Vec::new();
    for candidate in candidates {
        let Some((pattern, place)) = index(agent, *candidate) else { continue };
        let Some(method) = method(agent, *candidate) else { continue };
        let (matches, because) = match why_not(agent, pattern, goal, place) {
            Some(reason) => (false, reason),
            None => {
                let own = specificity(pattern);
                let because = match best {
                    None => "it is the most specific match".into(),
                    Some((first, before)) if first == own => {
                        if let Some(option) = options.iter_mut().find(|option| option.matches) {
                            option.because =
                                "no match is more specific, and it is the first of the equally specific ones".into();
                        }
                        as_specific(before, *candidate).into()
                    }
                    Some((first, _)) => why_before(first, own),
                };
                best.get_or_insert((own, *candidate));
                (true, because)
            }
        };
        options.push(MethodOption { method, index: Brief.pattern(pattern), place, matches, because });
    }
    options
}

/// Returns the reason for which `other`, which is equally specific, comes after `first`.
fn as_specific(first: IndexCandidate, other: IndexCandidate) -> &'static str {
    match (first, other) {
        (IndexCandidate::Generated(_), IndexCandidate::Procedure(_) | IndexCandidate::Primitive(_)) => {
            "it is equally specific, and a plan made in flight precedes stored procedures"
        }
        (IndexCandidate::Procedure(_), IndexCandidate::Primitive(_)) => {
            "it is equally specific, and procedures precede primitives"
        }
        _ => "it is equally specific, and comes later in the library",
    }
}

/// Returns the reason if the index does not match. An index sees no variables but its own.
fn why_not(agent: &Agent, pattern: &Pattern, goal: &Value, place: Place) -> Option<String> {
    let blank = View { agent, task: TaskId(u64::MAX), level: Level::Procedure, now: agent.now };
    match match_pattern(pattern, goal, &mut Bindings::new(), &blank, place) {
        Ok(true) => None,
        Ok(false) => {
            let found = first_mismatch(pattern, goal, &blank).map(|mismatch| format!("the goal {mismatch}"));
            Some(found.unwrap_or_else(|| "its guards or segments do not fit the goal".into()))
        }
        Err(error) => Some(error.message),
    }
}

fn index(agent: &Agent, candidate: IndexCandidate) -> Option<(&Pattern, Place)> {
    Some(match candidate {
        IndexCandidate::Procedure(number) => of_procedure(agent, ProcedureRef::Stored(number))?,
        IndexCandidate::Generated(number) => of_procedure(agent, ProcedureRef::Generated(number))?,
        IndexCandidate::Primitive(number) => {
            let primitive = agent.library.primitives.get(number as usize)?;
            (&primitive.index, primitive.place)
        }
        IndexCandidate::Solver(number) => {
            let solver = agent.library.solvers.get(number as usize)?;
            (&solver.index, solver.place)
        }
    })
}

fn of_procedure(agent: &Agent, reference: ProcedureRef) -> Option<(&Pattern, Place)> {
    agent.procedure(reference).map(|procedure| (&procedure.index, procedure.place))
}

fn method(agent: &Agent, candidate: IndexCandidate) -> Option<Method> {
    let (_, place) = index(agent, candidate)?;
    Some(match candidate {
        IndexCandidate::Procedure(_) | IndexCandidate::Generated(_) => Method::Procedure(place),
        IndexCandidate::Primitive(_) => Method::Primitive(place),
        IndexCandidate::Solver(number) => Method::Solver(agent.library.solvers.get(number as usize)?.name.clone()),
    })
}
