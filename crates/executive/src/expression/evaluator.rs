//! The evaluator: forms, local variables, calls, limits.

use super::higher_order;
use super::result::EvalResult;
use super::{
    Action, EvalContext, EvaluationError, arithmetic, effects, history_queries, lists, strings, time_functions,
};
use crate::state::bindings::Bindings;
use apex_model::builtins::built_in;
use apex_model::event::StateVariable;
use apex_model::expression::{Closure, Expr, ExprKind, Parameters};
use apex_model::host::HostFunction;
use apex_model::limits::{EVALUATION_DEPTH_MAX, EVALUATION_STEPS_MAX};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use smallvec::SmallVec;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// One evaluation: its context, its local variables, and the used part of its limits.
pub(super) struct Evaluator<'a> {
    pub(super) context: &'a dyn EvalContext,
    /// Local variables, innermost last.
    scope: Vec<(Symbol, Value)>,
    /// Index of the first variable of the current function.
    frame: usize,
    depth: u32,
    steps: u64,
    /// Set inside hooks: receives the actions.
    pub(super) hook: Option<Hook<'a>>,
}

/// State that a hook may change.
pub(super) struct Hook<'a> {
    pub(super) locals: &'a mut Bindings,
    pub(super) actions: &'a mut Vec<Action>,
    /// Task variables that this hook has assigned: later forms see the new values.
    pub(super) assigned: Bindings,
}

/// Returns an error at `place`.
pub(super) fn error(place: Place, message: impl Into<String>) -> EvaluationError {
    EvaluationError { message: message.into(), place }
}

impl<'a> Evaluator<'a> {
    pub(super) fn new(context: &'a dyn EvalContext, hook: Option<Hook<'a>>) -> Evaluator<'a> {
        Evaluator { context, scope: Vec::new(), frame: 0, depth: 0, steps: 0, hook }
    }

    /// Charges `steps` units of work.
    pub(super) fn charge(&mut self, steps: u64, place: Place) -> Result<(), EvaluationError> {
        self.steps = self.steps.saturating_add(steps);
        if self.steps > EVALUATION_STEPS_MAX {
            return Err(error(
                place,
                format!("the evaluation takes more than EVALUATION_STEPS_MAX = {EVALUATION_STEPS_MAX} steps"),
            ));
        }
        Ok(())
    }

    /// Returns the value of `expr`.
    pub(super) fn value(&mut self, expr: &Expr) -> EvalResult {
        match &expr.kind {
            ExprKind::Constant(value) => return Ok(value.clone()),
            ExprKind::Variable { name, .. } => return self.variable(name, expr.place),
            ExprKind::Local(name) => return self.local(name, expr.place),
            _ => {}
        }
        self.charge(1, expr.place)?;
        if self.depth >= EVALUATION_DEPTH_MAX {
            return Err(error(
                expr.place,
                format!("the evaluation is nested deeper than EVALUATION_DEPTH_MAX = {EVALUATION_DEPTH_MAX}"),
            ));
        }
        self.depth += 1;
        let result = self.form(expr);
        self.depth -= 1;
        result
    }

    /// Returns the last form's value; nil without forms.
    pub(super) fn body(&mut self, forms: &[Expr]) -> EvalResult {
        let mut last = Value::nil();
        for form in forms {
            last = self.value(form)?;
        }
        Ok(last)
    }

    fn form(&mut self, expr: &Expr) -> EvalResult {
        match &expr.kind {
            ExprKind::Constant(value) => Ok(value.clone()),
            ExprKind::Variable { name, .. } => self.variable(name, expr.place),
            ExprKind::Local(name) => self.local(name, expr.place),
            ExprKind::Indexical(name) => self.indexical(name, expr.place),
            ExprKind::Named(name) => match self.context.library().constants.get(name) {
                Some(definition) => self.in_frame(Vec::new(), |evaluator| evaluator.value(definition)),
                None => Err(error(expr.place, format!("the constant {name} is not defined"))),
            },
            ExprKind::Call { function, arguments } => {
                let mut values = SmallVec::<[Value; 4]>::with_capacity(arguments.len());
                for argument in arguments {
                    values.push(self.value(argument)?);
                }
                self.call(function, &values, expr.place)
            }
            ExprKind::If(test, then, otherwise) => match (self.value(test)?.is_true(), otherwise) {
                (true, _) => self.value(then),
                (false, Some(otherwise)) => self.value(otherwise),
                (false, None) => Ok(Value::nil()),
            },
            ExprKind::Cond(clauses) => self.cond(clauses),
            ExprKind::Case(key, clauses) => {
                let key = self.value(key)?;
                let chosen =
                    clauses.iter().find(|(data, _)| data.is_empty() || data.iter().any(|datum| datum.equals(&key)));
                chosen.map_or(Ok(Value::nil()), |(_, forms)| self.body(forms))
            }
            ExprKind::And(parts) => {
                let mut last = Value::truth(true);
                for part in parts {
                    last = self.value(part)?;
                    if !last.is_true() {
                        break;
                    }
                }
                Ok(last)
            }
            ExprKind::Or(parts) => {
                for part in parts {
                    let value = self.value(part)?;
                    if value.is_true() {
                        return Ok(value);
                    }
                }
                Ok(Value::nil())
            }
            ExprKind::Let { sequential, bindings, body } => self.bind(*sequential, bindings, body),
            ExprKind::Lambda { parameters, body } => Ok(Value::Closure(Arc::new(Closure {
                parameters: parameters.clone(),
                body: body.clone(),
                captured: self.scope.get(self.frame..).unwrap_or_default().to_vec(),
                place: expr.place,
            }))),
            ExprKind::FunctionName(name) => Ok(Value::Symbol(name.clone())),
            ExprKind::Assign { name, of_task, value } => {
                let value = self.value(value)?;
                self.assign(name, *of_task, value, expr.place)
            }
            ExprKind::Sequence(forms) => self.body(forms),
            ExprKind::Template(template) => self.template(template, expr.place),
        }
    }

    /// Returns the value of `variable` that was published at this instant and is not in its history yet: by earlier forms of this clause,
    /// or by clauses that were evaluated earlier.
    fn published(&self, variable: &StateVariable) -> Option<Value> {
        let context = self.context;
        let own = self.hook.as_ref().and_then(|hook| {
            hook.actions.iter().rev().find_map(|action| match action {
                Action::Publish { variable: of, value, router, .. }
                    if of == variable && !router.as_ref().is_some_and(Value::is_true) =>
                {
                    super::declared_unit::in_declared_unit(context.library(), variable, value.clone()).ok()
                }
                _ => None,
            })
        });
        own.or_else(|| context.published(variable)).filter(|value| !is_missing(value))
    }

    fn cond(&mut self, clauses: &[(Expr, Vec<Expr>)]) -> EvalResult {
        for (test, forms) in clauses {
            let value = self.value(test)?;
            if value.is_true() {
                return if forms.is_empty() { Ok(value) } else { self.body(forms) };
            }
        }
        Ok(Value::nil())
    }

    fn bind(&mut self, sequential: bool, bindings: &[(Symbol, Expr)], body: &[Expr]) -> EvalResult {
        let depth = self.scope.len();
        let mut values = Vec::new();
        for (name, initial) in bindings {
            match self.value(initial) {
                Ok(value) if sequential => self.scope.push((name.clone(), value)),
                Ok(value) => values.push((name.clone(), value)),
                Err(error) => {
                    self.scope.truncate(depth);
                    return Err(error);
                }
            }
        }
        self.scope.append(&mut values);
        let result = self.body(body);
        self.scope.truncate(depth);
        result
    }

    fn variable(&self, name: &Symbol, place: Place) -> EvalResult {
        let assigned = self.hook.as_ref().and_then(|hook| hook.assigned.get(name)).cloned();
        assigned
            .or_else(|| self.context.variable(name))
            .ok_or_else(|| error(place, format!("?{name} has no value here")))
    }

    fn local(&self, name: &Symbol, place: Place) -> EvalResult {
        let own = self.scope.get(self.frame..).unwrap_or_default().iter().rev().find(|(each, _)| each == name);
        own.map(|(_, value)| value.clone())
            .or_else(|| self.hook.as_ref().and_then(|hook| hook.locals.get(name)).cloned())
            .or_else(|| self.context.local(name))
            .ok_or_else(|| error(place, format!("{name} has no value here")))
    }

    fn assign(&mut self, name: &Symbol, of_task: bool, value: Value, place: Place) -> EvalResult {
        if of_task {
            let Some(hook) = &mut self.hook else {
                return Err(error(place, format!("(setq ?{name} ..) changes the task and is allowed in hooks only")));
            };
            hook.assigned.set(name.clone(), value.clone());
            hook.actions.push(Action::SetTaskVariable(name.clone(), value.clone()));
            return Ok(value);
        }
        let frame = self.frame;
        let own = self.scope.get_mut(frame..).unwrap_or_default().iter_mut().rev().find(|(each, _)| each == name);
        if let Some((_, slot)) = own {
            *slot = value.clone();
            return Ok(value);
        }
        match &mut self.hook {
            Some(hook) => hook.locals.set(name.clone(), value.clone()),
            None => return Err(error(place, format!("(setq {name} ..): {name} is not a variable of this form"))),
        }
        Ok(value)
    }

    fn indexical(&mut self, name: &Symbol, place: Place) -> EvalResult {
        let context = self.context;
        let no_task = || error(place, format!("+{name}+ has no meaning outside of a task"));
        match name.folded() {
            "now" => return Ok(Value::Time(context.now())),
            "self" => return Ok(Value::Symbol(context.agent_name().clone())),
            "this-task" => return context.this_task().map(Value::Task).ok_or_else(no_task),
            "tot" => {
                let task = context.this_task().ok_or_else(no_task)?;
                return Ok(Value::Duration(context.task_time_ongoing(task).unwrap_or(Duration::ZERO)));
            }
            "met" => return Ok(Value::Duration(context.now() - apex_model::time::Time::ZERO)),
            "mission-start" => return Ok(Value::Time(apex_model::time::Time::ZERO)),
            "beginning-of-time" => return Ok(Value::Time(apex_model::time::Time::BEGINNING)),
            "end-of-time" => return Ok(Value::Time(apex_model::time::Time::END)),
            "pos-infinity" => return Ok(Value::Real(f64::INFINITY)),
            _ => {}
        }
        let Some(definition) = context.library().indexicals.get(name) else {
            return Err(error(place, format!("+{name}+ is not defined; (defindexical +{name}+ EXPR) defines it")));
        };
        self.in_frame(Vec::new(), |evaluator| evaluator.value(definition))
    }

    /// Runs `action` with only `variables` as local variables.
    fn in_frame(
        &mut self,
        variables: Vec<(Symbol, Value)>,
        action: impl FnOnce(&mut Self) -> EvalResult,
    ) -> EvalResult {
        let (frame, length) = (self.frame, self.scope.len());
        self.frame = length;
        self.scope.extend(variables);
        let result = action(self);
        self.scope.truncate(length);
        self.frame = frame;
        result
    }

    /// Calls the function named `function`.
    pub(super) fn call(&mut self, function: &Symbol, arguments: &[Value], place: Place) -> EvalResult {
        let name = function.folded();
        self.charge(lists::cost(name, arguments), place)?;
        // Inside hooks, functions with effects are the most frequent; no other family has functions of the same names.
        if self.hook.is_some()
            && let Some(result) = effects::call(self, name, arguments, place)
        {
            return result;
        }
        let built_in = arithmetic::call(name, arguments)
            .or_else(|| lists::call(name, arguments))
            .or_else(|| strings::call(name, arguments))
            .or_else(|| time_functions::call(name, arguments, self.context))
            .or_else(|| history_queries::call(name, arguments, self.context, &|variable| self.published(variable)));
        if let Some(result) = built_in {
            return result.map_err(|message| error(place, format!("({function} ..): {message}")));
        }
        if let Some(result) = higher_order::call(self, name, arguments, place) {
            return result;
        }
        if let Some(result) = effects::call(self, name, arguments, place) {
            return result;
        }
        let context = self.context;
        if let Some(defined) = context.library().functions.get(function) {
            return self.apply(function.folded(), &defined.parameters, &defined.body, &[], arguments, place);
        }
        if context.library().host_functions.get(function).is_some_and(|declared| declared.command) {
            let form = Value::list(std::iter::once(Value::Symbol(function.clone())).chain(arguments.iter().cloned()));
            return effects::act(self, name, Action::Command { form, timeout: None, place }, place);
        }
        match context.host().get(function) {
            Some(host) => {
                contained(host, arguments).map_err(|message| error(place, format!("({function} ..): {message}")))
            }
            None => Err(error(place, not_callable(function, arguments))),
        }
    }

    /// Calls a function value: a closure or a function's name.
    pub(super) fn call_value(&mut self, function: &Value, arguments: &[Value], place: Place) -> EvalResult {
        match function {
            Value::Closure(closure) => {
                self.apply("lambda", &closure.parameters, &closure.body, &closure.captured, arguments, place)
            }
            Value::Symbol(name) => {
                self.charge(1, place)?;
                // A call through a name nests as deep as a call that is written.
                if self.depth >= EVALUATION_DEPTH_MAX {
                    return Err(error(
                        place,
                        format!("calls are nested deeper than EVALUATION_DEPTH_MAX = {EVALUATION_DEPTH_MAX}"),
                    ));
                }
                self.depth += 1;
                let result = self.call(name, arguments, place);
                self.depth -= 1;
                result
            }
            other => Err(error(place, format!("expected a function such as #'+ or (lambda (x) ..), found {other}"))),
        }
    }

    fn apply(
        &mut self,
        name: &str,
        parameters: &Parameters,
        body: &[Expr],
        captured: &[(Symbol, Value)],
        arguments: &[Value],
        place: Place,
    ) -> EvalResult {
        let (least, most) = (parameters.arguments_min(), parameters.arguments_max());
        if arguments.len() < least || most.is_some_and(|most| arguments.len() > most) {
            let wanted = match most {
                Some(most) if most == least => format!("{least}"),
                Some(most) => format!("{least} to {most}"),
                None => format!("at least {least}"),
            };
            let plural = if most.unwrap_or(least) == 1 { "" } else { "s" };
            return Err(error(place, format!("{name} takes {wanted} argument{plural}, not {}", arguments.len())));
        }
        let given = parameters.required.iter().chain(parameters.optional.iter().map(|(name, _)| name));
        let given = given.cloned().zip(arguments.iter().cloned());
        let variables: Vec<(Symbol, Value)> = captured.iter().cloned().chain(given).collect();
        self.charge(variables.len() as u64, place)?;
        self.in_frame(variables, |evaluator| {
            let left_out = parameters.optional.iter().skip(arguments.len().saturating_sub(least));
            for (name, default) in left_out {
                let value = default.as_ref().map_or(Ok(Value::nil()), |default| evaluator.value(default))?;
                evaluator.scope.push((name.clone(), value));
            }
            if let Some(name) = &parameters.rest {
                let further = arguments.iter().skip(least + parameters.optional.len()).cloned();
                evaluator.scope.push((name.clone(), Value::list(further)));
            }
            evaluator.body(body)
        })
    }
}

/// Returns true for NaN, which represents a missing measurement.
fn is_missing(value: &Value) -> bool {
    value.as_number().is_some_and(|(number, _)| number.is_nan())
}

/// Calls a function of the host program. If it panics, the call fails and the agent continues.
fn contained(host: &HostFunction, arguments: &[Value]) -> Result<Value, String> {
    let outcome = catch_unwind(AssertUnwindSafe(|| host(arguments)));
    outcome.unwrap_or_else(|payload| {
        let said = payload.downcast_ref::<&str>().map(ToString::to_string);
        let said = said.or_else(|| payload.downcast_ref::<String>().cloned());
        let said = said.map(|said| format!(": {said}")).unwrap_or_default();
        Err(format!("the function of the host program panicked{said}; this is a fault of that function"))
    })
}

fn not_callable(function: &Symbol, arguments: &[Value]) -> String {
    match built_in(function.folded()) {
        Some(known) => {
            format!(
                "{function} does not take these arguments: {}; it takes {}",
                super::printed(arguments),
                known.summary
            )
        }
        None => format!("there is no function {function}; (defun {function} ..) defines one"),
    }
}
