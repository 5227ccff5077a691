//! Questions to the operator (TC)
//! What: asks a question, accepts the answer or the default, and withdraws the question of a task that no longer waits.
//! Runs: record and act phases.  Reads: arguments, OperatorAnswered, WakeQueue.  Writes: questions, effects, task outcome.
//! Bound: O(options) per answer.  PDL: `(ask operator ..)`, section 4.  Paper: section III, messages to and from operators.

use crate::control::cycle::Cycle;
use crate::control::tasks::termination;
use crate::expression::printed;
use crate::state::controller::{Controller, QuestionController};
use crate::state::wake::Wake;
use apex_model::because::{Because, Cause};
use apex_model::effect::{Effect, QuestionId};
use apex_model::source::Place;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::value::Value;

/// Executes `(ask operator QUESTION ..)` with the values of question, options, `by` and, if stated, default; the task waits.
///
/// # Errors
/// The cause when `:by` is neither an instant nor a duration.
pub(crate) fn ask(cycle: &mut Cycle<'_>, id: TaskId, values: &[Value], place: Place) -> Result<(), Because> {
    let value = |index: usize| values.get(index).cloned().unwrap_or_else(Value::nil);
    let by = match value(2) {
        Value::Time(at) => Some(at),
        Value::Duration(span) => Some(cycle.now + span),
        other if !other.is_true() => None,
        other => {
            let message = format!("`:by` takes an instant or a duration such as 30s, not {other}");
            return Err(Because::new(Cause::ExpressionFailed { message }, Some(place)));
        }
    };
    let controller = QuestionController {
        question: QuestionId(cycle.agent.next.question),
        open: false,
        text: printed(values.get(..1).unwrap_or_default()),
        options: value(1).as_list().map(<[Value]>::to_vec).unwrap_or_default(),
        by,
        default: values.get(3).cloned(),
        wake: None,
    };
    if let Some(task) = cycle.agent.task_mut(id) {
        task.controller = Some(Box::new(Controller::Question(controller)));
    }
    put(cycle, id);
    Ok(())
}

fn controller<'c>(cycle: &'c mut Cycle<'_>, id: TaskId) -> Option<&'c mut QuestionController> {
    match cycle.agent.task_mut(id)?.controller.as_deref_mut()? {
        Controller::Question(controller) => Some(controller),
        _ => None,
    }
}

/// Asks the task's question under a new number.
fn put(cycle: &mut Cycle<'_>, id: TaskId) {
    let (now, question) = (cycle.now, QuestionId(cycle.agent.next.question));
    let Some(state) = controller(cycle, id) else { return };
    state.question = question;
    state.open = true;
    let asked = state.clone();
    let wake = asked.by.map(|at| cycle.agent.wakes.schedule(at.max(now), Wake::Question(question)));
    if let Some(state) = controller(cycle, id) {
        state.wake = wake;
    }
    cycle.agent.next.question += 1;
    cycle.agent.questions.insert(question, id);
    let QuestionController { text, options, by, default, .. } = asked;
    cycle.effects.push(Effect::Ask { question, task: id, text, options, by, default });
}

/// Withdraws the question of an interrupted task. The operator's time continues to run.
pub(crate) fn pause(cycle: &mut Cycle<'_>, id: TaskId) {
    withdraw(cycle, id, "its task was interrupted");
}

/// Asks the question of a resumed task again under a new number, unless the operator's time has expired.
pub(crate) fn resume(cycle: &mut Cycle<'_>, id: TaskId) {
    let (now, ongoing) = (cycle.now, cycle.state(id) == TaskState::Ongoing);
    let Some(state) = controller(cycle, id).filter(|state| ongoing && !state.open) else { return };
    let (over, question) = (state.by.is_some_and(|by| by <= now), state.question);
    if over {
        go_without(cycle, id, question);
    } else {
        put(cycle, id);
    }
}

/// Takes the open question of the task back.
pub(crate) fn withdraw(cycle: &mut Cycle<'_>, id: TaskId, reason: &str) {
    let Some(state) = controller(cycle, id) else { return };
    let (open, question, wake) = (std::mem::take(&mut state.open), state.question, state.wake.take());
    if let Some(wake) = wake {
        cycle.agent.wakes.cancel(wake);
    }
    if cycle.agent.questions.remove(&question).is_some() && open {
        cycle.effects.push(Effect::WithdrawQuestion { question, reason: reason.to_string() });
    }
}

/// Handles the operator's answer. An answer that is not among the options is refused, and the question stays open.
pub(crate) fn answered(cycle: &mut Cycle<'_>, question: QuestionId, answer: &Value) {
    let Some(id) = cycle.agent.questions.get(&question).copied() else {
        let cause = if question.0 >= cycle.agent.next.question {
            Cause::StrayAnswer { to: format!("question {}", question.0) }
        } else {
            let message = format!("the answer {answer} came too late: question {} is no longer open", question.0);
            Cause::InputRefused { message }
        };
        return cycle.trouble_of(None, cause, None);
    };
    let place = cycle.place_of(id);
    let Some(state) = controller(cycle, id) else { return };
    let Some(value) = chosen(&state.options, answer) else {
        let options: Vec<String> = state.options.iter().map(Value::to_string).collect();
        let message = format!(
            "the answer {answer} to question {} is not one of {}; the question stays open",
            question.0,
            options.join(", ")
        );
        return cycle.trouble_of(Some(id), Cause::InputRefused { message }, place);
    };
    cycle.agent.questions.remove(&question);
    let cause = Cause::OperatorAnswered { question, answer: value.clone() };
    termination::end(cycle, id, Outcome::Success(value), Because::new(cause, place));
}

/// Returns the option that the answer denotes, or the answer itself if there are no options. An answer from outside is text, whereas
/// options are mostly symbols.
fn chosen(options: &[Value], answer: &Value) -> Option<Value> {
    if options.is_empty() {
        return Some(answer.clone());
    }
    let said = printed(std::slice::from_ref(answer));
    let same = |option: &&Value| {
        option.matches(answer) || printed(std::slice::from_ref(*option)).eq_ignore_ascii_case(said.trim())
    };
    options.iter().find(same).cloned()
}

/// Handles the end of the operator's time.
pub(crate) fn time_over(cycle: &mut Cycle<'_>, question: QuestionId) {
    if let Some(id) = cycle.agent.questions.get(&question).copied() {
        withdraw(cycle, id, "the operator's time is over");
        go_without(cycle, id, question);
    }
}

/// Uses the default answer, or fails the task if there is none.
fn go_without(cycle: &mut Cycle<'_>, id: TaskId, question: QuestionId) {
    let place = cycle.place_of(id);
    match controller(cycle, id).and_then(|state| state.default.clone()) {
        Some(default) => {
            let cause = Cause::OperatorSilent { question, default: default.clone() };
            termination::end(cycle, id, Outcome::Success(default), Because::new(cause, place));
        }
        None => termination::fail(cycle, id, Because::new(Cause::OperatorMute { question }, place)),
    }
}
