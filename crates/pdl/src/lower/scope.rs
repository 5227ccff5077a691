//! Variables of one procedure, primitive or function: their binders, uses and visibility.
//!
//! All clauses of a procedure see its index variables, `=>` results and step tags; only the step itself sees the variables that its
//! waitfor, select or forall binds.

use super::{Lowering, slips};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::fix::Fix;
use crate::lookup::Lookup;
use crate::suggest::{is_certain, near, renames_marked};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

/// Names in force.
#[derive(Default)]
pub(crate) struct Scope {
    /// Step tags of the procedure.
    pub(crate) tags: Lookup<Symbol, Span>,
    /// Tags that no step has, but that some condition names; each is reported once.
    pub(crate) unknown_tags: BTreeSet<Symbol>,
    /// The steps' tags in written order.
    pub(crate) tag_order: Vec<Symbol>,
    /// Number of occurrences of each variable in the procedure.
    pub(crate) times_named: Lookup<Symbol, usize>,
    /// Words of the index.
    pub(crate) index_words: BTreeMap<Symbol, Span>,
    /// Variables that `=>` binds, with the last step that does.
    pub(crate) results: BTreeMap<Symbol, usize>,
    /// The step being lowered; `None` at procedure level.
    pub(crate) step: Option<usize>,
    /// Parameters and `let` variables, innermost last; a name written `?x` keeps its question mark.
    pub(crate) locals: Vec<Symbol>,
    /// True if patterns bind variables of the surrounding task: false inside a function or an indexical.
    pub(crate) has_variables: bool,
    /// True while a condition is lowered.
    pub(crate) in_condition: bool,
    /// Words of goals, which may be variables without their question mark.
    pub(crate) words: Vec<(Symbol, Option<usize>, Span)>,
    /// Number of occurrences of each variable in the text, with the first place.
    written: Lookup<Symbol, (usize, Span)>,
    binders: Lookup<Symbol, Binders>,
    uses: Vec<(Symbol, Option<usize>, Span)>,
}

/// Binders of a variable.
#[derive(Default)]
struct Binders {
    /// The first binder that is visible in the whole procedure.
    everywhere: Option<Span>,
    /// For each step with a binder that only this step sees, the first one, in the order of the steps.
    steps: Vec<(usize, Span)>,
}

impl Binders {
    fn add(&mut self, step: Option<usize>, span: Span) {
        let Some(step) = step else {
            self.everywhere.get_or_insert(span);
            return;
        };
        // Steps are lowered in order, so the step is nearly always the last one.
        if let Err(place) = self.steps.binary_search_by_key(&step, |(step, _)| *step) {
            self.steps.insert(place, (step, span));
        }
    }

    fn reach(&self, step: Option<usize>) -> bool {
        let in_step = |step: usize| self.steps.binary_search_by_key(&step, |(step, _)| *step).is_ok();
        self.everywhere.is_some() || step.is_some_and(in_step)
    }

    fn first(&self) -> Option<Span> {
        self.everywhere.or(self.steps.first().map(|(_, span)| *span))
    }
}

impl Scope {
    /// Returns the scope of a procedure or primitive.
    pub(crate) fn of_tasks() -> Scope {
        Scope { has_variables: true, ..Scope::default() }
    }

    /// Returns true if `name` is a parameter or `let` variable here.
    pub(crate) fn is_local(&self, name: &Symbol) -> bool {
        self.locals.iter().rev().any(|local| local == name)
    }

    /// Notes that `name` is bound here, visible in the present step or, at procedure level, everywhere.
    pub(crate) fn bind(&mut self, name: &Symbol, span: Span) {
        let step = self.step;
        self.bind_in(name, step, span);
    }

    /// Notes that `name` is bound for the whole procedure.
    pub(crate) fn bind_everywhere(&mut self, name: &Symbol, span: Span) {
        self.bind_in(name, None, span);
    }

    fn bind_in(&mut self, name: &Symbol, step: Option<usize>, span: Span) {
        self.write(name, span);
        self.binders.or_insert(name, Binders::default()).add(step, span);
    }

    /// Returns true if the forms lowered so far bind `name` for the whole procedure.
    pub(crate) fn is_bound_everywhere(&self, name: &Symbol) -> bool {
        self.is_visible(name, None)
    }

    fn is_visible(&self, name: &Symbol, step: Option<usize>) -> bool {
        self.binders.get(name).is_some_and(|binders| binders.reach(step))
    }

    /// Records a use of `name` here; it is checked when the whole procedure is known.
    pub(crate) fn use_variable(&mut self, name: &Symbol, span: Span) {
        self.write(name, span);
        self.uses.push((name.clone(), self.step, span));
    }

    fn write(&mut self, name: &Symbol, span: Span) {
        self.written.or_insert(name, (0, span)).0 += 1;
    }

    /// Returns variables that are written once, with the place and the variable that is certainly meant, which is written elsewhere.
    fn odd_variables(&self) -> BTreeMap<Symbol, (Span, Symbol)> {
        let mut odd = BTreeMap::new();
        if self.written.len() > COMPARED_MAX {
            return odd;
        }
        let is_free = |name: &Symbol| !self.tags.contains(name);
        let written = self.written.in_order();
        for (name, (count, span)) in &written {
            if *count > 1 || !is_free(name) {
                continue;
            }
            let others = written.iter().filter(|(other, (count, _))| *count > 1 && is_free(other) && other != name);
            let found = near(name.printed(), others.map(|(other, _)| other.printed()));
            if let Some(first) = found.first().filter(|_| is_certain(name.printed(), &found))
                && !is_inflected(name.folded(), &first.name.to_lowercase())
            {
                odd.insert((*name).clone(), (*span, Symbol::new(first.name)));
            }
        }
        odd
    }

    /// Returns the place of the first binder of `name`.
    pub(crate) fn first_binder(&self, name: &Symbol) -> Option<Span> {
        self.binders.get(name).and_then(Binders::first)
    }

    /// Returns the use of `name` at `place`.
    pub(crate) fn use_at(&self, name: &Symbol, place: Place) -> Option<Span> {
        self.uses.iter().find(|(used, _, span)| used == name && span.place() == place).map(|(.., span)| *span)
    }

    /// Returns true if `name` is bound by the result of a step other than the present one.
    pub(crate) fn is_result_of_another_step(&self, name: &Symbol) -> bool {
        self.results.get(name).is_some_and(|step| Some(*step) != self.step)
    }
}

impl Lowering {
    /// Reports every use of a variable that nothing binds, and ends the scope. An incomplete scope reports nothing, because a rejected
    /// clause may bind the variable.
    pub(crate) fn finish_scope(&mut self, complete: bool) {
        let scope = std::mem::take(&mut self.scope);
        if !complete {
            return;
        }
        for (name, step, span) in &scope.words {
            if !scope.tags.contains(name) && scope.is_visible(name, *step) {
                self.suspects.push((name.clone(), *span));
            }
        }
        let odd = scope.odd_variables();
        let mut reported: BTreeSet<&Symbol> = BTreeSet::new();
        for (name, (span, meant)) in &odd {
            reported.insert(name);
            reported.insert(meant);
            let message = format!("`?{name}` occurs only here, and looks like `?{meant}`");
            let fix = Fix::safe(format!("replace `?{name}` by `?{meant}`")).replace(*span, format!("?{meant}"));
            let unbound = !scope.is_visible(meant, None)
                && scope.uses.iter().any(|(used, step, _)| used == meant && !scope.is_visible(used, *step))
                || !scope.binders.contains(name);
            let (severity, code) = if unbound {
                (Severity::Error, codes::UNBOUND_VARIABLE)
            } else {
                (Severity::Warning, codes::RESEMBLES)
            };
            self.report(Diagnostic::new(severity, code, *span, message).fix(fix));
        }
        for (name, step, span) in &scope.uses {
            if scope.is_visible(name, *step) || !reported.insert(name) {
                continue;
            }
            if let Some(word) = scope.index_words.get(name) {
                self.report(slips::variable_without_mark(name, *word, *span));
                continue;
            }
            let message = format!("nothing binds `?{name}`");
            let mut diagnostic = Diagnostic::error(codes::UNBOUND_VARIABLE, *span, message);
            if let Some(binder) = scope.binders.get(name).and_then(Binders::first) {
                diagnostic = diagnostic
                    .label(binder, "bound here, for this step only")
                    .reason("what a step's waitfor, select or forall binds is not seen by other clauses")
                    .help(format!("hand it on as the step's value: `=> ?{name}`"));
            } else {
                let binders = scope.binders.keys_in_order().into_iter();
                let visible = binders.filter(|key| scope.is_visible(key, *step)).map(Symbol::printed);
                let fixes = renames_marked(*span, name.printed(), visible, |name| format!("?{name}"));
                let reason = "a variable gets its value from the index, a `=>`, a waitfor, a select or a forall";
                diagnostic = diagnostic.reason(reason).fixes(fixes);
            }
            self.report(diagnostic);
        }
    }
}

/// Maximum number of variables of one procedure that are compared with each other.
const COMPARED_MAX: usize = 200;

/// Returns true if the names differ only in an ending, such as `?line` and `?lines`: both are then probably intended.
fn is_inflected(one: &str, other: &str) -> bool {
    let (short, long) = if one.len() < other.len() { (one, other) } else { (other, one) };
    long.strip_prefix(short).is_some_and(|rest| matches!(rest, "s" | "d" | "es" | "ed"))
}
