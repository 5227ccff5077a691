//! Names that a mission has, and messages about names that it does not have.

use super::arguments::is_place_word;
use super::calls::Calls;
use super::findings::Findings;
use super::types::Types;
use crate::analysis::walk;
use crate::analysis::walk::QUERIES;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::suggest::renames;
use apex_model::expression::{Expr, ExprKind};
use apex_model::interface::{ArgumentType, NameKind};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Names that a mission has.
#[derive(Clone, Debug, Default)]
pub struct KnownNames {
    /// Names of each kind. A kind that is absent is not checked.
    pub names: BTreeMap<NameKind, BTreeSet<Symbol>>,
    /// Planners; empty if they are unknown.
    pub solvers: BTreeSet<Symbol>,
    /// First words of messages from outside, in addition to the declared ones.
    pub messages: BTreeSet<Symbol>,
    /// Time from the start of the mission to its end; `None` if it is unknown.
    pub duration: Option<Duration>,
}

impl KnownNames {
    /// Returns a message about `name`; `None` if the mission has it or names of this kind are unknown.
    fn unknown(&self, kind: NameKind, name: &Symbol, span: impl FnOnce() -> Span) -> Option<Diagnostic> {
        let known = self.names.get(&kind)?;
        if known.contains(name) || kind == NameKind::Place && is_place_word(name.folded()) {
            return None;
        }
        let span = span();
        let message = format!("the mission has no {} `{name}`", kind.word());
        let listed: Vec<&str> = known.iter().map(Symbol::printed).take(NAMES_SHOWN).collect();
        let more = if known.len() > listed.len() { ", .." } else { "" };
        let help = || match listed.as_slice() {
            [] => "it has none at all: declare one in the data of the mission".to_string(),
            _ => format!("it has {}{more}", listed.join(", ")),
        };
        let fixes = renames(span, name.printed(), known.iter().map(Symbol::printed));
        Some(Diagnostic::error(codes::UNKNOWN_NAME, span, message).fixes_or_help(fixes, help))
    }
}

/// Maximum number of agents named in one message.
const AGENTS_SHOWN: usize = 3;
/// Maximum number of names listed in one message.
const NAMES_SHOWN: usize = 12;

/// Checks names among the arguments of goals, messages and commands.
pub(super) fn arguments(known: &KnownNames, calls: &Calls<'_>, types: &Types<'_>, findings: &mut Findings<'_>) {
    for call in &calls.all {
        for (number, item) in call.items.iter().enumerate().skip(1) {
            let Some(Value::Symbol(name)) = item.value() else { continue };
            let Some(ArgumentType::Named(kind)) = types.wanted(call, number) else { continue };
            let found = known.unknown(kind, name, || call.argument_span(&mut findings.locator, number));
            if let Some(diagnostic) = found {
                findings.add(diagnostic);
            }
        }
    }
}

/// Checks the names of objects of state variables, in conditions and queries.
pub(super) fn objects(library: &Library, known: &KnownNames, findings: &mut Findings<'_>) {
    let mut uses: Vec<(NameKind, &Symbol, apex_model::source::Place)> = Vec::new();
    for procedure in &library.procedures {
        walk::conditions_of(procedure, &mut |condition| {
            let Some(variable) = walk::variable_of(condition) else { return };
            if let (Some(kind), Pattern::Literal(Value::Symbol(name))) =
                (library.objects.get(&variable.attribute), &variable.object)
            {
                uses.push((*kind, name, condition.place));
            }
        });
    }
    walk::library(library, &mut |expr| {
        if let ExprKind::Call { function, arguments } = &expr.kind
            && QUERIES.contains(&function.folded())
            && let [attribute, object, ..] = arguments.as_slice()
            && let (Some(attribute), Some(name)) = (symbol_of(attribute), symbol_of(object))
            && let Some(kind) = library.objects.get(attribute)
        {
            uses.push((*kind, name, expr.place));
        }
    });
    for (kind, name, place) in uses {
        if let Some(mut diagnostic) = known.unknown(kind, name, || findings.locator.word(place, name)) {
            if kind == NameKind::Aircraft {
                for agent in library.agents.iter().take(AGENTS_SHOWN) {
                    diagnostic =
                        diagnostic.label(findings.locator.word(agent.place, &agent.name), "an aircraft of the mission");
                }
            }
            findings.add(diagnostic);
        }
    }
}

fn symbol_of(expr: &Expr) -> Option<&Symbol> {
    match &expr.kind {
        ExprKind::Constant(Value::Symbol(name)) => Some(name),
        _ => None,
    }
}

/// Reports declared solvers that are not planners.
pub(super) fn solvers(library: &Library, known: &KnownNames, findings: &mut Findings<'_>) {
    if known.solvers.is_empty() {
        return;
    }
    for solver in library.solvers.iter().filter(|solver| !known.solvers.contains(&solver.name)) {
        let span = findings.locator.word(solver.place, &solver.name);
        let names: Vec<&str> = known.solvers.iter().map(Symbol::printed).collect();
        let message = format!("no planner is called `{}`", solver.name);
        let diagnostic = Diagnostic::new(Severity::Warning, codes::UNKNOWN_SOLVER, span, message)
            .reason("only a solver program that is given with `--solver-program` can have this name")
            .fixes_or_help(renames(span, solver.name.printed(), names.iter().copied()), || {
                format!("planners are {}", names.join(", "))
            });
        findings.add(diagnostic);
    }
}
