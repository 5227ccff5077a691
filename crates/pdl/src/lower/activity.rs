//! Activities of steps: goals and built-in activities (`pdl.md`, Steps).

use super::clauses::groups;
use super::expression::constant;
use super::{Lowering, NameKind};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use apex_model::expression::Expr;
use apex_model::procedure::{Activity, BuiltInActivity};
use apex_model::value::Value;

impl Lowering {
    /// Lowers an activity. `items` is the activity without a `=>` inside.
    pub(crate) fn activity(&mut self, datum: &Datum) -> Option<Activity> {
        let items = datum.tail();
        let only_task = matches!(items, [task] if self.is_task_expression(task));
        match datum.head_name() {
            "terminate" => self.terminate(datum, items),
            "reset" if only_task => self.task_activity(BuiltInActivity::Reset, items),
            "suspend" if only_task => self.task_activity(BuiltInActivity::Suspend, items),
            "resume" if only_task => self.task_activity(BuiltInActivity::Resume, items),
            "reprioritize" if only_task => self.task_activity(BuiltInActivity::Reprioritize, items),
            "cogevent" => self.form_activity(datum, BuiltInActivity::Cogevent, items),
            "inform" => self.form_activity(datum, BuiltInActivity::Inform, items),
            "hold-resource" => self.resource_activity(datum, BuiltInActivity::HoldResource, items),
            "release-resource" => self.resource_activity(datum, BuiltInActivity::ReleaseResource, items),
            "print" => {
                let arguments = self.pure("an activity", |lowering| lowering.body(items))?;
                Some(Activity::BuiltIn(BuiltInActivity::Print, arguments))
            }
            "end-application" if items.len() <= 1 => {
                let reason = self.pure("an activity", |lowering| lowering.body(items))?;
                Some(Activity::BuiltIn(BuiltInActivity::EndApplication, reason))
            }
            "ask" if items.first().is_some_and(|who| who.is("operator")) => self.ask(datum, items),
            "plan" if items.first().is_some_and(|goal| goal.head().is_some() || goal.as_variable().is_some()) => {
                self.plan(datum, items)
            }
            _ => self.goal(datum).map(Activity::Goal),
        }
    }

    /// Lowers `(terminate [task] [outcome] [>> value])`.
    fn terminate(&mut self, datum: &Datum, items: &[Datum]) -> Option<Activity> {
        let mark = items.iter().position(|item| item.is(">>")).unwrap_or(items.len());
        let (before, after) = items.split_at_checked(mark).unwrap_or((items, &[]));
        let value = match after {
            [] => None,
            [_, value] => Some(value),
            _ => return self.malformed_terminate(datum),
        };
        let (task, outcome) = match before {
            [] => (None, None),
            [one] if self.is_task_expression(one) => (Some(one), None),
            [one] => (None, Some(one)),
            [task, outcome] => (Some(task), Some(outcome)),
            _ => return self.malformed_terminate(datum),
        };
        self.pure("an activity", |lowering| {
            let task = task.map(|task| lowering.task_expression(task));
            let outcome = outcome.map(|outcome| lowering.expression(outcome));
            let value = value.map(|value| lowering.expression(value));
            let boxed = |part: Option<Option<Expr>>| swap(part).map(|part| part.map(Box::new));
            Some(Activity::Terminate { task: boxed(task)?, outcome: boxed(outcome)?, value: boxed(value)? })
        })
    }

    fn malformed_terminate<T>(&mut self, datum: &Datum) -> Option<T> {
        self.missing_part(
            datum.span,
            "this `terminate` has the wrong parts",
            "(terminate [?task] [outcome] [>> value])",
        )
    }

    fn task_activity(&mut self, which: BuiltInActivity, items: &[Datum]) -> Option<Activity> {
        let arguments = self.pure("an activity", |lowering| lowering.all(items, Lowering::task_expression))?;
        Some(Activity::BuiltIn(which, arguments))
    }

    fn form_activity(&mut self, datum: &Datum, which: BuiltInActivity, items: &[Datum]) -> Option<Activity> {
        let Some((form, rest)) = items.split_first().filter(|_| items.len() <= 2) else {
            let name = datum.head_name();
            let to = if which == BuiltInActivity::Inform { "router" } else { "agent" };
            let shape = format!("({name} FORM [{to}])");
            return self.missing_part(datum.span, &format!("this `{name}` has the wrong parts"), &shape);
        };
        if let (DatumKind::Symbol(word), [argument]) = (&form.kind, rest)
            && matches!(&argument.kind, DatumKind::Variable(_))
        {
            let span = form.span.to(argument.span);
            let message = format!("`{word}` is a message of one word, sent to a variable");
            let text = self.text_at(span).unwrap_or_default().to_string();
            let fix = Fix::look("put the message in brackets").replace(span, format!("({text})"));
            return self.refuse(Diagnostic::error(codes::MALFORMED, span, message).fix(fix));
        }
        let kind = if which == BuiltInActivity::Inform { NameKind::Router } else { NameKind::Agent };
        rest.iter().for_each(|name| self.use_name(kind, name));
        self.note_words(form);
        self.pure("an activity", |lowering| {
            let form = lowering.form(form);
            let rest = lowering.body(rest);
            let arguments = std::iter::once(form?).chain(rest?).collect();
            Some(Activity::BuiltIn(which, arguments))
        })
    }

    fn resource_activity(&mut self, datum: &Datum, which: BuiltInActivity, items: &[Datum]) -> Option<Activity> {
        if items.is_empty() {
            let name = datum.head_name();
            return self.missing_part(
                datum.span,
                &format!("`{name}` names no resource"),
                &format!("({name} RESOURCE..)"),
            );
        }
        let arguments = self.pure("an activity", |lowering| lowering.all(items, Lowering::form))?;
        Some(Activity::BuiltIn(which, arguments))
    }

    /// Lowers `(ask operator QUESTION [:options O..] [:by TIME] [:default VALUE])`.
    fn ask(&mut self, datum: &Datum, items: &[Datum]) -> Option<Activity> {
        let (before, options) = groups(items);
        let [_, question] = before else {
            let shape = "(ask operator QUESTION [:options CHOICE..] [:by TIME] [:default CHOICE])";
            return self.missing_part(datum.span, "this question has the wrong parts", shape);
        };
        self.check_groups(&options, &["options", "by", "default"], "`ask`")?;
        self.pure("an activity", |lowering| {
            let question = lowering.expression(question);
            let choices = lowering.choices(datum, super::clauses::values_of(&options, "options"));
            let by = lowering.optional(&options, "by", Lowering::expression);
            let default = lowering.optional(&options, "default", Lowering::form);
            let nil = || constant(Value::nil(), datum.span);
            let mut arguments = vec![question?, choices?, by?.unwrap_or_else(nil)];
            arguments.extend(default?);
            Some(Activity::BuiltIn(BuiltInActivity::AskOperator, arguments))
        })
    }

    /// Lowers choices: one list of them, one expression that returns it, or several in a row.
    fn choices(&mut self, datum: &Datum, values: &[Datum]) -> Option<Expr> {
        match values {
            [] => Some(constant(Value::nil(), datum.span)),
            [one] => match &one.kind {
                DatumKind::List(items)
                    if !items.first().and_then(Datum::as_symbol).is_some_and(|name| self.names.is_operator(name)) =>
                {
                    self.template_expression(one)
                }
                _ => self.expression(one),
            },
            [first, ..] => {
                let list = Datum { kind: DatumKind::List(values.to_vec()), span: super::span_of(values, first.span) };
                self.template_expression(&list)
            }
        }
    }

    /// Lowers `(plan GOAL [:with W] [:budget D])`.
    fn plan(&mut self, datum: &Datum, items: &[Datum]) -> Option<Activity> {
        let (before, options) = groups(items);
        let [goal] = before else {
            return self.missing_part(
                datum.span,
                "this `plan` has the wrong parts",
                "(plan GOAL [:with SOLVER] [:budget DURATION])",
            );
        };
        self.check_groups(&options, &["with", "budget"], "`plan`")?;
        self.pure("an activity", |lowering| {
            let goal = lowering.template_expression(goal);
            let with = lowering.optional(&options, "with", Lowering::form);
            let budget = lowering.optional(&options, "budget", Lowering::duration);
            let nil = || constant(Value::nil(), datum.span);
            let arguments = vec![goal?, with?.unwrap_or_else(nil), budget?.unwrap_or_else(nil)];
            Some(Activity::BuiltIn(BuiltInActivity::Plan, arguments))
        })
    }

    /// Splits `(activity.. => pattern)` at its `=>`.
    pub(crate) fn split_result<'d>(&mut self, datum: &'d Datum) -> Option<(Datum, Option<&'d Datum>)> {
        let items = datum.as_list().unwrap_or_default();
        let Some(mark) = items.iter().position(|item| item.is("=>")) else { return Some((datum.clone(), None)) };
        let (before, after) = items.split_at_checked(mark).unwrap_or((items, &[]));
        let [_, pattern] = after else {
            let span = items.get(mark).map_or(datum.span, |item| item.span);
            let diagnostic = Diagnostic::error(codes::MALFORMED, span, "`=>` is followed by one variable or pattern")
                .help("write `=> ?result` or `=> (?first ?second)`");
            return self.refuse(diagnostic);
        };
        Some((Datum { kind: DatumKind::List(before.to_vec()), span: datum.span }, Some(pattern)))
    }
}

/// Turns an optional result inside out: `Some(None)` if nothing was requested, `None` if lowering failed.
pub(crate) fn swap<T>(option: Option<Option<T>>) -> Option<Option<T>> {
    match option {
        None => Some(None),
        Some(Some(value)) => Some(Some(value)),
        Some(None) => None,
    }
}
