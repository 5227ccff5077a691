//! Answers of an operator as JSON lines, for `apex run --answers`: `{"question": "go on", "value": "yes", "after": 3}`.
//!
//! Each line answers the first question whose text contains the words, in any case, `after` seconds later (default 0).

use crate::input_lines::{InputErrors, ReadValue, value_of};
use crate::limits::INPUT_MESSAGES_MAX;
use crate::run_settings::ScriptedAnswer;
use crate::unique_json;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use serde_json::Value as Json;

/// Reads the answers in `text`, called `name` in messages, in order.
///
/// # Errors
/// Every bad line with `name:line` and the error, up to a limit.
pub fn read_answers(name: &str, text: &str, read_value: ReadValue<'_>) -> Result<Vec<ScriptedAnswer>, InputErrors> {
    let (mut answers, mut faults) = (Vec::new(), Vec::new());
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    for (number, line) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        match read_line(line, read_value) {
            Ok(answer) => answers.push(answer),
            Err(fault) if faults.len() < INPUT_MESSAGES_MAX => faults.push(format!("{name}:{number}: {fault}")),
            Err(_) => {}
        }
    }
    if faults.is_empty() { Ok(answers) } else { Err(InputErrors(faults)) }
}

fn read_line(line: &str, read_value: ReadValue<'_>) -> Result<ScriptedAnswer, String> {
    let json = unique_json::parse(line).map_err(|error| format!("this is not JSON: {error}"))?;
    let Json::Object(fields) = json else {
        return Err(r#"expected an object like {"question": "go on", "value": "yes"}"#.into());
    };
    if let Some(stranger) = fields.keys().find(|key| !["question", "value", "after", "agent"].contains(&key.as_str())) {
        return Err(format!("\"{stranger}\" is not known; there are \"question\", \"value\", \"after\" and \"agent\""));
    }
    let text = |key: &str| match fields.get(key) {
        None => Ok(None),
        Some(Json::String(text)) => Ok(Some(text.clone())),
        Some(other) => Err(format!("\"{key}\" is {other}; expected words in a string")),
    };
    let question = text("question")?.ok_or("\"question\" is missing: words of the question's text")?;
    let value = value_of(fields.get("value").ok_or("\"value\" is missing: the answer")?, read_value)?;
    let after = match fields.get("after").map(Json::as_f64) {
        None => Duration::ZERO,
        Some(Some(seconds)) if (0.0..=9e9).contains(&seconds) => Duration::from_seconds(seconds),
        Some(_) => return Err("\"after\" is a number of seconds, 0 or more".into()),
    };
    Ok(ScriptedAnswer { question, agent: text("agent")?.map(|name| Symbol::new(&name)), value, after })
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::value::Value;

    #[test]
    fn answers_are_read_and_bad_lines_are_named() {
        let read = |text: &str| Ok(Value::symbol(text));
        let text = "# operator\n{\"question\": \"ready\", \"value\": \"yes\", \"after\": 2.5}\n{\"question\": \"x\", \"value\": 3}";
        let answers = read_answers("a.jsonl", text, &read).unwrap();
        assert_eq!((answers[0].after, &answers[0].value), (Duration::from_seconds(2.5), &Value::text("yes")));
        assert_eq!(answers[1].value, Value::Integer(3));
        let text = "{\"value\": 1}\n{\"question\": \"x\"}\n{\"question\": \"x\", \"value\": 1, \"when\": 3}\n[]\n{";
        let faults = read_answers("a.jsonl", text, &read).unwrap_err().0;
        assert_eq!(faults.len(), 5);
        assert!(faults[0].starts_with("a.jsonl:1: \"question\" is missing"), "{faults:?}");
        assert!(faults[2].contains("\"when\" is not known"), "{faults:?}");
    }
}
