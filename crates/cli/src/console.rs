//! People and programs that speak while a run goes on: lines from standard input or a port, questions on the terminal,
//! Ctrl-C.

use crate::output;
use crate::trouble::{Outcome, Trouble};
use apex_executive::state::agent::Agent;
use apex_model::effect::{DecisionKind, Effect, QuestionId};
use apex_model::event::{Batch, EventKind};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::Control;
use apex_runtime::input_lines::read_live;
use apex_runtime::limits::INPUT_LINE_BYTES_MAX;
use apex_runtime::ports::{Deliberator, Observer};
use std::io::{BufRead, BufReader, Read};
use std::net::{Ipv4Addr, TcpListener};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};

/// Inputs that may wait for a run that is busy; whoever sends more waits.
const WAITING_MAX: usize = 10_000;

/// A question on the terminal.
#[derive(Clone)]
struct Open {
    agent: Symbol,
    question: QuestionId,
    text: String,
}

/// Questions that wait for an answer, seen by the run and by whoever reads lines.
#[derive(Clone, Default)]
pub struct OpenQuestions(Arc<Mutex<Vec<Open>>>);

impl OpenQuestions {
    fn with<T>(&self, work: impl FnOnce(&mut Vec<Open>) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Asks on the terminal, and tells what becomes of answers.
pub struct Asker {
    open: OpenQuestions,
    names: Vec<Symbol>,
    turn: usize,
}

impl Asker {
    /// Asks for agents of these names.
    pub fn new(open: OpenQuestions, names: Vec<Symbol>) -> Asker {
        Asker { open, names, turn: 0 }
    }

    fn asked(&self, question: QuestionId, text: &str, options: &[Value], end: Option<String>) {
        let Some(agent) = self.names.get(self.turn).cloned() else { return };
        let options: Vec<String> = options.iter().map(ToString::to_string).collect();
        let choices = if options.is_empty() { String::new() } else { format!(" [{}]", options.join(", ")) };
        let number = self.number(question);
        // Open before it is shown: whoever reads it may answer at once.
        self.open.with(|open| open.push(Open { agent, question, text: text.to_string() }));
        output::complain(format_args!("? {number}: {text}{choices}{}", end.unwrap_or_default()));
    }

    /// `2`, or `pilot/2` where several agents ask.
    fn number(&self, question: QuestionId) -> String {
        match self.names.get(self.turn) {
            Some(agent) if self.names.len() > 1 => format!("{agent}/{}", question.0),
            _ => question.0.to_string(),
        }
    }
}

impl Observer for Asker {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.turn = agent;
        Ok(())
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        let answered = batch.events.iter().any(|event| matches!(event.kind, EventKind::OperatorAnswered(..)));
        for effect in effects {
            match effect {
                Effect::Ask { question, text, options, by, default, .. } => {
                    let end = by.map(|by| match default {
                        Some(default) => format!(" ({default} is taken at {by})"),
                        None => format!(" (until {by})"),
                    });
                    self.asked(*question, text, options, end);
                }
                Effect::WithdrawQuestion { question, reason } => {
                    output::complain(format_args!("  {}: withdrawn, {reason}", self.number(*question)));
                }
                Effect::Decided(decision) if answered => {
                    if let DecisionKind::Trouble { message } = &decision.kind {
                        output::complain(format_args!("  {message}"));
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn inspect(&mut self, agent: &Agent, _: &dyn Deliberator, _: Time) -> Result<(), String> {
        self.open.with(|open| {
            open.retain(|each| each.agent != agent.name || agent.questions.contains_key(&each.question));
        });
        Ok(())
    }
}

/// Listens to standard input, or to `port`, and to Ctrl-C; everything said comes out of the receiver.
///
/// # Errors
/// The port cannot be had, or the system gives no signal handler.
pub fn listen(open: &OpenQuestions, stdin: bool, port: Option<u16>) -> Outcome<Receiver<Control>> {
    let (say, controls) = sync_channel(WAITING_MAX);
    let stop = say.clone();
    ctrlc::set_handler(move || {
        // Nobody is there to end in good order: the run is over already.
        if stop.send(Control::Stop).is_err() {
            std::process::exit(130);
        }
    })
    .map_err(|error| Trouble::failure("cannot listen to Ctrl-C").because(error))?;
    if let Some(port) = port {
        let listener = bind(port)?;
        let (open, say) = (open.clone(), say.clone());
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (open, say) = (open.clone(), say.clone());
                std::thread::spawn(move || hear(BufReader::new(stream), &open, &say));
            }
        });
    }
    let (open, others) = (open.clone(), port.is_some());
    std::thread::spawn(move || {
        if stdin {
            hear(std::io::stdin().lock(), &open, &say);
        }
        if !others {
            // The run may be over: then nobody minds.
            say.send(Control::Quiet).unwrap_or_default();
        }
    });
    Ok(controls)
}

/// A port of this machine; says which one it is.
///
/// # Errors
/// Another program has it.
pub fn bind(port: u16) -> Outcome<TcpListener> {
    let refused = |error| {
        Trouble::failure(format!("cannot listen on 127.0.0.1:{port}"))
            .because(error)
            .help("stop the program that uses the port, or choose another one with `--listen` (0 takes any free one)")
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
    if let Ok(address) = listener.local_addr() {
        output::complain(format_args!("listening on {address}"));
    }
    Ok(listener)
}

fn hear(mut lines: impl BufRead, open: &OpenQuestions, say: &SyncSender<Control>) {
    loop {
        let mut bytes = Vec::new();
        let read = lines.by_ref().take(INPUT_LINE_BYTES_MAX as u64 + 1).read_until(b'\n', &mut bytes);
        if !read.is_ok_and(|count| count > 0) {
            return;
        }
        let line = String::from_utf8_lossy(&bytes).trim().to_string();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        match understand(&line, open) {
            Ok(control) => {
                if say.send(control).is_err() {
                    return;
                }
            }
            Err(fault) => output::complain(format_args!("  {fault}")),
        }
    }
}

/// `{"event": "(go)"}`, `(go)`, `yes`, `2: yes`, `pilot/2: yes`, `stop`.
fn understand(line: &str, open: &OpenQuestions) -> Result<Control, String> {
    let read_value = |text: &str| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message);
    if line.starts_with('{') {
        let input = read_live(line, Time::ZERO, &read_value)?;
        return Ok(match input.agent {
            Some(agent) => Control::InputFor(agent, input.kind),
            None => Control::Input(input.kind),
        });
    }
    if line.starts_with('(') {
        return Ok(Control::Input(EventKind::Occurrence(read_value(line)?)));
    }
    let (number, words) = match line.split_once(':') {
        Some((number, words)) if number.trim().ends_with(|last: char| last.is_ascii_digit()) => {
            (Some(number.trim()), words.trim())
        }
        _ => (None, line),
    };
    let found = open.with(|open| {
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
        [] if line == "stop" => Ok(Control::Stop),
        [] => Err(format!("no question is open that `{line}` could answer; events are written (go) or as JSON")),
        several => {
            let list: Vec<String> =
                several.iter().map(|each| format!("{}/{}: {}", each.agent, each.question.0, each.text)).collect();
            Err(format!("several questions are open, write NUMBER: ANSWER; {}", list.join("; ")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(questions: &[(&str, u64)]) -> OpenQuestions {
        let open = OpenQuestions::default();
        for (agent, number) in questions {
            let question = Open { agent: Symbol::new(agent), question: QuestionId(*number), text: "Go on?".into() };
            open.with(|open| open.push(question));
        }
        open
    }

    #[test]
    fn words_answer_the_open_question() {
        let answer = |agent: &str, number, value| {
            Ok(Control::InputFor(Symbol::new(agent), EventKind::OperatorAnswered(QuestionId(number), value)))
        };
        assert_eq!(understand("yes", &open(&[("a", 3)])), answer("a", 3, Value::text("yes")));
        assert_eq!(understand("12", &open(&[("a", 3)])), answer("a", 3, Value::Integer(12)));
        let two = open(&[("a", 0), ("b", 0)]);
        assert!(understand("yes", &two).unwrap_err().contains("a/0: Go on?; b/0: Go on?"));
        assert_eq!(understand("b/0: no", &two), answer("b", 0, Value::text("no")));
        assert!(understand("yes", &open(&[])).unwrap_err().contains("no question is open"));
        assert_eq!(understand("stop", &open(&[])), Ok(Control::Stop));
    }

    #[test]
    fn forms_and_objects_are_inputs() {
        assert!(matches!(understand("(go)", &open(&[])), Ok(Control::Input(EventKind::Occurrence(_)))));
        let line = r#"{"agent": "b", "measurement": "(altitude uav)", "value": 3}"#;
        assert!(matches!(understand(line, &open(&[])), Ok(Control::InputFor(..))));
        assert!(understand("{", &open(&[])).unwrap_err().contains("no JSON"));
    }
}
