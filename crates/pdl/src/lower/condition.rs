//! Lowering of conditions (`conditions.md`): recognises the kind of each form.

use super::constraint::relation_named;
use super::{Lowering, Scope};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use crate::suggest::{renames, renames_marked};
use apex_model::condition::{Condition, ConditionKind, Timing};
use apex_model::expression::{Expr, ExprKind};
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::task::OUTCOME_STATES;
use apex_model::value::Value;

/// Every keyword that heads a condition.
const CONDITION_KEYWORDS: &[&str] = &[
    "absent",
    "after",
    "and",
    "atomic-episode",
    "before",
    "contains",
    "cotemporal",
    "cyclic",
    "delay",
    "during",
    "episode",
    "finished-by",
    "finishes",
    "function",
    "in-order",
    "measurement",
    "meets",
    "met-by",
    "not",
    "or",
    "overlapped-by",
    "overlaps",
    "started-by",
    "starts",
    "timestamp",
];

/// `(WORD ?step)`: how the step's task ended.
const OUTCOMES: &[&str] = &["succeeded", "failed", "skipped", "exited", "precondition-failed", "invariant-violated"];

impl Lowering {
    /// Lowers a sequence of conditions; `:quality Q` may follow an episode directly, as in the paper.
    pub(crate) fn conditions(&mut self, items: &[Datum]) -> Option<Vec<Condition>> {
        // Conditions are large and most clauses have one, so the vector has no spare capacity.
        let mut lowered = Vec::with_capacity(items.len());
        let mut complete = true;
        let mut rest = items;
        while let Some((item, after)) = rest.split_first() {
            let (quality, next) = match after {
                [mark, quality, next @ ..] if mark.is(":quality") => (Some(quality), next),
                _ => (None, after),
            };
            match self.condition_with(item, quality) {
                Some(condition) => lowered.push(condition),
                None => complete = false,
            }
            rest = next;
        }
        complete.then_some(lowered)
    }

    /// Lowers separate conditions, each in its own scope.
    pub(crate) fn lone_conditions(&mut self, items: &[Datum]) -> Vec<Condition> {
        let goals = self.goals.len();
        let mut lowered = Vec::new();
        let mut rest = items;
        while let [_, after @ ..] = rest {
            let length = if matches!(after, [mark, _, ..] if mark.is(":quality")) { 3 } else { 1 };
            let (form, next) = rest.split_at_checked(length).unwrap_or((rest, &[]));
            self.scope = Scope::of_tasks();
            let whole = super::span_of(form, form.first().map_or_else(Span::default, |first| first.span));
            let condition = self.conditions(form).and_then(|all| self.clause_conditions(all, whole).pop());
            self.finish_scope(condition.is_some());
            lowered.extend(condition);
            rest = next;
        }
        // No task pursues goals here, so no method need serve them.
        self.goals.truncate(goals);
        lowered
    }

    fn condition_with(&mut self, datum: &Datum, quality: Option<&Datum>) -> Option<Condition> {
        let outer = std::mem::replace(&mut self.scope.in_condition, true);
        let condition = self.pure("a condition", |lowering| lowering.condition_form(datum, quality));
        self.scope.in_condition = outer;
        condition
    }

    fn condition_form(&mut self, datum: &Datum, quality: Option<&Datum>) -> Option<Condition> {
        if let Some(quality) = quality
            && datum.head_name() != ":episode"
        {
            let diagnostic =
                Diagnostic::error(codes::MALFORMED_CONDITION, quality.span, "`:quality` belongs to an episode")
                    .label(datum.span, "this condition is not an episode");
            return self.refuse(diagnostic);
        }
        let plain = |kind| Some(Condition { tag: None, kind, place: datum.span.place() });
        let items = match &datum.kind {
            DatumKind::Variable(name) | DatumKind::Bound(name) => {
                return self.task_ended(name, datum.span).and_then(plain);
            }
            DatumKind::List(items) if !items.is_empty() => items.as_slice(),
            _ => return self.no_condition(datum),
        };
        if let Some(keyword) = items.first().and_then(Datum::keyword) {
            return self.keyword_condition(datum, keyword, quality);
        }
        if let [head, task] = items
            && head.as_symbol().is_some_and(|word| OUTCOMES.contains(&word.folded()))
            && self.is_step(task)
        {
            let task = Expr { kind: self.task_named(task)?, place: task.span.place() };
            let state = Pattern::Literal(Value::symbol(datum.head_name()));
            return plain(ConditionKind::TaskState { task, state });
        }
        if self.report_infix(items) || self.report_near_condition(datum) || self.report_slipped_condition(datum) {
            return None;
        }
        match (datum.head_name(), items) {
            ("end" | "end-of" | "end_of" | "terminated", [_, task]) if task.as_variable().is_some() => {
                let name = task.as_variable()?;
                self.task_ended(name, task.span).and_then(plain)
            }
            ("state" | "task-state", [_, task, relation, state]) if relation.is("=") && self.is_task(items, task) => {
                self.task_state(task, state).and_then(plain)
            }
            _ if items.iter().skip(1).any(|item| relation_named(item).is_some()) => {
                self.short_measurement(datum, items).and_then(plain)
            }
            _ => {
                let pattern = self.pattern(datum)?;
                plain(ConditionKind::Event { pattern: pattern.into(), timing: Timing::default().into() })
            }
        }
    }

    fn no_condition<T>(&mut self, datum: &Datum) -> Option<T> {
        let mut diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, "this is not a condition");
        if let DatumKind::Unquote(_) = &datum.kind {
            let comma = Span { end: datum.span.start.saturating_add(1), ..datum.span };
            let fix = Fix::safe("remove the comma").replace(comma, "");
            return self.refuse(diagnostic.reason("conditions follow each other without commas").fix(fix));
        }
        diagnostic = match datum.as_symbol() {
            Some(name) if self.scope.tags.contains(name) => {
                diagnostic.fix(Fix::safe(format!("write `?{name}`")).insert_before(datum.span, "?"))
            }
            Some(name) => diagnostic.help(format!("an event is a list: `({name})`; the end of a step is `?tag`")),
            None => {
                diagnostic.help("a condition is a list such as `(ready camera-1)` or the variable of a step, `?s1`")
            }
        };
        self.refuse(diagnostic)
    }

    fn keyword_condition(&mut self, datum: &Datum, keyword: &str, quality: Option<&Datum>) -> Option<Condition> {
        let items = datum.tail();
        match keyword {
            "measurement" => self.measurement(datum, items),
            "episode" => self.episode(datum, items, quality),
            "atomic-episode" => self.atomic_episode(datum, items),
            "cyclic" => self.cyclic(datum, items),
            "delay" | "timestamp" | "function" => self.simple_condition(datum, keyword, items),
            _ if self.is_composite(keyword) => self.composite(datum, keyword, items),
            _ => {
                let diagnostic = Diagnostic::error(
                    codes::UNKNOWN_CONDITION,
                    datum.span,
                    format!("no condition is called `:{keyword}`"),
                );
                let span = datum.head_span();
                let mark = |name: &str| format!(":{name}");
                let fixes = renames_marked(span, keyword, CONDITION_KEYWORDS.iter().copied(), mark);
                self.refuse(
                    diagnostic.fixes_or_help(fixes, || format!("conditions are :{}", CONDITION_KEYWORDS.join(" :"))),
                )
            }
        }
    }

    fn simple_condition(&mut self, datum: &Datum, keyword: &str, items: &[Datum]) -> Option<Condition> {
        let (tag, items) = if keyword == "function" { (None, items) } else { self.time_tag(items) };
        let kind = match (keyword, items) {
            ("delay", [least]) => ConditionKind::Delay(self.span_of_time(least)?, None),
            ("delay", [least, most]) => {
                let (least, most) = (self.span_of_time(least), self.span_of_time(most));
                ConditionKind::Delay(least?, Some(most?))
            }
            ("timestamp", [start]) => ConditionKind::Timestamp(self.instant(start)?, None),
            ("timestamp", [start, end]) => {
                let (start, end) = (self.instant(start), self.instant(end));
                ConditionKind::Timestamp(start?, Some(end?))
            }
            ("function", [expression]) => ConditionKind::Function(self.expression(expression)?),
            _ => {
                let shape = match keyword {
                    "delay" => "(:delay [TAG] AT-LEAST [AT-MOST])",
                    "timestamp" => "(:timestamp [TAG] FROM [TO])",
                    _ => "(:function EXPRESSION)",
                };
                let message = format!("this `:{keyword}` condition has the wrong parts");
                let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, message)
                    .help(format!("its shape is `{shape}`"));
                return self.refuse(diagnostic);
            }
        };
        Some(Condition { tag, kind, place: datum.span.place() })
    }

    /// Splits off the tag of a `:delay` or `:timestamp`: a word before its times.
    fn time_tag<'d>(&mut self, items: &'d [Datum]) -> (Option<Symbol>, &'d [Datum]) {
        match items.split_first() {
            Some((Datum { kind: DatumKind::Symbol(name), span }, rest))
                if !rest.is_empty() && !name.folded().starts_with(':') && !self.names.is_operator(name) =>
            {
                self.scope.bind(name, *span);
                (Some(name.clone()), rest)
            }
            _ => (None, items),
        }
    }

    fn instant(&mut self, datum: &Datum) -> Option<Expr> {
        use super::expected::{Expected, ExpectedKind};
        let expr = self.expression(datum)?;
        self.conform(expr, datum.span, &Expected::plain("this instant", ExpectedKind::Instant))
    }

    /// Returns the end of the task that variable `name` holds.
    fn task_ended(&mut self, name: &Symbol, span: Span) -> Option<ConditionKind> {
        let is_known = self.scope.tags.contains(name) || self.scope.is_bound_everywhere(name);
        if !is_known {
            let message = format!("no step of this procedure is tagged `{name}`");
            if !self.scope.unknown_tags.insert(name.clone()) {
                return None;
            }
            if self.report_odd_tag(name, span) {
                return None;
            }
            let fixes = self.tags_for(name, span);
            let mut diagnostic = Diagnostic::error(codes::UNKNOWN_TAG, span, message).fixes(fixes);
            if diagnostic.fixes.is_empty() {
                let tags: Vec<String> =
                    self.scope.tags.keys_in_order().into_iter().take(12).map(|tag| format!("`?{tag}`")).collect();
                if !tags.is_empty() {
                    diagnostic = diagnostic.help(format!("its steps are {}", tags.join(" ")));
                }
            }
            if self.fragment && self.scope.tags.is_empty() {
                diagnostic.severity = self.undefined();
                self.report(diagnostic);
                return Some(ConditionKind::TaskEnded(name.clone()));
            }
            return self.refuse(diagnostic);
        }
        Some(ConditionKind::TaskEnded(name.clone()))
    }

    /// Returns true for conditions on states of tasks: always for `task-state`, and for `state` if its object is a step or this task.
    fn is_task(&self, items: &[Datum], task: &Datum) -> bool {
        let always = items.first().is_some_and(|head| head.is("task-state"));
        match &task.kind {
            DatumKind::Variable(name) | DatumKind::Bound(name) => always || self.scope.tags.contains(name),
            DatumKind::Indexical(name) => always || name.is("this-task"),
            _ => false,
        }
    }

    /// Returns true for the variable of a step.
    fn is_step(&self, task: &Datum) -> bool {
        matches!(&task.kind, DatumKind::Variable(name) | DatumKind::Bound(name) if self.scope.tags.contains(name))
    }

    /// Returns a task by its variable or indexical.
    fn task_named(&mut self, task: &Datum) -> Option<ExprKind> {
        match &task.kind {
            DatumKind::Indexical(name) => Some(self.indexical(name, task.span)),
            DatumKind::Variable(name) => self.variable(name, false, task.span),
            DatumKind::Bound(name) => self.variable(name, true, task.span),
            _ => self.no_condition(task),
        }
    }

    fn task_state(&mut self, task: &Datum, state: &Datum) -> Option<ConditionKind> {
        let kind = self.task_named(task)?;
        const STATES: &[&str] = &["pending", "enabled", "ongoing", "interrupted", "suspended", "terminated", "resumed"];
        if let Some(name) = state.as_symbol()
            && !STATES.contains(&name.folded())
            && !OUTCOME_STATES.contains(&name.folded())
        {
            let diagnostic =
                Diagnostic::error(codes::MALFORMED_CONDITION, state.span, format!("a task is never in state `{name}`"));
            let all = || STATES.iter().chain(OUTCOME_STATES).copied();
            let fixes = renames(state.span, name.printed(), all());
            let list = || {
                format!(
                    "its states are {}; the outcomes of an ended task are {}",
                    STATES.join(" "),
                    OUTCOME_STATES.join(" ")
                )
            };
            return self.refuse(diagnostic.fixes_or_help(fixes, list));
        }
        let task = Expr { kind, place: task.span.place() };
        Some(ConditionKind::TaskState { task, state: self.pattern(state)? })
    }

    /// Returns the optional tag before the rest of a condition, and the rest.
    pub(crate) fn condition_tag<'d>(&mut self, items: &'d [Datum]) -> (Option<Symbol>, &'d [Datum]) {
        match items {
            [tag, second, ..] if second.as_list().is_some() => {
                let name = match &tag.kind {
                    DatumKind::Symbol(name) if tag.keyword().is_none() => name,
                    DatumKind::Variable(name) => name,
                    _ => return (None, items),
                };
                self.scope.bind(name, tag.span);
                (Some(name.clone()), items.get(1..).unwrap_or_default())
            }
            _ => (None, items),
        }
    }

    /// Returns true for expressions that are tasks by their form; used where a clause accepts either.
    pub(crate) fn is_task_expression(&self, datum: &Datum) -> bool {
        match &datum.kind {
            DatumKind::Variable(_) | DatumKind::Bound(_) => true,
            DatumKind::Indexical(name) => name.is("this-task"),
            _ => false,
        }
    }

    /// Lowers a variable or indexical that holds a task.
    pub(crate) fn task_expression(&mut self, datum: &Datum) -> Option<Expr> {
        let expr = self.expression(datum)?;
        match expr.kind {
            ExprKind::Variable { .. } | ExprKind::Indexical(_) | ExprKind::Local(_) | ExprKind::Call { .. } => {
                Some(expr)
            }
            _ => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, "a task is needed here")
                    .help("write the variable of a step, `?s1`, or `+this-task+`");
                self.refuse(diagnostic)
            }
        }
    }
}
