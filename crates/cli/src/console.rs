//! People and programs that speak while a run continues: lines from standard input or a port, questions on the terminal,
//! Ctrl-C.

use crate::error::{CliError, CliResult};
use crate::output;
use apex_executive::state::agent::Agent;
use apex_model::effect::{DecisionKind, Effect, QuestionId};
use apex_model::event::{Batch, EventKind};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::Control;
use apex_runtime::limits::INPUT_LINE_BYTES_MAX;
use apex_runtime::live_lines::OpenQuestions;
use apex_runtime::ports::{Deliberator, Observer};
use std::io::{BufRead, BufReader, Read};
use std::net::{Ipv4Addr, TcpListener};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Inputs that may wait for a run that is busy; the caller that sends more waits.
const WAITING_MAX: usize = 10_000;

/// Asks on the terminal, and tells the outcome of answers.
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
        // Open before it is shown: the caller that reads it may answer at once.
        self.open.opened(agent, question, text);
        output::print_error(format_args!("? {number}: {text}{choices}{}", end.unwrap_or_default()));
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
                    output::print_error(format_args!("  {}: withdrawn, {reason}", self.number(*question)));
                }
                Effect::Decided(decision) if answered => {
                    if let DecisionKind::Trouble { message } = &decision.kind {
                        output::print_error(format_args!("  {message}"));
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn inspect(&mut self, agent: &Agent, _: &dyn Deliberator, _: Time) -> Result<(), String> {
        self.open.keep_those_of(agent);
        Ok(())
    }
}

/// Listens to standard input, or to `port`, and to Ctrl-C; everything said comes out of the receiver.
///
/// # Errors
/// The port cannot be had, or the system gives no signal handler.
pub fn listen(open: &OpenQuestions, stdin: bool, port: Option<u16>) -> CliResult<Receiver<Control>> {
    let (say, controls) = sync_channel(WAITING_MAX);
    let stop = say.clone();
    ctrlc::set_handler(move || {
        // Nobody is there to end in good order: the run is over already.
        if stop.send(Control::Stop).is_err() {
            std::process::exit(130);
        }
    })
    .map_err(|error| CliError::failure("cannot listen to Ctrl-C").because(error))?;
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
pub fn bind(port: u16) -> CliResult<TcpListener> {
    let refused = |error| {
        CliError::failure(format!("cannot listen on 127.0.0.1:{port}"))
            .because(error)
            .help("stop the program that uses the port, or choose another one with `--listen` (0 takes any free one)")
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
    if let Ok(address) = listener.local_addr() {
        output::print_error(format_args!("listening on {address}"));
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
        match open.understand(&line, &read_value) {
            Ok(control) => {
                if say.send(control).is_err() {
                    return;
                }
            }
            Err(fault) => output::print_error(format_args!("  {fault}")),
        }
    }
}

fn read_value(text: &str) -> Result<Value, String> {
    apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message)
}
