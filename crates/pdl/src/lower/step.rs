//! Steps (`pdl.md`, Steps): tag, activity, result, clauses.

use super::Lowering;
use super::activity::swap;
use super::clauses::groups;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use crate::suggest::renames;
use crate::vocabulary::{REPEATING_OPTIONS, STEP_CLAUSES};
use apex_model::expression::{Expr, ExprKind};
use apex_model::procedure::{Activity, BuiltInActivity, PriorityClause, Repetition, Step};
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// A step's text, taken apart but not yet lowered.
pub(crate) struct StepSource<'d> {
    pub(crate) tag: Symbol,
    pub(crate) tag_span: Span,
    pub(crate) activity: &'d Datum,
    /// The pattern of a `=>` after the activity.
    pub(crate) result: Option<&'d Datum>,
    pub(crate) clauses: Vec<&'d Datum>,
    pub(crate) span: Span,
}

impl<'d> StepSource<'d> {
    /// Returns a step that is its activity alone: `(fly-to ?place)`.
    pub(crate) fn bare(activity: &'d Datum) -> StepSource<'d> {
        let (span, clauses) = (activity.span, Vec::new());
        StepSource { tag: Symbol::new(""), tag_span: span, activity, result: None, clauses, span }
    }
}

/// Returns true if the word is another name of a clause.
pub(crate) fn is_meant_clause(name: &str) -> bool {
    name == "terminate-when" || MEANT.iter().any(|(word, _)| *word == name)
}

/// Words that authors write for clauses with another name.
const MEANT: &[(&str, &str)] = &[
    ("when", "waitfor"),
    ("after", "waitfor"),
    ("wait", "waitfor"),
    ("wait-until", "waitfor"),
    ("await", "waitfor"),
    ("requires", "waitfor"),
    ("requires", "precondition"),
    ("preconditions", "precondition"),
    ("pre-condition", "precondition"),
    ("invariant-condition", "invariant"),
    ("maintain", "invariant"),
    ("skip", "skip-when"),
    ("skip-if", "skip-when"),
    ("skip-condition", "skip-when"),
    ("exit", "exit-when"),
    ("exit-condition", "exit-when"),
    ("abort-when", "exit-when"),
    ("on-fail", "on-failure"),
    ("on-error", "on-failure"),
    ("repeat", "repeating"),
    ("loop", "repeating"),
    ("respond", "responding"),
    ("until", "end-when"),
    ("stop-when", "end-when"),
    ("finish-when", "end-when"),
    ("done-when", "end-when"),
    ("resource", "profile"),
    ("resources", "profile"),
    ("needs", "profile"),
    ("uses", "profile"),
    ("foreach", "forall"),
    ("for-each", "forall"),
    ("on-begin", "on-start"),
    ("on-stop", "on-end"),
    ("on-finish", "on-end"),
    ("goal", "index"),
];
/// Advice for a number of repetitions.
const COUNTED: &str = "for 3 tasks at the same time write `(forall ?n in (range 3))`; for 3 in turn write `(repeating :while (< ?n 3)) \
                       (on-end (incf ?n))`, where an earlier step gave `?n` its first value, 0";

/// Returns true for a clause that repeats and states nothing but a number: `(repeat 3)`, `(repeating 3 times)`.
fn is_count(clause: &Datum) -> bool {
    let of_number = |item: &Datum| {
        matches!(item.kind, DatumKind::Integer(_) | DatumKind::Real(_) | DatumKind::Variable(_))
            || item.is("times")
            || item.is(":times")
    };
    ["repeat", "repeating", "loop", "times", "repeat-times"].contains(&clause.head_name())
        && !clause.tail().is_empty()
        && clause.tail().iter().all(of_number)
}

/// Clauses that may occur several times.
const REPEATABLE: &[&str] =
    &["select", "priority", "profile", "log", "on-start", "on-end", "on-suspend", "on-resume", "on-completion"];

impl Lowering {
    /// Splits `(step [TAG] (ACTIVITY) [=> PATTERN] CLAUSE..)` into its parts. A missing tag is empty until it is numbered.
    pub(crate) fn step_source<'d>(&mut self, datum: &'d Datum) -> Option<StepSource<'d>> {
        let items = datum.tail();
        let (tag, rest) = match items {
            [tag, rest @ ..] if tag.as_symbol().is_some() && tag.keyword().is_none() => (Some(tag), rest),
            // `1` is a number and `4.4a` are amperes elsewhere; here they are names.
            [tag, activity, ..] if self.number_as_name(tag).is_some() && activity.as_list().is_some() => {
                (Some(tag), items.get(1..).unwrap_or_default())
            }
            [Datum { kind: DatumKind::Variable(_), span }, ..] => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, *span, "a tag is written without question mark")
                    .help("`?tag` is the task of the step tagged `tag`");
                return self.refuse(diagnostic);
            }
            _ => (None, items),
        };
        let Some((activity, rest)) = rest.split_first().filter(|(activity, _)| activity.as_list().is_some()) else {
            return self.missing_part(datum.span, "this step has no activity", "(step [TAG] (ACTIVITY ..) CLAUSE..)");
        };
        let (result, clauses) = match rest {
            [mark, pattern, clauses @ ..] if mark.is("=>") => (Some(pattern), clauses),
            [mark, pattern, ..] if mark.is("->") && pattern.as_variable().is_some() => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, mark.span, "`->` does not bind a result");
                return self.refuse(diagnostic.fix(Fix::safe("write `=>`").replace(mark.span, "=>")));
            }
            _ => (None, rest),
        };
        let tag_span = tag.unwrap_or(activity).span;
        let named = tag.and_then(|tag| tag.as_symbol().cloned().or_else(|| self.number_as_name(tag)));
        let tag = named.unwrap_or_else(|| Symbol::new(""));
        let clauses = clauses.iter().filter(|clause| !super::procedure::is_documentation(clause)).collect();
        Some(StepSource { tag, tag_span, activity, result, clauses, span: datum.span })
    }

    /// Returns the name of a step that is a number or reads like a quantity: `1`, `4.4a`, `2s`.
    fn number_as_name(&self, tag: &Datum) -> Option<Symbol> {
        use DatumKind::{Duration, Integer, Quantity, Real};
        matches!(tag.kind, Quantity(_) | Duration(_) | Integer(_) | Real(_))
            .then(|| self.text_at(tag.span))
            .flatten()
            .filter(|text| !text.starts_with('('))
            .map(Symbol::new)
    }

    /// Lowers step `number` of the present procedure.
    pub(crate) fn step(&mut self, number: usize, source: &StepSource<'_>) -> Option<Step> {
        self.scope.step = Some(number);
        let step = self.step_parts(source);
        self.scope.step = None;
        step
    }

    fn step_parts(&mut self, source: &StepSource<'_>) -> Option<Step> {
        let mut complete = self.check_clauses(&source.clauses, STEP_CLAUSES, "a step");
        let (activity, inner) = self.split_result(source.activity)?;
        if let (Some(inner), Some(outer)) = (inner, source.result) {
            self.report_twice("`=>`", inner.span, outer.span);
            complete = false;
        }
        let lowered = self.pure("an activity", |lowering| lowering.activity(&activity));
        let binds = inner.or(source.result).map(|pattern| self.result_pattern(pattern));
        let nothing_yet = Activity::BuiltIn(BuiltInActivity::Print, Vec::new());
        let mut step = Step::plain(source.tag.clone(), nothing_yet, source.span.place());
        for clause in &source.clauses {
            complete &= self.step_clause(clause, &mut step).is_some();
        }
        step.activity = lowered?;
        step.binds = swap(binds)?.map(Box::new);
        complete.then_some(())?;
        self.check_repetition(source, &step)?;
        Some(step)
    }

    /// Lowers the pattern after a `=>`; its variables are bound for the whole procedure.
    fn result_pattern(&mut self, datum: &Datum) -> Option<apex_model::pattern::Pattern> {
        if let Some(name) = datum.as_symbol().filter(|name| !name.is("nil") && !name.is("t")) {
            let message = format!("`{name}` is a word here, not a variable for the result");
            let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, message);
            return self.refuse(diagnostic.fix(Fix::safe(format!("write `?{name}`")).insert_before(datum.span, "?")));
        }
        let step = self.scope.step.take();
        let pattern = self.pattern(datum);
        self.scope.step = step;
        pattern
    }

    fn step_clause(&mut self, clause: &Datum, step: &mut Step) -> Option<()> {
        let items = clause.tail();
        match clause.head_name() {
            "waitfor" => {
                if items.is_empty() {
                    return self.missing_part(clause.span, "this `waitfor` has no condition", "(waitfor CONDITION..)");
                }
                let conditions = self.conditions(items)?;
                step.waitfor = self.clause_conditions(conditions, clause.span);
            }
            "select" => {
                let selected = self.select(clause)?;
                if step.select.iter().any(|(name, _)| *name == selected.0) {
                    self.report_selected_again(clause, &selected.0);
                }
                step.select.push(selected);
            }
            "forall" => step.forall = Some(Box::new(self.forall(clause)?)),
            "priority" => {
                let clause = self.priority(clause)?;
                // Most steps have one priority clause, and a clause is large.
                if step.priority.is_empty() {
                    step.priority.reserve_exact(1);
                }
                step.priority.push(clause);
            }
            "rank" => step.rank = Some(Box::new(self.only_expression(clause)?)),
            "interrupt-cost" => step.interrupt_cost = Some(Box::new(self.only_expression(clause)?)),
            "repeating" => step.repeating = Some(Box::new(self.repetition(clause, true)?)),
            "responding" => step.responding = Some(Box::new(self.repetition(clause, false)?)),
            "profile" => step.profile.extend(self.profile(clause)?),
            "on-failure" => {
                let datum = self.only("on-failure", items, clause.span)?;
                step.on_failure = Some(Box::new(self.pure("an activity", |lowering| lowering.activity(datum))?));
            }
            "on-start" | "on-end" | "on-suspend" | "on-resume" => self.hook(clause, &mut step.hooks)?,
            "precondition" | "invariant" => self.execution_condition(clause, &mut step.transitions)?,
            name if STEP_CLAUSES.contains(&name) => self.transition(clause, &mut step.transitions)?,
            // Unknown clauses have been reported.
            _ => {}
        }
        Some(())
    }

    /// Reports unknown clauses, and repeated clauses that may occur only once. Returns true if there are none.
    pub(crate) fn check_clauses(&mut self, clauses: &[&Datum], known: &[&str], of: &str) -> bool {
        let mut fine = true;
        for (index, clause) in clauses.iter().enumerate() {
            let name = clause.head_name();
            if !known.contains(&name) {
                fine = false;
                self.report_unknown_clause(clause, known, of);
                continue;
            }
            let earlier = clauses.iter().take(index).find(|earlier| earlier.head_name() == name);
            if let Some(earlier) = earlier.filter(|_| !REPEATABLE.contains(&name)) {
                fine = false;
                self.report_clause_twice(earlier, clause);
            }
        }
        fine
    }

    fn report_unknown_clause(&mut self, clause: &Datum, known: &[&str], of: &str) {
        let Some(name) = clause.head() else {
            let shown = if clause.as_list().is_some() { "this list" } else { "this" };
            let diagnostic =
                Diagnostic::error(codes::UNKNOWN_CLAUSE, clause.span, format!("{shown} is not a clause of {of}"))
                    .help("a clause is a list that begins with its name, for example `(waitfor ..)`");
            return self.report(diagnostic);
        };
        let message = format!("{of} has no clause `{name}`");
        let diagnostic = Diagnostic::error(codes::UNKNOWN_CLAUSE, clause.span, message);
        let span = clause.head_span();
        let mut fixes = renames(span, name.printed(), known.iter().copied());
        if name.is("terminate-when") && known.contains(&"end-when") {
            fixes = vec![Fix::safe(format!("replace `{name}` by `end-when`")).replace(span, "end-when")];
        }
        if is_count(clause) {
            return self.report(diagnostic.reason("no clause counts repetitions").help(COUNTED));
        }
        // Resources are names; a condition is a list.
        let only_names = !clause.tail().is_empty() && clause.tail().iter().all(|item| item.as_symbol().is_some());
        if name.is("requires") && only_names && known.contains(&"profile") {
            fixes = vec![Fix::safe(format!("replace `{name}` by `profile`")).replace(span, "profile")];
        }
        let meant = MEANT.iter().find(|(word, clause)| name.is(word) && known.contains(clause));
        if let Some((_, clause)) = meant.filter(|_| fixes.is_empty()) {
            fixes.push(Fix::look(format!("replace `{name}` by `{clause}`")).replace(span, *clause));
        }
        let is_like_step = known.contains(&"step") && clause.tail().first().is_some_and(|first| first.head().is_some());
        if is_like_step && fixes.is_empty() {
            fixes.push(Fix::look(format!("make it a step: `(step {name} ..)`")).insert_before(span, "step "));
        } else if known.contains(&"step") && fixes.is_empty() && !STEP_CLAUSES.contains(&name.folded()) {
            // In a procedure that does not state its kind, the form can only be a step.
            let fix = Fix::look(format!("make it a step: `(step ({name} ..))`")).insert_before(clause.span, "(step ");
            fixes.push(fix.insert_after(clause.span, ")"));
        }
        self.report(diagnostic.fixes_or_help(fixes, || format!("its clauses are {}", known.join(" "))));
    }

    pub(crate) fn only_expression(&mut self, clause: &Datum) -> Option<Expr> {
        let datum = self.only(clause.head_name(), clause.tail(), clause.span)?;
        self.pure_expression(datum, "this clause")
    }

    pub(crate) fn select(&mut self, clause: &Datum) -> Option<(Symbol, Expr)> {
        let [Datum { kind: DatumKind::Variable(name), span }, value] = clause.tail() else {
            return self.missing_part(
                clause.span,
                "this `select` has the wrong parts",
                "(select ?variable EXPRESSION)",
            );
        };
        self.scope.bind(name, *span);
        Some((name.clone(), self.pure_expression(value, "a select clause")?))
    }

    /// Warns of a select that replaces the value of an earlier one without using it: the earlier one has no effect.
    fn report_selected_again(&mut self, clause: &Datum, name: &Symbol) {
        if clause.tail().get(1).is_some_and(|value| value.mentions(name)) {
            return;
        }
        let message = format!("this `select` replaces the value that another one gives `?{name}`");
        let diagnostic = Diagnostic::new(Severity::Warning, codes::WITHOUT_EFFECT, clause.span, message)
            .reason("the clauses are evaluated in their order, and the last value counts")
            .help("keep one of them, or give one of the variables another name");
        self.report(diagnostic);
    }

    fn forall(&mut self, clause: &Datum) -> Option<(Symbol, Expr)> {
        match clause.tail() {
            [Datum { kind: DatumKind::Variable(name), span }, word, list] if word.is("in") => {
                self.scope.bind(name, *span);
                Some((name.clone(), self.pure_expression(list, "a forall clause")?))
            }
            _ => self.missing_part(clause.span, "this `forall` has the wrong parts", "(forall ?variable in LIST)"),
        }
    }

    fn priority(&mut self, clause: &Datum) -> Option<PriorityClause> {
        let (before, options) = groups(clause.tail());
        if let ([number], []) = (before, options.as_slice()) {
            return self.pure_expression(number, "a priority clause").map(PriorityClause::Number);
        }
        self.no_stray(before)?;
        self.check_groups(&options, &["urgency", "importance"], "`priority`")?;
        let lower = |lowering: &mut Lowering, datum: &Datum| lowering.pure_expression(datum, "a priority clause");
        let urgency = self.optional(&options, "urgency", lower)?;
        let importance = self.optional(&options, "importance", lower)?;
        match (urgency, importance) {
            (Some(urgency), Some(importance)) => Some(PriorityClause::UrgencyImportance(urgency, importance)),
            _ => {
                let shape = "(priority NUMBER) or (priority :urgency U :importance I)";
                self.missing_part(clause.span, "this `priority` has the wrong parts", shape)
            }
        }
    }

    fn repetition(&mut self, clause: &Datum, repeating: bool) -> Option<Repetition> {
        let known: &[&str] = if repeating { REPEATING_OPTIONS } else { &["while", "until", "for-new"] };
        // The items include the clause's name, so that the first word after it is checked as well.
        let of = format!("`{}`", clause.head_name());
        if self.report_missing_colon(clause.as_list().unwrap_or_default(), known, &of) {
            return None;
        }
        let (stray, options) = groups(clause.tail());
        if is_count(clause) {
            let message = format!("`{}` takes no number", clause.head_name());
            let diagnostic = Diagnostic::error(codes::MALFORMED, clause.span, message);
            return self.refuse(diagnostic.reason("no clause counts repetitions").help(COUNTED));
        }
        self.no_stray(stray)?;
        self.check_groups(&options, known, &format!("`{}`", clause.head_name()))?;
        let test = |lowering: &mut Lowering, datum: &Datum| {
            let expr = lowering.pure_expression(datum, "a repetition")?;
            match &expr.kind {
                ExprKind::Constant(Value::Symbol(name)) if !name.is("t") && !name.is("nil") => {
                    let message = format!("`{name}` is a name, which counts as true");
                    let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, message)
                        .reason("`:while` and `:until` take an expression, which is evaluated when the step has ended");
                    let help = "compare a variable, `(= ?x done)`, or let a message end the step: `(end-when (done))`";
                    lowering.refuse(diagnostic.help(help))
                }
                _ => Some(expr),
            }
        };
        let while_true = self.optional(&options, "while", test)?;
        let until = self.optional(&options, "until", test)?;
        let enabled = match options.iter().find(|group| group.name == "enabled") {
            Some(group) if group.values.is_empty() => Some(super::expression::constant(Value::truth(true), group.span)),
            _ => self.optional(&options, "enabled", test)?,
        };
        let recovery = self.optional(&options, "with-recovery", Lowering::span_of_time)?;
        let minimum_interval = self.optional(&options, "with-min-interval", Lowering::span_of_time)?;
        let new = super::clauses::values_of(&options, "for-new");
        let for_new = self.all(new, |lowering, datum| match &datum.kind {
            DatumKind::Variable(name) => {
                lowering.scope.use_variable(name, datum.span);
                Some(name.clone())
            }
            _ => lowering.refuse(Diagnostic::error(codes::MALFORMED, datum.span, "`:for-new` takes variables")),
        })?;
        let drop_missed = self.optional(&options, "missed-messages", Lowering::missed_messages)?.unwrap_or(false);
        Some(Repetition { while_true, until, enabled, recovery, minimum_interval, for_new, drop_missed })
    }

    /// Lowers `answer` or `drop`; returns true if messages that arrive while the step is busy are dropped.
    fn missed_messages(&mut self, datum: &Datum) -> Option<bool> {
        if datum.is("drop") || datum.is("answer") {
            return Some(datum.is("drop"));
        }
        let message = "`:missed-messages` is `answer` or `drop`";
        let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, message)
            .reason("it says whether messages that come while the step is busy are answered later")
            .help("leave it out to have all of them answered, in order");
        self.refuse(diagnostic)
    }

    fn check_repetition(&mut self, source: &StepSource<'_>, step: &Step) -> Option<()> {
        let clause =
            |name: &str| source.clauses.iter().find(|clause| clause.head_name() == name).map(|clause| clause.span);
        if step.responding.is_some() && step.waitfor.is_empty() {
            let span = clause("responding").unwrap_or(source.span);
            let diagnostic =
                Diagnostic::error(codes::RESPONDING_WITHOUT_WAITFOR, span, "a responding step needs a waitfor")
                    .reason("each event that satisfies the waitfor starts a new instance")
                    .help("add `(waitfor ..)`, or use `repeating`");
            return self.refuse(diagnostic);
        }
        let takes_no_time = match &step.activity {
            Activity::Goal(_) | Activity::Terminate { .. } => false,
            Activity::BuiltIn(which, _) => !matches!(which, BuiltInActivity::AskOperator | BuiltInActivity::Plan),
        };
        let endless = step.repeating.as_ref().is_some_and(|repeating| {
            repeating.while_true.is_none() && repeating.until.is_none() && repeating.minimum_interval.is_none()
        });
        if takes_no_time && endless && step.waitfor.is_empty() {
            let span = clause("repeating").unwrap_or(source.span);
            let diagnostic =
                Diagnostic::error(codes::ENDLESS_REPETITION, span, "this step repeats without end at one instant")
                    .reason("its activity takes no time and nothing makes it wait")
                    .help("add `:with-min-interval D`, `:until T`, or a waitfor");
            return self.refuse(diagnostic);
        }
        Some(())
    }
}
