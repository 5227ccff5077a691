//! Bodies of commands, and the orders that they give to the run.

use crate::operation::members;
use crate::operation::watch::SeenState;
use apex_model::effect::QuestionId;
use apex_model::event::EventKind;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use apex_runtime::authority::AuthorityRequest;
use apex_runtime::commands::Order;
use apex_runtime::reserved::{self, Entrance};
use apex_runtime::target_state::TARGET_VALUE_MAX;
use serde::Deserialize;
use serde_json::Value as Json;
use std::time::Duration;

/// Maximum pace. A flight as fast as possible has no pace.
const PACE_MAX: f64 = 1e6;
/// Maximum number of characters of a message.
const MESSAGE_MAX: usize = 2000;

/// The body of `POST /api/commands`.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) enum Wish {
    /// Stops mission time.
    Pause,
    /// Continues mission time at the last pace.
    Resume,
    /// Sets the mission seconds per second of wall time; `None` is as fast as possible.
    Pace {
        /// The pace.
        pace: Option<f64>,
    },
    /// Continues to the next instant at which something happens, then pauses.
    Step,
    /// Ends the flight.
    Stop,
    /// An answer to a question.
    Answer {
        /// The agent that asks.
        agent: String,
        /// The question's number.
        question: u64,
        /// One of its options as printed, or any answer if it has no options.
        answer: String,
    },
    /// A message, as a form of PDL.
    Message {
        /// The agent that receives it; `None` for all.
        #[cfg_attr(test, ts(optional))]
        agent: Option<String>,
        /// The form.
        form: String,
    },
    /// A target of the mission is to be observed from now on.
    AddTarget {
        /// Its id.
        target: String,
    },
    /// A target need not be observed any longer.
    RemoveTarget {
        /// Its id.
        target: String,
    },
    /// A target is worth another value.
    ValueTarget {
        /// Its id.
        target: String,
        /// The value.
        value: f64,
    },
    /// An operator has noticed an alarm.
    Acknowledge {
        /// The alarm, as text.
        alarm: String,
        /// Mission time in nanoseconds at which it was raised last.
        at_ns: i64,
        /// The signal that raised it; `None` for other alarms.
        #[cfg_attr(test, ts(optional))]
        signal: Option<String>,
    },
    /// The author holds authority over the flight from now on.
    TakeAuthority,
    /// Another actor may take authority.
    OfferAuthority {
        /// Its name.
        to: String,
    },
    /// Refuses the authority that is offered to the author.
    RefuseAuthority,
    /// Authority is free from now on.
    ReleaseAuthority,
}

/// Members of a body that each command may have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CommandTerms {
    /// The epoch of authority in which the command is given.
    pub(crate) epoch: Option<u64>,
    /// Time of the door's clock until which the run may accept the command.
    pub(crate) valid_until: Option<Duration>,
}

impl CommandTerms {
    fn take(body: &mut Json) -> Result<CommandTerms, String> {
        let Some(members) = body.as_object_mut() else { return Ok(CommandTerms::default()) };
        let mut stated = |name: &str| members.remove(name).filter(|value| !value.is_null());
        let epoch = match stated("epoch") {
            None => None,
            Some(epoch) => Some(epoch.as_u64().ok_or_else(|| format!("`epoch` is {epoch}; expected a whole number"))?),
        };
        let valid_until = match stated("until_ms") {
            None => None,
            Some(until) => {
                let refused =
                    || format!("`until_ms` is {until}; expected milliseconds of the clock of `/api/operation`");
                let until_s = until.as_f64().ok_or_else(refused)?.max(0.0) / 1e3;
                Some(Duration::try_from_secs_f64(until_s).map_err(|_| refused())?)
            }
        };
        Ok(CommandTerms { epoch, valid_until })
    }
}

impl Wish {
    /// Reads a body: a command with its terms.
    ///
    /// # Errors
    /// It is not a command, or has another member than the command.
    pub(crate) fn read(mut body: Json) -> Result<(Wish, CommandTerms), String> {
        members::check(body.as_object().ok_or("a command is an object")?)?;
        let terms = CommandTerms::take(&mut body)?;
        Ok((serde_json::from_value(body).map_err(|error| error.to_string())?, terms))
    }

    /// Returns the command as text, as recorded.
    pub(crate) fn words(&self) -> String {
        match self {
            Wish::Pause => "pause".into(),
            Wish::Resume => "resume".into(),
            Wish::Pace { pace: Some(pace) } => format!("pace {}", figure(*pace)),
            Wish::Pace { pace: None } => "pace as fast as possible".into(),
            Wish::Step => "step".into(),
            Wish::Stop => "stop".into(),
            Wish::Answer { agent, question, answer } => format!("answer {question} of {agent}: {answer}"),
            Wish::Message { agent: Some(agent), form } => format!("message to {agent}: {form}"),
            Wish::Message { agent: None, form } => format!("message: {form}"),
            Wish::AddTarget { target } => format!("add target {target}"),
            Wish::RemoveTarget { target } => format!("remove target {target}"),
            Wish::ValueTarget { target, value } => format!("value of target {target}: {}", figure(*value)),
            Wish::Acknowledge { alarm, .. } => format!("acknowledge {alarm}"),
            Wish::TakeAuthority => "take authority".into(),
            Wish::OfferAuthority { to } => format!("offer authority to {to}"),
            Wish::RefuseAuthority => "refuse authority".into(),
            Wish::ReleaseAuthority => "release authority".into(),
        }
    }

    /// Translates the command for a run with the observed state `seen`. A paused run continues at `running`; `known` returns whether a
    /// target is to be observed now, `None` for an unknown target.
    ///
    /// # Errors
    /// The reason for which the run would not execute it.
    pub(crate) fn order(
        &self,
        seen: &SeenState,
        running: Option<f64>,
        known: &dyn Fn(&str) -> Option<bool>,
        read: &dyn Fn(&str) -> Result<Value, String>,
    ) -> Result<Order, String> {
        match self {
            Wish::Pause => Ok(Order::Pace(Some(0.0))),
            Wish::Resume => Ok(Order::Pace(running)),
            Wish::Pace { pace: Some(pace) } if !(*pace > 0.0 && *pace <= PACE_MAX) => Err(format!(
                "a pace of {} is not above 0 and at most {PACE_MAX} mission seconds per second",
                figure(*pace)
            )),
            Wish::Pace { pace } => Ok(Order::Pace(*pace)),
            Wish::Step => Ok(Order::Step),
            Wish::Stop => Ok(Order::Stop),
            Wish::Acknowledge { alarm, .. } => Ok(Order::Acknowledge(alarm.clone())),
            Wish::TakeAuthority => Ok(Order::Authority(AuthorityRequest::Take)),
            Wish::OfferAuthority { to } => Ok(Order::Authority(AuthorityRequest::Offer(to.clone()))),
            Wish::RefuseAuthority => Ok(Order::Authority(AuthorityRequest::Refuse)),
            Wish::ReleaseAuthority => Ok(Order::Authority(AuthorityRequest::Release)),
            Wish::Answer { agent, question, answer } => answer_order(seen, (agent, *question), answer, read),
            Wish::Message { agent, form } => message_order(agent.as_deref(), form, read),
            Wish::AddTarget { target } => match known(target) {
                None => Err(format!("the mission has no target `{target}`")),
                Some(true) => Err(format!("`{target}` is a target of the flight already")),
                Some(false) => Ok(news("new-target", target, None)),
            },
            Wish::RemoveTarget { target } => {
                to_observe(known, target)?;
                Ok(news("target-gone", target, None))
            }
            Wish::ValueTarget { target, value } => {
                to_observe(known, target)?;
                if !(0.0..=TARGET_VALUE_MAX).contains(value) {
                    return Err(format!("the value {} is not from 0 to {TARGET_VALUE_MAX}", figure(*value)));
                }
                Ok(news("new-value", target, Some(*value)))
            }
        }
    }
}

/// Returns a number as text of bounded length.
fn figure(number: f64) -> String {
    match number.abs() {
        size if size == 0.0 || (1e-6..1e9).contains(&size) => number.to_string(),
        _ => format!("{number:e}"),
    }
}

fn to_observe(known: &dyn Fn(&str) -> Option<bool>, target: &str) -> Result<(), String> {
    match known(target) {
        None => Err(format!("the mission has no target `{target}`")),
        Some(false) => Err(format!("{target} is not to be observed at present")),
        Some(true) => Ok(()),
    }
}

fn news(head: &str, target: &str, value: Option<f64>) -> Order {
    let parts = [Value::symbol(head), Value::symbol(target)].into_iter().chain(value.map(Value::Real));
    Order::Input(None, EventKind::Occurrence(Value::list(parts)))
}

fn answer_order(
    seen: &SeenState,
    (agent, question): (&str, u64),
    answer: &str,
    read: &dyn Fn(&str) -> Result<Value, String>,
) -> Result<Order, String> {
    let of = |agent: &str| Symbol::new(agent);
    let open = seen.questions.iter().find(|open| open.question == question && of(&open.agent) == of(agent));
    let open = open.ok_or_else(|| format!("question {question} of {agent} is not open"))?;
    let value = if open.choices.is_empty() {
        match read(answer) {
            // A number keeps its type; every other answer is text.
            Ok(value @ (Value::Integer(_) | Value::Real(_) | Value::Quantity(_) | Value::Duration(_))) => value,
            _ => Value::text(answer),
        }
    } else {
        let same = |choice: &&Value| choice.to_string().eq_ignore_ascii_case(answer.trim());
        let printed: Vec<String> = open.choices.iter().map(Value::to_string).collect();
        let chosen = open.choices.iter().find(same);
        chosen
            .cloned()
            .ok_or_else(|| format!("the answer `{answer}` is not one of the options {}", printed.join(", ")))?
    };
    Ok(Order::Input(Some(of(agent)), EventKind::OperatorAnswered(QuestionId(question), value)))
}

fn message_order(
    agent: Option<&str>,
    form: &str,
    read: &dyn Fn(&str) -> Result<Value, String>,
) -> Result<Order, String> {
    if form.chars().count() > MESSAGE_MAX {
        return Err(format!("the message is longer than {MESSAGE_MAX} characters"));
    }
    let value = read(form).map_err(|error| format!("the message cannot be read: {error}"))?;
    if value.as_list().is_none_or(<[Value]>::is_empty) {
        return Err(format!("the message is {value}; expected a form, for example (new-value mill 20)"));
    }
    let kind = EventKind::Occurrence(value);
    reserved::check(&kind, Entrance::Outside)?;
    Ok(Order::Input(agent.map(Symbol::new), kind))
}
