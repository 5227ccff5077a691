//! Lines that arrive during a run: inputs, forms, answers to open questions, `stop`.

use crate::input_lines::{ReadValue, read_arriving};
use crate::reserved::{self, Entrance};
use crate::run_settings::Control;
use apex_executive::Agent;
use apex_model::effect::QuestionId;
use apex_model::event::EventKind;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::sync::{Arc, Mutex, PoisonError};

/// A question on the terminal.
#[derive(Clone)]
struct Open {
    agent: Symbol,
    question: QuestionId,
    text: String,
}

/// Questions that wait for an answer. Clones share one list.
#[derive(Clone, Default)]
pub struct OpenQuestions(Arc<Mutex<Vec<Open>>>);

impl OpenQuestions {
    /// Adds a question of an agent.
    pub fn opened(&self, agent: Symbol, question: QuestionId, text: &str) {
        self.with(|open| open.push(Open { agent, question, text: text.to_string() }));
    }

    /// Removes the questions of an agent that are no longer open.
    pub fn keep_those_of(&self, agent: &Agent) {
        self.with(|open| {
            open.retain(|each| each.agent != agent.name || agent.questions.contains_key(&each.question));
        });
    }

    /// Reads a line: `{"event": "(go)"}`, `(go)`, `yes`, `2: yes`, `pilot/2: yes`, `stop`. The line `stop` is never an answer: a run can
    /// always be stopped; `2: stop` answers with this word.
    ///
    /// # Errors
    /// The reason if the line is neither an input nor an answer to an open question.
    pub fn understand(&self, line: &str, read_value: ReadValue<'_>) -> Result<Control, String> {
        if line.starts_with('{') {
            let input = read_arriving(line, read_value)?;
            return Ok(match input.agent {
                Some(agent) => Control::InputFor(agent, input.kind),
                None => Control::Input(input.kind),
            });
        }
        if line.starts_with('(') {
            let kind = EventKind::Occurrence(read_value(line)?);
            reserved::check(&kind, Entrance::Outside)?;
            return Ok(Control::Input(kind));
        }
        if line == "stop" {
            return Ok(Control::Stop);
        }
        let (number, words) = match line.split_once(':') {
            Some((number, words)) if number.trim().ends_with(|last: char| last.is_ascii_digit()) => {
                (Some(number.trim()), words.trim())
            }
            _ => (None, line),
        };
        let found = self.with(|open| {
            let named = |each: &&Open| {
                let own = each.question.0.to_string();
                number.is_none_or(|number| number == own || number == format!("{}/{own}", each.agent))
            };
            open.iter().filter(named).cloned().collect::<Vec<_>>()
        });
        match found.as_slice() {
            [one] => {
                let value = match read_value(words) {
                    Ok(value @ (Value::Integer(_) | Value::Real(_) | Value::Quantity(_) | Value::Duration(_))) => value,
                    _ => Value::text(words),
                };
                Ok(Control::InputFor(one.agent.clone(), EventKind::OperatorAnswered(one.question, value)))
            }
            [] => Err(format!("no question is open that `{line}` could answer; events are written (go) or as JSON")),
            several => {
                let list: Vec<String> =
                    several.iter().map(|each| format!("{}/{}: {}", each.agent, each.question.0, each.text)).collect();
                Err(format!("several questions are open, write NUMBER: ANSWER; {}", list.join("; ")))
            }
        }
    }

    fn with<T>(&self, work: impl FnOnce(&mut Vec<Open>) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads the words of PDL that the tests need.
    fn read_value(text: &str) -> Result<Value, String> {
        match text.strip_prefix('(').and_then(|text| text.strip_suffix(')')) {
            Some(words) => Ok(Value::list(words.split(' ').map(Value::symbol))),
            None => Ok(text.parse().map_or_else(|_| Value::symbol(text), Value::Integer)),
        }
    }

    fn open(questions: &[(&str, u64)]) -> OpenQuestions {
        let open = OpenQuestions::default();
        for (agent, number) in questions {
            open.opened(Symbol::new(agent), QuestionId(*number), "Ready?");
        }
        open
    }

    #[test]
    fn words_answer_the_open_question() {
        let answer = |agent: &str, number, value| {
            Ok(Control::InputFor(Symbol::new(agent), EventKind::OperatorAnswered(QuestionId(number), value)))
        };
        assert_eq!(open(&[("a", 3)]).understand("yes", &read_value), answer("a", 3, Value::text("yes")));
        assert_eq!(open(&[("a", 3)]).understand("12", &read_value), answer("a", 3, Value::Integer(12)));
        let two = open(&[("a", 0), ("b", 0)]);
        assert!(two.understand("yes", &read_value).unwrap_err().contains("a/0: Ready?; b/0: Ready?"));
        assert_eq!(two.understand("b/0: no", &read_value), answer("b", 0, Value::text("no")));
        assert!(open(&[]).understand("yes", &read_value).unwrap_err().contains("no question is open"));
        assert_eq!(open(&[]).understand("stop", &read_value), Ok(Control::Stop));
        assert_eq!(open(&[("a", 3)]).understand("stop", &read_value), Ok(Control::Stop), "a run can always be stopped");
        assert_eq!(open(&[("a", 3)]).understand("3: stop", &read_value), answer("a", 3, Value::text("stop")));
    }

    #[test]
    fn forms_and_objects_are_inputs() {
        assert!(matches!(open(&[]).understand("(go)", &read_value), Ok(Control::Input(EventKind::Occurrence(_)))));
        let line = r#"{"agent": "b", "measurement": "(altitude uav)", "value": 3}"#;
        assert!(matches!(open(&[]).understand(line, &read_value), Ok(Control::InputFor(..))));
        assert!(open(&[]).understand("{", &read_value).unwrap_err().contains("not JSON"));
        let line = r#"{"t": 1e6, "measurement": "(altitude uav)", "value": 3}"#;
        assert!(open(&[]).understand(line, &read_value).unwrap_err().contains("that of its arrival"));
        for line in ["(operator-command 5)", r#"{"event": "(authority 99)"}"#] {
            assert!(open(&[]).understand(line, &read_value).unwrap_err().contains("only Apex sends"), "{line}");
        }
    }
}
