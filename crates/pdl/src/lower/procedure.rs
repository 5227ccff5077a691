//! Procedures (`pdl.md`, Procedures): kind, index, clauses, steps; clauses shared with steps and primitives.

use super::step::StepSource;
use super::{Lowering, Scope, Served, Unindexed};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use crate::suggest::{nearest, renames, renames_marked};
use crate::vocabulary::{DOCUMENTATION_CLAUSES, PROCEDURE_CLAUSES, STEP_CLAUSES};
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, Hooks, Procedure, ProcedureKind, Step, Transitions};
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

const KINDS: &[&str] = &["concurrent", "conc", "sequential", "seq", "ranked", "soft-seq"];

impl Lowering {
    /// Lowers `(procedure [KIND] (index PATTERN) CLAUSE.. STEP..)`.
    pub(crate) fn procedure(&mut self, datum: &Datum) -> Option<Procedure> {
        if self.report_proctype(datum) {
            return None;
        }
        let (kind, items) = self.procedure_kind(datum)?;
        let (index, mut clauses) = self.split_index(datum, items, PROCEDURE_CLAUSES, "procedure")?;
        clauses.retain(|clause| !is_documentation(clause));
        let has_kind = datum.tail().first().is_some_and(|word| word.keyword().is_some());
        self.scope = Scope::of_tasks();
        if self.report_misplaced(datum) {
            self.index_pattern(index)?;
            return None;
        }
        let (steps, clauses, mut complete) = self.sort_clauses(&clauses, has_kind);
        self.scope.tags = steps.iter().map(|step| (step.tag.clone(), step.tag_span)).collect();
        for step in &steps {
            self.scope.bind_everywhere(&step.tag, step.tag_span);
        }
        self.scope.tag_order = steps.iter().map(|step| step.tag.clone()).collect();
        variables_in(datum, &mut |name| *self.scope.times_named.or_insert(name, 0) += 1);
        self.collect_results(&steps);
        let index = self.index_pattern(index)?;
        complete &= self.check_clauses(&clauses, PROCEDURE_CLAUSES, "a procedure");
        let mut procedure = Procedure {
            kind,
            index,
            profile: Vec::new(),
            log: Vec::new(),
            expected_duration: None,
            interrupt_cost: None,
            transitions: Transitions::default(),
            hooks: Hooks::default(),
            // One more, because a step that ends the procedure may be added.
            steps: Vec::with_capacity(steps.len() + 1),
            bundle: self.bundle.clone(),
            place: datum.span.place(),
        };
        for clause in &clauses {
            complete &= self.procedure_clause(clause, &mut procedure).is_some();
        }
        for (number, source) in steps.iter().enumerate() {
            match self.step(number, source) {
                Some(step) => procedure.steps.push(step),
                None => complete = false,
            }
        }
        self.finish_scope(complete);
        complete.then_some(())?;
        self.finish_kind(datum, &mut procedure);
        Some(procedure)
    }

    /// Reports `(proctype ranked)`: the kind of a procedure is its first word. Returns true if it did.
    fn report_proctype(&mut self, datum: &Datum) -> bool {
        let Some(clause) = datum.tail().iter().find(|item| item.head_name() == "proctype") else { return false };
        let kind = match clause.tail() {
            [kind] => kind.as_symbol().map(|name| name.folded().trim_start_matches(':').to_string()),
            _ => None,
        };
        let diagnostic =
            Diagnostic::error(codes::UNKNOWN_CLAUSE, clause.span, "the kind of a procedure must come first");
        let diagnostic = match kind.filter(|name| KINDS.contains(&&**name)) {
            Some(name) => {
                let fix = Fix::safe(format!("write `(procedure :{name} ..)`")).replace(clause.span, "");
                diagnostic.fix(fix.insert_after(datum.head_span(), format!(" :{name}")))
            }
            None => diagnostic
                .help("write `(procedure :sequential ..)`; kinds are :concurrent :sequential :ranked :soft-seq"),
        };
        self.report(diagnostic);
        true
    }

    fn procedure_kind<'d>(&mut self, datum: &'d Datum) -> Option<(ProcedureKind, &'d [Datum])> {
        let items = datum.tail();
        let Some((word, rest)) = items.split_first() else {
            let shape = "(procedure [:sequential] (index PATTERN) CLAUSE.. (step ..)..)";
            return self.missing_part(datum.span, "this procedure is empty", shape);
        };
        if let Some(name) = word.as_symbol().map(Symbol::folded).filter(|name| KINDS.contains(name)) {
            let message = format!("the kind `{name}` lacks its colon");
            let diagnostic = Diagnostic::error(codes::UNKNOWN_OPTION, word.span, message);
            return self.refuse(diagnostic.fix(super::slips::colon(name, word.span)));
        }
        let kind = match word.keyword() {
            None => return Some((ProcedureKind::Concurrent, items)),
            Some("concurrent" | "conc") => ProcedureKind::Concurrent,
            Some("sequential" | "seq") => ProcedureKind::Sequential,
            Some("ranked") => ProcedureKind::Ranked,
            Some("soft-seq" | "soft-sequential") => ProcedureKind::SoftSequential,
            Some(other) => {
                let message = format!("procedures are not of kind `:{other}`");
                let diagnostic = Diagnostic::error(codes::UNKNOWN_OPTION, word.span, message);
                let mark = |name: &str| format!(":{name}");
                let fixes = renames_marked(word.span, other, KINDS.iter().copied(), mark);
                let help = || "kinds are :concurrent :sequential :ranked :soft-seq".to_string();
                return self.refuse(diagnostic.fixes_or_help(fixes, help));
            }
        };
        Some((kind, rest))
    }

    /// Finds the index: an `(index ..)` clause, otherwise the first list that is not a clause.
    pub(crate) fn split_index<'d>(
        &mut self,
        datum: &Datum,
        items: &'d [Datum],
        known: &[&str],
        what: &str,
    ) -> Option<(&'d Datum, Vec<&'d Datum>)> {
        if let Some(clause) = items.iter().find(|item| item.head_name() == "index") {
            let pattern = self.only("index", clause.tail(), clause.span)?;
            let again = items.iter().find(|item| item.head_name() == "index" && item.span != clause.span);
            if let Some(again) = again {
                self.report_clause_twice(clause, again);
                return None;
            }
            return Some((pattern, items.iter().filter(|item| item.span != clause.span).collect()));
        }
        let bare = items.first().filter(|item| item.as_list().is_some() && !known.contains(&item.head_name()));
        match bare {
            Some(pattern) if !is_misspelt_index(pattern) => Some((pattern, items.iter().skip(1).collect())),
            _ => {
                let message = format!("this {what} does not say which goals it serves");
                let misspelt = items.iter().find(|item| is_misspelt_index(item));
                let span = misspelt.map_or(datum.head_span(), Datum::head_span);
                let name = misspelt.map_or("", |item| item.head_name());
                let diagnostic = Diagnostic::error(codes::MISSING_INDEX, span, message);
                let fixes = renames(span, name, ["index"]);
                if fixes.is_empty() {
                    self.unindexed.push(Unindexed::new(datum, items));
                }
                self.refuse(diagnostic.fixes_or_help(fixes, || "add `(index (verb object ..))`".to_string()))
            }
        }
    }

    /// Reports `=> ?x` in an index: it belongs to the step that pursues the goal, and an index with it matches no goal. Returns true if it
    /// did.
    fn report_result_in_index(&mut self, datum: &Datum) -> bool {
        let items = datum.as_list().unwrap_or_default();
        let Some(mark) = items.iter().position(|item| item.is("=>")).filter(|mark| *mark > 0) else { return false };
        let before = items.get(mark - 1).map_or(datum.span, |item| item.span);
        let last = items.last().map_or(before, |item| item.span);
        let written = Span { start: before.end, end: last.end, ..last };
        let diagnostic = Diagnostic::error(codes::MALFORMED, Span { start: items.get(mark).map_or(before.end, |item| item.span.start), ..written }, "an index has no result")
            .reason("`=>` belongs to the step that pursues the goal; a procedure gives its value by `(terminate >> VALUE)`, a primitive by `(return VALUE)`")
            .fix(Fix::safe("remove it from the index").replace(written, ""));
        self.report(diagnostic);
        true
    }

    /// Lowers an index and notes that its goals are served.
    pub(crate) fn index_pattern(&mut self, datum: &Datum) -> Option<Pattern> {
        if datum.as_list().is_none_or(<[Datum]>::is_empty) {
            let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, "an index is a list")
                .help("for example `(index (take-picture ?camera))`");
            return self.refuse(diagnostic);
        }
        if self.report_result_in_index(datum) {
            return None;
        }
        if let Some(bound) = first_bound(datum) {
            let diagnostic = Diagnostic::error(
                codes::NEVER_BOUND,
                bound.span,
                "no variable has a value before the index is matched",
            )
            .reason("`<?x>` must have a value already; an index gives variables their first values")
            .help("write `?x`");
            return self.refuse(diagnostic);
        }
        for item in datum.tail() {
            if let Some(name) = item.as_symbol() {
                self.scope.index_words.insert(name.clone(), item.span);
            }
        }
        let pattern = self.pattern(datum)?;
        self.served.push(Served {
            pattern: pattern.clone(),
            span: datum.span,
            bundle: self.bundle.clone(),
            by_solver: self.is_solver,
        });
        Some(pattern)
    }

    /// Separates steps from clauses. A `select` of the procedure belongs to the nearest step before it. In a procedure that states its
    /// kind, a list that is not a clause is a step without the word `step`.
    fn sort_clauses<'d>(
        &mut self,
        clauses: &[&'d Datum],
        has_kind: bool,
    ) -> (Vec<StepSource<'d>>, Vec<&'d Datum>, bool) {
        let mut steps: Vec<StepSource<'d>> = Vec::new();
        let mut others = Vec::new();
        let mut complete = true;
        let mut rest = clauses.iter();
        while let Some(clause) = rest.next() {
            let result = match rest.as_slice() {
                [mark, pattern, ..] if mark.is("=>") => Some(*pattern),
                _ => None,
            };
            match (clause.head_name(), steps.last_mut()) {
                ("step", _) => match self.step_source(clause) {
                    Some(source) => steps.push(source),
                    None => complete = false,
                },
                ("select", Some(step)) => step.clauses.push(clause),
                ("select", None) => {
                    complete = false;
                    let diagnostic =
                        Diagnostic::error(codes::MALFORMED, clause.span, "this `select` belongs to no step")
                            .reason("a select at procedure level serves the nearest step before it")
                            .help("move it into the step that uses its variable");
                    self.report(diagnostic);
                }
                _ if is_bare_step(clause) && (has_kind || result.is_some() || clause.head_name() == "terminate") => {
                    if !has_kind {
                        self.report_bare_step(clause, result);
                        complete = false;
                    }
                    if result.is_some() {
                        rest.nth(1);
                    }
                    steps.push(StepSource { result, ..StepSource::bare(clause) });
                }
                _ => others.push(*clause),
            }
        }
        complete &= self.number_tags(&mut steps);
        (steps, others, complete)
    }

    /// Reports a step without the word `step` in a procedure that does not state its kind.
    fn report_bare_step(&mut self, activity: &Datum, result: Option<&Datum>) {
        let last = result.map_or(activity.span, |pattern| pattern.span);
        let name = activity.head_name();
        let message = format!("`{name}` is not a clause here, but the activity of a step");
        let title = if result.is_some() {
            format!("write `(step ({name} ..) => ..)`")
        } else {
            format!("write `(step ({name} ..))`")
        };
        let fix = Fix::safe(title).insert_before(activity.span, "(step ").insert_after(last, ")");
        self.report(
            Diagnostic::error(codes::UNKNOWN_CLAUSE, activity.span, message)
                .reason(
                    "only a procedure that states its kind, such as `:sequential`, has steps without the word `step`",
                )
                .fix(fix),
        );
    }

    /// Gives untagged steps the first symbol of their activity, numbered if it repeats. Returns true if the stated tags differ.
    fn number_tags(&mut self, steps: &mut [StepSource<'_>]) -> bool {
        let unique = self.report_same_tags(steps);
        if steps.iter().all(|step| !step.tag.is("")) {
            return unique;
        }
        let mut used: BTreeSet<Symbol> =
            steps.iter().filter(|step| !step.tag.is("")).map(|step| step.tag.clone()).collect();
        let mut counts: BTreeMap<Symbol, u32> = BTreeMap::new();
        for step in steps.iter_mut().filter(|step| step.tag.is("")) {
            let base = step.activity.head().cloned().unwrap_or_else(|| Symbol::new("step"));
            let count = counts.entry(base.clone()).or_insert(0);
            loop {
                *count += 1;
                let tag = if *count == 1 { base.clone() } else { Symbol::new(&format!("{base}-{count}")) };
                if used.insert(tag.clone()) {
                    step.tag = tag;
                    break;
                }
            }
        }
        unique
    }

    /// Notes which variables `=>` binds, before any condition is lowered.
    fn collect_results(&mut self, steps: &[StepSource<'_>]) {
        for (number, step) in steps.iter().enumerate() {
            let items = step.activity.as_list().unwrap_or_default();
            let inner = items.iter().position(|item| item.is("=>")).and_then(|mark| items.get(mark + 1));
            for pattern in inner.into_iter().chain(step.result) {
                variables_in(pattern, &mut |name| {
                    self.scope.results.insert(name.clone(), number);
                });
            }
        }
    }

    fn procedure_clause(&mut self, clause: &Datum, procedure: &mut Procedure) -> Option<()> {
        match clause.head_name() {
            "profile" => procedure.profile.extend(self.profile(clause)?),
            "log" => procedure.log.extend(self.log(clause)?),
            "expected-duration" => {
                let datum = self.only("expected-duration", clause.tail(), clause.span)?;
                procedure.expected_duration = Some(self.pure("this clause", |lowering| lowering.span_of_time(datum))?);
            }
            "interrupt-cost" => procedure.interrupt_cost = Some(self.only_expression(clause)?),
            "on-start" | "on-end" | "on-suspend" | "on-resume" => self.hook(clause, &mut procedure.hooks)?,
            "precondition" | "invariant" => self.execution_condition(clause, &mut procedure.transitions)?,
            name if PROCEDURE_CLAUSES.contains(&name) => self.transition(clause, &mut procedure.transitions)?,
            // Unknown clauses have been reported.
            _ => {}
        }
        Some(())
    }

    /// Adds the end of a sequential procedure; reports a concurrent one without an end.
    fn finish_kind(&mut self, datum: &Datum, procedure: &mut Procedure) {
        let ends = procedure.transitions.end_when.is_some();
        let has_terminate =
            procedure.steps.iter().any(|step| matches!(step.activity, Activity::Terminate { task: None, .. }));
        match procedure.kind {
            ProcedureKind::Sequential if !has_terminate => {
                let place = procedure.steps.last().map_or(procedure.place, |step| step.place);
                let taken = |tag: &str| procedure.steps.iter().any(|step| step.tag.is(tag));
                let mut tag = "terminate".to_string();
                let mut number = 1;
                while taken(&tag) {
                    number += 1;
                    tag = format!("terminate-{number}");
                }
                procedure.steps.push(terminate_step(&tag, place));
            }
            ProcedureKind::Concurrent if !ends && !has_terminate && !procedure.steps.is_empty() => {
                let span = datum.head_span();
                let message = "this concurrent procedure has neither a terminate step nor an end-when clause";
                let diagnostic = Diagnostic::new(Severity::Note, codes::NO_END, span, message)
                    .reason("it is complete when all of its steps that do not repeat have ended");
                self.report(diagnostic);
            }
            _ => {}
        }
    }
}

/// Returns true for a clause for readers, which documents the text and has no effect.
pub(crate) fn is_documentation(clause: &Datum) -> bool {
    let name = clause.head_name();
    DOCUMENTATION_CLAUSES.contains(&name.strip_prefix(':').unwrap_or(name))
        && clause.tail().iter().all(|item| item.as_list().is_none())
}

/// Returns true for a list that is neither a clause nor similar to one. A `terminate` without a condition is an activity.
fn is_bare_step(clause: &Datum) -> bool {
    let name = clause.head_name();
    if name == "terminate" {
        let words = clause.tail();
        let outcome = |word: &Datum| word.as_symbol().is_some() && !word.is("when");
        return words.first().is_none_or(outcome) || words.iter().any(|word| word.is(">>"));
    }
    let words = || PROCEDURE_CLAUSES.iter().chain(STEP_CLAUSES).copied();
    clause.head().is_some()
        && clause.head().is_some_and(|head| !head.folded().starts_with(':'))
        && !words().any(|word| word == name)
        && nearest(name, words()).is_none()
        && !super::step::is_meant_clause(name)
}

/// Returns the step that ends a procedure with success.
fn terminate_step(tag: &str, place: apex_model::source::Place) -> Step {
    Step::plain(Symbol::new(tag), Activity::Terminate { task: None, outcome: None, value: None }, place)
}

/// Returns true for `(indx (..))`: a list with one list inside, headed by a word similar to `index`.
fn is_misspelt_index(datum: &Datum) -> bool {
    let name = datum.head_name();
    matches!(datum.tail(), [pattern] if pattern.as_list().is_some()) && nearest(name, ["index"]).is_some()
}

fn first_bound(datum: &Datum) -> Option<&Datum> {
    match &datum.kind {
        DatumKind::Bound(_) => Some(datum),
        DatumKind::List(items) => items.iter().find_map(first_bound),
        _ => None,
    }
}

pub(super) fn variables_in(datum: &Datum, found: &mut dyn FnMut(&Symbol)) {
    match &datum.kind {
        DatumKind::Variable(name) => found(name),
        DatumKind::List(items) => items.iter().for_each(|item| variables_in(item, found)),
        _ => {}
    }
}
