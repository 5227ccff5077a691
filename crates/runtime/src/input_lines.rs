//! Inputs as JSON lines: the format of `apex run --inputs`, also used by tests.
//!
//! `{"t": 1.5, "event": "(stop)"}`, `{"t": 2, "measurement": "(altitude ac-1)", "value": 32000}`,
//! `{"t": 9, "answer": 1, "value": "yes"}`; with `"agent": "pilot"` a line is for that agent alone.
//! `{"t": 9, "acknowledge": 3, "value": 7}` or `"error": "icing"`: outcome of command 3, or in a file of the next command
//! `"(take-picture camera-1)"`; `"progress": "accepted"` or `"in-progress"` states its progress. A value is a number, a string, true or
//! false, a list of values, or `{"pdl": "(fl 120)"}`. Empty lines and lines that begin with `#` are skipped. Lines need not be in order of
//! time.

use crate::limits::{INPUT_LINE_BYTES_MAX, INPUT_MESSAGES_MAX};
use crate::ports::Input;
use crate::reserved::{self, Entrance};
use crate::unique_json;
use apex_model::effect::{CommandId, QuestionId};
use apex_model::event::{CommandProgress, EventKind, StateVariable};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use serde_json::{Map, Value as Json};
use std::fmt;

/// Reads one PDL datum from text; the PDL front end is passed in so that this crate need not know it.
pub type ReadValue<'a> = &'a dyn Fn(&str) -> Result<Value, String>;

/// Errors of an input file, one sentence each with `file:line`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputErrors(pub Vec<String>);

impl fmt::Display for InputErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join("\n"))
    }
}

impl std::error::Error for InputErrors {}

/// Reads the inputs in `text`, called `name` in messages, ordered by time (lines of one time keep their order).
///
/// # Errors
/// Every bad line with `name:line` and the error, up to a limit.
pub fn read_inputs(name: &str, text: &str, read_value: ReadValue<'_>) -> Result<Vec<Input>, InputErrors> {
    let mut inputs = Vec::new();
    let mut faults = Vec::new();
    for (index, line) in text.lines().enumerate() {
        match read_numbered(name, index + 1, line, read_value) {
            Ok(input) => inputs.extend(input),
            Err(fault) => {
                faults.push(fault);
                if faults.len() == INPUT_MESSAGES_MAX {
                    faults.push(format!("{name}: further faults are not shown"));
                    break;
                }
            }
        }
    }
    if !faults.is_empty() {
        return Err(InputErrors(faults));
    }
    inputs.sort_by_key(|input: &Input| input.at);
    Ok(inputs)
}

/// Reads line `number` of a file; `None` for an empty line or a comment.
///
/// # Errors
/// The fault of the line, with `name:line`.
pub(crate) fn read_numbered(
    name: &str,
    number: usize,
    line: &str,
    read_value: ReadValue<'_>,
) -> Result<Option<Input>, String> {
    let line = line.trim();
    if line.is_empty() || line.starts_with('#') {
        return Ok(None);
    }
    read_line(line, read_value).map(Some).map_err(|fault| format!("{name}:{number}{fault}"))
}

/// Reads one line that arrives during a run; without `"t"` its instant is `now`.
///
/// # Errors
/// The fault of the line.
pub fn read_live(line: &str, now: Time, read_value: ReadValue<'_>) -> Result<Input, String> {
    read_fields(&object_of(line)?, now, read_value)
}

/// Reads one line that arrives during a run, whose instant is that of its arrival.
///
/// # Errors
/// The fault of the line; a line that states another instant is refused, and so is a message that only Apex sends.
pub(crate) fn read_arriving(line: &str, read_value: ReadValue<'_>) -> Result<Input, String> {
    let fields = object_of(line)?;
    if fields.contains_key("t") {
        let why =
            r#""t" is refused in a line that arrives during a run: its instant is that of its arrival; leave "t" out"#;
        return Err(why.into());
    }
    let input = read_fields(&fields, Time::ZERO, read_value)?;
    reserved::check(&input.kind, Entrance::Outside)?;
    Ok(input)
}

fn object_of(line: &str) -> Result<Map<String, Json>, String> {
    if line.len() > INPUT_LINE_BYTES_MAX {
        return Err(format!("the line is longer than {INPUT_LINE_BYTES_MAX} bytes"));
    }
    match unique_json::parse(line).map_err(|error| format!("this is not JSON: {error}"))? {
        Json::Object(fields) => Ok(fields),
        _ => Err(r#"expected an object like {"event": "(stop)"}"#.into()),
    }
}

/// Reads an input from the fields of a JSON object.
///
/// # Errors
/// The name of the field that is missing, unknown or malformed.
pub(crate) fn read_fields(fields: &Map<String, Json>, now: Time, read_value: ReadValue<'_>) -> Result<Input, String> {
    let at = if fields.contains_key("t") { time_of(fields)? } else { now };
    if let Some(Json::String(form)) = fields.get("acknowledge") {
        return Err(format!("\"acknowledge\" is {form:?}; expected the command's number, as the trace prints it"));
    }
    let (kind, agent) = (kind_of(fields, read_value)?, agent_of(fields)?);
    Ok(Input { at, kind, agent, command_form: None })
}

fn read_line(line: &str, read_value: ReadValue<'_>) -> Result<Input, String> {
    if line.len() > INPUT_LINE_BYTES_MAX {
        return Err(format!(": the line is longer than {INPUT_LINE_BYTES_MAX} bytes"));
    }
    let json = unique_json::parse(line).map_err(|error| json_fault(&error))?;
    let Json::Object(fields) = json else {
        return Err(r#": expected an object like {"t": 1.5, "event": "(stop)"}"#.into());
    };
    let at = time_of(&fields).map_err(|fault| format!(": {fault}"))?;
    let kind = kind_of(&fields, read_value).map_err(|fault| format!(": {fault}"))?;
    reserved::check(&kind, Entrance::Script).map_err(|fault| format!(": {fault}"))?;
    let agent = agent_of(&fields).map_err(|fault| format!(": {fault}"))?;
    let command_form = match fields.get("acknowledge") {
        Some(form @ Json::String(_)) => {
            let command = pdl("acknowledge", form, read_value).map_err(|fault| format!(": {fault}"))?;
            let is_form =
                matches!(&command, Value::List(items) if items.first().is_some_and(|head| head.as_symbol().is_some()));
            if !is_form {
                return Err(format!(
                    ": \"acknowledge\" is {form}; expected the form of a command, as in \"(take-picture camera-1)\""
                ));
            }
            Some(command)
        }
        _ => None,
    };
    Ok(Input { at, kind, agent, command_form })
}

/// Returns the reason of a JSON error without its place, which `serde_json` appends in this form; messages have the place in front.
pub fn json_reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    text.strip_suffix(&place).unwrap_or(&text).to_owned()
}

/// Returns the text of a JSON error with its column first, `:7: this is not JSON: expected ..`, as in `file:line:column`.
fn json_fault(error: &serde_json::Error) -> String {
    format!(":{}: this is not JSON: {}", error.column(), json_reason(error))
}

fn time_of(fields: &Map<String, Json>) -> Result<Time, String> {
    let Some(time) = fields.get("t") else { return Err("\"t\" is missing: seconds of mission time".into()) };
    match time.as_f64() {
        Some(seconds) if (0.0..=9e9).contains(&seconds) => Ok(Time::from_seconds(seconds)),
        Some(_) => Err(format!("\"t\" is {time}; mission time begins at 0 and is given in seconds")),
        None => Err(format!("\"t\" is {time}; expected a number of seconds")),
    }
}

/// Returns the agent of an input from its field `"agent"`; `None` addresses all agents.
fn agent_of(fields: &Map<String, Json>) -> Result<Option<Symbol>, String> {
    match fields.get("agent") {
        None => Ok(None),
        Some(Json::String(name)) if !name.is_empty() => Ok(Some(Symbol::new(name))),
        Some(other) => Err(format!("\"agent\" is {other}; expected the name of an agent")),
    }
}

fn kind_of(fields: &Map<String, Json>, read_value: ReadValue<'_>) -> Result<EventKind, String> {
    let subjects = ["event", "measurement", "answer", "acknowledge"];
    let given: Vec<&str> = subjects.into_iter().filter(|key| fields.contains_key(*key)).collect();
    let &[subject] = given.as_slice() else {
        return Err("expected exactly one of \"event\", \"measurement\", \"answer\" and \"acknowledge\"".into());
    };
    let stranger = fields.keys().find(|key| {
        !(*key == "t"
            || *key == "agent"
            || *key == subject
            || (*key == "value" && subject != "event")
            || (matches!(key.as_str(), "error" | "progress") && subject == "acknowledge"))
    });
    if let Some(stranger) = stranger {
        return Err(format!("\"{stranger}\" is not a known field next to \"{subject}\""));
    }
    let datum = fields.get(subject).unwrap_or(&Json::Null);
    if subject == "acknowledge" {
        return acknowledgement(fields, datum, read_value);
    }
    if subject == "event" {
        return Ok(EventKind::Occurrence(pdl(subject, datum, read_value)?));
    }
    let Some(value) = fields.get("value") else { return Err(format!("\"value\" is missing next to \"{subject}\"")) };
    let value = value_of(value, read_value)?;
    if subject == "measurement" {
        return Ok(EventKind::Measurement(variable(&pdl(subject, datum, read_value)?)?, value));
    }
    let question = datum.as_u64().ok_or_else(|| format!("\"answer\" is {datum}; expected the question's number"))?;
    Ok(EventKind::OperatorAnswered(QuestionId(question), value))
}

/// Reads `{"acknowledge": 3}`: with `"value"` the vehicle has executed command 3, with `"error"` it could not, and with `"progress"` the
/// command continues.
fn acknowledgement(fields: &Map<String, Json>, datum: &Json, read_value: ReadValue<'_>) -> Result<EventKind, String> {
    // An acknowledgement may identify its command by form, because the executive numbers commands only when it sends them.
    let command = match datum {
        Json::String(_) => u64::MAX,
        _ => datum.as_u64().ok_or_else(|| {
            format!("\"acknowledge\" is {datum}; expected the command's number, or its form in a string")
        })?,
    };
    if let Some(progress) = fields.get("progress") {
        if fields.contains_key("value") || fields.contains_key("error") {
            return Err("a command that continues has neither a \"value\" nor an \"error\"".into());
        }
        let progress = progress
            .as_str()
            .and_then(CommandProgress::named)
            .ok_or_else(|| format!("\"progress\" is {progress}; expected \"accepted\" or \"in-progress\""))?;
        return Ok(EventKind::CommandProgressed(CommandId(command), progress));
    }
    let result = match (fields.get("value"), fields.get("error")) {
        (None, None) => Ok(Value::nil()),
        (Some(value), None) => Ok(value_of(value, read_value)?),
        (None, Some(Json::String(reason))) => Err(reason.clone()),
        (None, Some(other)) => return Err(format!("\"error\" is {other}; expected the reason in a string")),
        (Some(_), Some(_)) => return Err("a command has a \"value\" or an \"error\", not both".into()),
    };
    Ok(EventKind::CommandAcknowledged(CommandId(command), result))
}

fn pdl(key: &str, datum: &Json, read_value: ReadValue<'_>) -> Result<Value, String> {
    let Json::String(text) = datum else { return Err(format!("\"{key}\" is {datum}; expected PDL text in a string")) };
    read_value(text).map_err(|message| format!("\"{key}\" cannot be read: {message}"))
}

fn variable(form: &Value) -> Result<StateVariable, String> {
    let (attribute, objects) = match form {
        Value::Symbol(attribute) => (attribute, &[][..]),
        _ => match form.as_list().and_then(<[Value]>::split_first) {
            Some((Value::Symbol(attribute), objects)) => (attribute, objects),
            _ => {
                return Err(format!(
                    "\"measurement\" is {form}; expected (ATTRIBUTE OBJECT), like (altitude aircraft-1)"
                ));
            }
        },
    };
    let object = match objects {
        [one] => one.clone(),
        several => Value::list(several.iter().cloned()),
    };
    Ok(StateVariable::new(attribute.clone(), object))
}

pub(crate) fn value_of(json: &Json, read_value: ReadValue<'_>) -> Result<Value, String> {
    match json {
        Json::Bool(truth) => Ok(Value::truth(*truth)),
        Json::String(text) => Ok(Value::text(text)),
        Json::Number(number) => number
            .as_i64()
            .map(Value::Integer)
            .or_else(|| number.as_f64().map(Value::Real))
            .ok_or_else(|| format!("the number {number} is out of range")),
        Json::Array(items) => {
            items.iter().map(|item| value_of(item, read_value)).collect::<Result<Vec<_>, _>>().map(Value::list)
        }
        Json::Object(fields) => match (fields.get("pdl"), fields.len()) {
            (Some(text), 1) => pdl("pdl", text, read_value),
            _ => Err(format!("the value {json} is not known; PDL is written {{\"pdl\": \"(..)\"}}")),
        },
        Json::Null => Err("null is not a value; write {\"pdl\": \"nil\"} for nil".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::time::Duration;

    /// Reads symbols and flat lists of symbols: enough for forms in tests.
    fn read(text: &str) -> Result<Value, String> {
        match text.strip_prefix('(') {
            None if text.is_empty() => Err("there is nothing to read".into()),
            None => Ok(Value::symbol(text)),
            Some(rest) => match rest.strip_suffix(')') {
                Some(words) => Ok(Value::list(words.split_whitespace().map(Value::symbol))),
                None => Err("`)` is missing".into()),
            },
        }
    }

    #[test]
    fn every_kind_of_line_is_read_and_ordered_by_time() {
        let text = r#"
            # a scenario
            {"t": 2, "measurement": "(altitude ac-1)", "value": 32000}
            {"t": 0.3, "event": "(stop)"}
            {"t": 2, "measurement": "(wind)", "value": [1.5, "calm", true, {"pdl": "(a b)"}]}
            {"t": 9, "answer": 1, "value": "yes"}
        "#;
        let inputs = read_inputs("in.jsonl", text, &read).unwrap();
        let said: Vec<String> = inputs.iter().map(|input| format!("{} {:?}", input.at.0, input.kind)).collect();
        assert_eq!(
            said,
            [
                "300000000 Occurrence((stop))",
                "2000000000 Measurement((altitude ac-1), 32000)",
                "2000000000 Measurement((wind), (1.5 \"calm\" t (a b)))",
                "9000000000 OperatorAnswered(QuestionId(1), \"yes\")",
            ]
        );
        assert_eq!(inputs[0].at - Time::ZERO, Duration(300_000_000), "0.3 s is exact");
    }

    #[test]
    fn every_bad_line_is_named_with_its_reason() {
        let text = r#"{"t": 1, "event": "(stop"}
{"t": 1, "event" "(stop)"}
{"event": "(stop)"}
{"t": -1, "event": "(stop)"}
{"t": "soon", "event": "(stop)"}
{"t": 1}
{"t": 1, "event": "(stop)", "value": 3}
{"t": 1, "measurement": "(altitude ac-1)"}
{"t": 1, "measurement": 7, "value": 3}
{"t": 1, "measurement": "(altitude ac-1)", "value": null}
{"t": 1, "answer": "one", "value": 3}
[1]"#;
        let faults = read_inputs("in.jsonl", text, &read).unwrap_err().0;
        let expected = [
            "in.jsonl:1: \"event\" cannot be read: `)` is missing",
            "in.jsonl:2:18: this is not JSON: expected `:`",
            "in.jsonl:3: \"t\" is missing: seconds of mission time",
            "in.jsonl:4: \"t\" is -1; mission time begins at 0 and is given in seconds",
            "in.jsonl:5: \"t\" is \"soon\"; expected a number of seconds",
            "in.jsonl:6: expected exactly one of \"event\", \"measurement\", \"answer\" and \"acknowledge\"",
            "in.jsonl:7: \"value\" is not a known field next to \"event\"",
            "in.jsonl:8: \"value\" is missing next to \"measurement\"",
            "in.jsonl:9: \"measurement\" is 7; expected PDL text in a string",
            "in.jsonl:10: null is not a value; write {\"pdl\": \"nil\"} for nil",
            "in.jsonl:11: \"answer\" is \"one\"; expected the question's number",
            "in.jsonl:12: expected an object like {\"t\": 1.5, \"event\": \"(stop)\"}",
        ];
        assert_eq!(faults, expected);
    }

    #[test]
    fn a_json_fault_keeps_words_that_look_like_its_place() {
        let text = r#"{"t": 1, "seen at line 3": 1, "seen at line 3": 2}"#;
        let faults = read_inputs("in.jsonl", text, &read).unwrap_err().0;
        assert_eq!(faults, ["in.jsonl:1:46: this is not JSON: the key `seen at line 3` is given twice"]);
    }

    #[test]
    fn a_file_of_another_format_does_not_flood_the_screen() {
        let faults = read_inputs("in.csv", &"1,2,3\n".repeat(1000), &read).unwrap_err().0;
        assert_eq!(faults.len(), INPUT_MESSAGES_MAX + 1);
    }
}
