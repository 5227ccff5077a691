//! Functions with effects: they occur in hooks only and become [`Action`]s.

use super::evaluator::{Evaluator, error};
use super::result::EvalResult;
use super::{Action, arithmetic, printed, strings};
use apex_model::event::StateVariable;
use apex_model::source::Place;
use apex_model::value::Value;

/// Calls the function with effects `name`; `None` if there is no such function.
pub(super) fn call(evaluator: &mut Evaluator<'_>, name: &str, arguments: &[Value], place: Place) -> Option<EvalResult> {
    let action = match (name, arguments) {
        ("inform", [form]) => Ok(Action::Inform(form.clone(), None)),
        ("inform", [form, router]) => Ok(Action::Inform(form.clone(), Some(router.clone()))),
        ("print", values) => strings::bounded(printed(values)).map(|_| Action::Print(printed(values))),
        ("command", [form]) => Ok(Action::Command { form: form.clone(), timeout: None, place }),
        ("command", [form, Value::Symbol(keyword), timeout]) if keyword.is(":timeout") => {
            let command = |timeout| Action::Command { form: form.clone(), timeout: Some(timeout), place };
            arithmetic::duration(timeout).map(command)
        }
        ("publish", [form, value, router @ ..]) if router.len() < 2 => state_variable(form)
            .map(|variable| Action::Publish { variable, value: value.clone(), router: router.first().cloned(), place }),
        ("replenish", [resource, amount @ ..]) if amount.len() < 2 => {
            Ok(Action::Replenish { resource: resource.clone(), amount: amount.first().cloned(), place })
        }
        ("complete", []) => Ok(Action::Complete(Value::nil())),
        ("complete", [value]) => Ok(Action::Complete(value.clone())),
        ("cogevent", [form]) => Ok(Action::Cogevent(form.clone(), None)),
        ("cogevent", [form, agent]) => Ok(Action::Cogevent(form.clone(), Some(agent.clone()))),
        ("end-application", []) => Ok(Action::EndApplication(None)),
        ("end-application", [reason]) => Ok(Action::EndApplication(Some(reason.clone()))),
        _ => return None,
    };
    Some(match action {
        Ok(action) => act(evaluator, name, action, place),
        Err(message) => Err(error(place, format!("({name} ..): {message}"))),
    })
}

/// Records `action`; returns nil, or the value that was completed, printed or published.
pub(super) fn act(evaluator: &mut Evaluator<'_>, name: &str, action: Action, place: Place) -> EvalResult {
    let Some(hook) = &mut evaluator.hook else {
        return Err(error(
            place,
            format!("({name} ..) has an effect and is allowed in hooks only, not in conditions or values"),
        ));
    };
    let value = match &action {
        Action::Complete(value) | Action::Publish { value, .. } => value.clone(),
        Action::Print(text) => Value::text(text),
        _ => Value::nil(),
    };
    hook.actions.push(action);
    Ok(value)
}

/// Returns the state variable named by `(ATTRIBUTE OBJECT..)`.
fn state_variable(form: &Value) -> Result<StateVariable, String> {
    match form.as_list() {
        Some([Value::Symbol(attribute), objects @ ..]) => {
            let object = match objects {
                [object] => object.clone(),
                several => Value::list(several.iter().cloned()),
            };
            Ok(StateVariable::new(attribute.clone(), object))
        }
        _ => Err(format!("expected a state variable such as (altitude uav-1), found {form}")),
    }
}
