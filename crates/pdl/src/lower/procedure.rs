//! Procedures (`pdl.md` section 3): kind, index, clauses, steps; clauses shared with steps and primitives.

use super::clauses::groups;
use super::step::StepSource;
use super::{Lowering, Scope, Served};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::read::{Datum, DatumKind};
use crate::suggest::nearest;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::ResourceKind;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, Hooks, LogPolicy, Procedure, ProcedureKind, ResourceNeed, Step, Transitions};
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

const CLAUSES: &[&str] = &[
    "index",
    "step",
    "profile",
    "log",
    "expected-duration",
    "interrupt-cost",
    "end-when",
    "terminate",
    "restart",
    "restart-when",
    "resume",
    "resume-when",
    "suspend",
    "suspend-when",
    "on-start",
    "on-end",
    "on-suspend",
    "on-resume",
    "select",
];

impl Lowering {
    /// Lowers `(procedure [KIND] (index PATTERN) CLAUSE.. STEP..)`.
    pub(crate) fn procedure(&mut self, datum: &Datum) -> Option<Procedure> {
        let (kind, items) = self.procedure_kind(datum)?;
        let (index, clauses) = self.split_index(datum, items, CLAUSES, "procedure")?;
        self.scope = Scope::of_tasks();
        let (steps, clauses, mut complete) = self.sort_clauses(&clauses);
        self.scope.tags = steps.iter().map(|step| (step.tag.clone(), step.tag_span)).collect();
        for step in &steps {
            self.scope.bind_everywhere(&step.tag, step.tag_span);
        }
        self.collect_results(&steps);
        let index = self.index_pattern(index)?;
        complete &= self.check_clauses(&clauses, CLAUSES, "a procedure");
        let mut procedure = Procedure {
            kind,
            index,
            profile: Vec::new(),
            log: Vec::new(),
            expected_duration: None,
            interrupt_cost: None,
            transitions: Transitions::default(),
            hooks: Hooks::default(),
            steps: Vec::new(),
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
        self.finish_scope();
        complete.then_some(())?;
        self.check_procedure_support(&procedure, datum.span)?;
        self.finish_kind(datum, &mut procedure);
        Some(procedure)
    }

    fn procedure_kind<'d>(&mut self, datum: &'d Datum) -> Option<(ProcedureKind, &'d [Datum])> {
        let items = datum.tail();
        let Some((word, rest)) = items.split_first() else {
            let shape = "(procedure [:sequential] (index PATTERN) CLAUSE.. (step ..)..)";
            return self.missing_part(datum.span, "this procedure is empty", shape);
        };
        let kind = match word.keyword() {
            None => return Some((ProcedureKind::Concurrent, items)),
            Some("concurrent" | "conc") => ProcedureKind::Concurrent,
            Some("sequential" | "seq") => ProcedureKind::Sequential,
            Some("ranked") => ProcedureKind::Ranked,
            Some("soft-seq" | "soft-sequential") => ProcedureKind::SoftSequential,
            Some(other) => {
                const KINDS: &[&str] = &["concurrent", "conc", "sequential", "seq", "ranked", "soft-seq"];
                let message = format!("procedures are not of kind `:{other}`");
                let diagnostic = Diagnostic::error(codes::UNKNOWN_OPTION, word.span, message);
                return self.refuse(match nearest(other, KINDS.iter().copied()) {
                    Some(found) => diagnostic.help(format!("did you mean `:{found}`?")),
                    None => diagnostic.help("kinds are :concurrent :sequential :ranked :soft-seq"),
                });
            }
        };
        Some((kind, rest))
    }

    /// Finds the index: an `(index ..)` clause, or else the first list that is no clause.
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
                self.report_twice("clause `index`", clause.span, again.span);
                return None;
            }
            return Some((pattern, items.iter().filter(|item| item.span != clause.span).collect()));
        }
        let bare = items.first().filter(|item| item.as_list().is_some() && !known.contains(&item.head_name()));
        match bare {
            Some(pattern) if !is_misspelt_index(pattern) => Some((pattern, items.iter().skip(1).collect())),
            _ => {
                let message = format!("this {what} does not say which goals it serves");
                let mut diagnostic =
                    Diagnostic::error(codes::MISSING_INDEX, datum.span, message).help("add `(index (verb object ..))`");
                if let Some(pattern) = bare {
                    diagnostic = diagnostic.label(pattern.span, "did you mean `index`?");
                }
                self.refuse(diagnostic)
            }
        }
    }

    /// Lowers an index and notes that its goals are served.
    pub(crate) fn index_pattern(&mut self, datum: &Datum) -> Option<Pattern> {
        if datum.as_list().is_none_or(<[Datum]>::is_empty) {
            let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, "an index is a list")
                .help("for example `(index (take-picture ?camera))`");
            return self.refuse(diagnostic);
        }
        if let Some(bound) = first_bound(datum) {
            let diagnostic = Diagnostic::error(codes::NEVER_BOUND, bound.span, "nothing is bound before the index")
                .reason("`<?x>` must have a value already; an index gives variables their first values")
                .help("write `?x`");
            return self.refuse(diagnostic);
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

    /// Parts steps from clauses. A procedure-level select goes to the nearest step before it.
    fn sort_clauses<'d>(&mut self, clauses: &[&'d Datum]) -> (Vec<StepSource<'d>>, Vec<&'d Datum>, bool) {
        let mut steps: Vec<StepSource<'d>> = Vec::new();
        let mut others = Vec::new();
        let mut complete = true;
        for clause in clauses {
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
                _ => others.push(*clause),
            }
        }
        complete &= self.number_tags(&mut steps);
        (steps, others, complete)
    }

    /// Gives untagged steps the first symbol of their activity, numbered where it repeats.
    fn number_tags(&mut self, steps: &mut [StepSource<'_>]) -> bool {
        let mut taken: BTreeMap<Symbol, Span> = BTreeMap::new();
        let mut unique = true;
        for step in steps.iter().filter(|step| !step.tag.is("")) {
            if let Some(first) = taken.insert(step.tag.clone(), step.tag_span) {
                unique = false;
                let message = format!("two steps are tagged `{}`", step.tag);
                let diagnostic =
                    Diagnostic::error(codes::DUPLICATE_TAG, step.tag_span, message).label(first, "first used here");
                self.report(diagnostic);
            }
        }
        let mut used: BTreeSet<Symbol> = taken.into_keys().collect();
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
                let mut names = Vec::new();
                variables_in(pattern, &mut names);
                for name in names {
                    self.scope.results.insert(name, number);
                }
            }
        }
    }

    fn procedure_clause(&mut self, clause: &Datum, procedure: &mut Procedure) -> Option<()> {
        match clause.head_name() {
            "profile" => procedure.profile.extend(self.profile(clause)?),
            "log" => procedure.log.extend(self.log(clause)?),
            "expected-duration" => {
                let datum = self.only("expected-duration", clause.tail(), clause.span)?;
                procedure.expected_duration = Some(self.pure("this clause", |lowering| lowering.duration(datum))?);
            }
            "interrupt-cost" => procedure.interrupt_cost = Some(self.only_expression(clause)?),
            "on-start" | "on-end" | "on-suspend" | "on-resume" => self.hook(clause, &mut procedure.hooks)?,
            name if CLAUSES.contains(&name) => self.transition(clause, &mut procedure.transitions)?,
            // Unknown clauses have been reported.
            _ => {}
        }
        Some(())
    }

    /// `(end-when C)`, `(terminate (when C))`, `(suspend-when C until C)`, `(suspend (when C) (until C))` and relatives.
    pub(crate) fn transition(&mut self, clause: &Datum, transitions: &mut Transitions) -> Option<()> {
        let name = clause.head_name();
        let items = clause.tail();
        let (when, until) = match items {
            [when] if when.head_name() == "when" => (when.tail(), None),
            [when, until] if when.head_name() == "when" && until.head_name() == "until" => {
                (when.tail(), Some(until.tail()))
            }
            [when, word, until] if word.is("until") => (std::slice::from_ref(when), Some(std::slice::from_ref(until))),
            [when, until] if until.head_name() == "until" => (std::slice::from_ref(when), Some(until.tail())),
            [word, when] if word.is("when") => (std::slice::from_ref(when), None),
            all => (all, None),
        };
        let is_suspend = name.starts_with("suspend");
        if when.is_empty() || (until.is_some() && !is_suspend) {
            let shape = if is_suspend { "(suspend-when CONDITION [until CONDITION])" } else { "(end-when CONDITION)" };
            return self.missing_part(clause.span, &format!("this `{name}` has the wrong parts"), shape);
        }
        let condition = self.clause_condition(name, when, clause)?;
        let slot = match name {
            "end-when" | "terminate" => &mut transitions.end_when,
            "restart" | "restart-when" => &mut transitions.restart_when,
            "resume" | "resume-when" => &mut transitions.resume_when,
            _ => &mut transitions.suspend_when,
        };
        if slot.replace(condition).is_some() {
            let diagnostic = Diagnostic::error(
                codes::CLAUSE_TWICE,
                clause.span,
                format!("`{name}` says again when this task changes state"),
            )
            .reason("the same clause stands here already in another spelling")
            .help("keep one of them, or join the conditions with `(:or ..)`");
            return self.refuse(diagnostic);
        }
        if let Some(until) = until {
            transitions.suspend_until = Some(self.clause_condition(name, until, clause)?);
        }
        Some(())
    }

    /// The one condition of a clause; `:quality Q` may follow an episode.
    fn clause_condition(
        &mut self,
        name: &str,
        items: &[Datum],
        clause: &Datum,
    ) -> Option<apex_model::condition::Condition> {
        let mut lowered = self.conditions(items)?;
        match (lowered.pop(), lowered.is_empty()) {
            (Some(condition), true) => {
                self.check_condition_support(&condition, clause)?;
                Some(condition)
            }
            _ => {
                let diagnostic = Diagnostic::error(
                    codes::MALFORMED,
                    super::span_of(items, clause.span),
                    format!("`{name}` takes one condition"),
                )
                .help("join them: `(:and ..)` or `(:or ..)`");
                self.refuse(diagnostic)
            }
        }
    }

    /// A hook: forms with effects.
    pub(crate) fn hook(&mut self, clause: &Datum, hooks: &mut Hooks) -> Option<()> {
        let forms = self.body(clause.tail())?;
        match clause.head_name() {
            "on-end" => hooks.on_end.extend(forms),
            "on-suspend" => hooks.on_suspend.extend(forms),
            "on-resume" => hooks.on_resume.extend(forms),
            _ => hooks.on_start.extend(forms),
        }
        Some(())
    }

    /// `(profile NAME.. (NAME AMOUNT)..)`
    pub(crate) fn profile(&mut self, clause: &Datum) -> Option<Vec<ResourceNeed>> {
        self.all(clause.tail(), |lowering, item| {
            let place = item.span.place();
            match &item.kind {
                DatumKind::Symbol(_) | DatumKind::Variable(_) | DatumKind::Bound(_) | DatumKind::Indexical(_) => {
                    let resource = lowering.template(item)?;
                    Some(ResourceNeed { resource, amount: None, place })
                }
                DatumKind::List(parts) => match parts.as_slice() {
                    [name, amount] => {
                        lowering.check_amount(name, amount)?;
                        let resource = lowering.template(name);
                        let amount = lowering.pure_expression(amount, "a profile clause");
                        Some(ResourceNeed { resource: resource?, amount: Some(amount?), place })
                    }
                    _ => lowering.missing_part(item.span, "a resource has the wrong parts", "NAME or (NAME AMOUNT)"),
                },
                _ => lowering.missing_part(item.span, "this is no resource", "NAME or (NAME AMOUNT)"),
            }
        })
    }

    fn check_amount(&mut self, name: &Datum, amount: &Datum) -> Option<()> {
        let Some(symbol) = name.as_symbol() else { return Some(()) };
        let severity = self.undefined();
        match self.names.resources.get(symbol) {
            Some((ResourceKind::Unitary, span)) => {
                let message = format!("resource `{symbol}` has no amount: one task at a time holds all of it");
                let diagnostic = Diagnostic::error(codes::RESOURCE_AMOUNT, amount.span, message)
                    .label(*span, "declared here")
                    .help(format!("declare `(resource {symbol} :capacity N)` or `(resource {symbol} :depletable Q)`"));
                self.refuse(diagnostic)
            }
            None => {
                let message = format!("an amount is asked of `{symbol}`, which is not declared");
                let diagnostic = Diagnostic::new(severity, codes::RESOURCE_AMOUNT, amount.span, message)
                    .help(format!("declare `(resource {symbol} :capacity N)` or `(resource {symbol} :depletable Q)`"));
                self.report(diagnostic);
                self.fragment.then_some(())
            }
            Some((ResourceKind::Depletable(total), span)) => {
                let (wanted, found) = (total.as_number(), amount.to_value().as_number());
                match (wanted, found) {
                    (Some((_, wanted)), Some((_, found))) if wanted != found => {
                        let message = format!("resource `{symbol}` is measured in {wanted}, but this is {found}");
                        let diagnostic = Diagnostic::error(codes::DIMENSION, amount.span, message)
                            .label(*span, format!("declared as {total} here"));
                        self.refuse(diagnostic)
                    }
                    _ => Some(()),
                }
            }
            Some((ResourceKind::Capacity(_), _)) => Some(()),
        }
    }

    /// `(log (ATTR OBJ)..)` and `(log ((ATTR OBJ) :frequency-limit D ..)..)`
    fn log(&mut self, clause: &Datum) -> Option<Vec<LogPolicy>> {
        self.all(clause.tail(), |lowering, item| {
            let nested = Lowering::is_nested(item);
            let (variable, options) = match item.as_list().and_then(<[Datum]>::split_first) {
                Some((variable, options)) if nested => (variable, options),
                Some(_) => (item, [].as_slice()),
                None => {
                    return lowering.missing_part(
                        item.span,
                        "a log policy names a state variable",
                        "(log (ATTRIBUTE OBJECT) ..)",
                    );
                }
            };
            let (stray, options) = groups(options);
            lowering.no_stray(stray)?;
            lowering.check_groups(&options, &["frequency-limit", "time-limit", "count-limit"], "`log`")?;
            let frequency = lowering.optional(&options, "frequency-limit", Lowering::literal_duration)?;
            let time = lowering.optional(&options, "time-limit", Lowering::literal_duration)?;
            let count = lowering.optional(&options, "count-limit", |lowering, datum| match datum.kind {
                DatumKind::Integer(count) if count >= 0 => u64::try_from(count).ok(),
                _ => lowering.refuse(Diagnostic::error(codes::MALFORMED, datum.span, "a count is a whole number")),
            })?;
            let variable = lowering.template(variable)?;
            Some(LogPolicy { variable, frequency_limit: frequency, time_limit: time, count_limit: count })
        })
    }

    /// A duration that is known at load time; a frequency stands for its interval.
    pub(crate) fn literal_duration(&mut self, datum: &Datum) -> Option<Duration> {
        let expr: Expr = self.interval_or_frequency(datum)?;
        match expr.kind {
            ExprKind::Constant(Value::Duration(duration)) => Some(duration),
            _ => {
                let diagnostic =
                    Diagnostic::error(codes::DURATION_EXPECTED, datum.span, "a literal duration is needed here")
                        .help("write a duration with its unit: `5s`, `P1M30S`, `(1 hr 30 min)`");
                self.refuse(diagnostic)
            }
        }
    }

    /// Adds the end of a sequential procedure; remarks on a concurrent one without end.
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
                let span = datum.as_list().and_then(<[Datum]>::first).map_or(datum.span, |head| head.span);
                let message = "this concurrent procedure has neither a terminate step nor an end-when clause";
                let diagnostic = Diagnostic::new(Severity::Note, codes::NO_END, span, message)
                    .reason("it is complete when all of its steps that do not repeat have ended");
                self.report(diagnostic);
            }
            _ => {}
        }
    }
}

/// The step that ends a procedure with success.
fn terminate_step(tag: &str, place: apex_model::source::Place) -> Step {
    Step {
        tag: Symbol::new(tag),
        activity: Activity::Terminate { task: None, outcome: None, value: None },
        binds: None,
        waitfor: Vec::new(),
        select: Vec::new(),
        forall: None,
        priority: Vec::new(),
        rank: None,
        interrupt_cost: None,
        repeating: None,
        responding: None,
        profile: Vec::new(),
        transitions: Transitions::default(),
        hooks: Hooks::default(),
        on_failure: None,
        place,
    }
}

/// `(indx (..))`: one list inside, headed by nearly `index`.
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

fn variables_in(datum: &Datum, names: &mut Vec<Symbol>) {
    match &datum.kind {
        DatumKind::Variable(name) => names.push(name.clone()),
        DatumKind::List(items) => items.iter().for_each(|item| variables_in(item, names)),
        _ => {}
    }
}
