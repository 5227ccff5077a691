//! Protocol for an external simulator that owns the clock (`:type foreign-sim`), as JSON lines. A line of the simulator states the new
//! time and its observations; the answer contains the effects of the agents and the next instant at which they request a step.
//!
//! `docs/reference/foreign-simulators.md` is the protocol for its users. A line that cannot be understood is answered by
//! an `error` line and changes nothing.

use crate::error::RunError;
use crate::flight::Flight;
use crate::input_lines::{ReadValue, read_fields};
use crate::limits::INPUT_LINE_BYTES_MAX;
use crate::ports::{Deliberator, Input, Observer, Vehicle};
use crate::reserved::{self, Entrance};
use crate::run_settings::{EndReason, RunEnd, RunSettings};
use crate::solver_thread::SolverThread;
use crate::trace::seconds_text;
use crate::unique_json;
use apex_executive::{Agent, step};
use apex_model::effect::{CommandId, Effect};
use apex_model::event::Batch;
use apex_model::library::Library;
use apex_model::time::Time;
use apex_model::value::Value;
use serde_json::{Map, Value as Json, json};
use std::cell::RefCell;
use std::io::{BufRead, Read, Write};
use std::rc::Rc;

/// Messages of Apex to the simulator in addition to effects, from the application's `:init`, `:start`, `:step` and `:stop`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cues {
    /// Messages in the greeting.
    pub init: Vec<Value>,
    /// Messages in the first answer.
    pub start: Vec<Value>,
    /// Messages sent with every line after the first.
    pub step: Vec<Value>,
    /// Messages in the last answer.
    pub stop: Vec<Value>,
}

impl Cues {
    /// Returns the messages of a program's application.
    pub fn of(library: &Library) -> Cues {
        let forms = |name: &str| forms(library, name);
        Cues { init: forms("init"), start: forms("start"), step: forms("step"), stop: forms("stop") }
    }

    /// Returns the messages of the run after a reset: its greeting is the application's `:reset`.
    pub fn after_reset(self, library: &Library) -> Cues {
        Cues { init: forms(library, "reset"), ..self }
    }
}

/// Returns the forms of an option: one form, or a list of forms.
fn forms(library: &Library, option: &str) -> Vec<Value> {
    let Some(value) = library.application.as_ref().and_then(|application| application.option(option)) else {
        return Vec::new();
    };
    match value.as_list() {
        Some([]) => Vec::new(),
        Some(items) if items.iter().all(|item| item.as_list().is_some()) => items.to_vec(),
        _ => vec![value.clone()],
    }
}

/// Connection of a simulator: its requests and the answers.
pub struct SimulatorLink<'a> {
    /// Lines from the simulator.
    pub input: &'a mut dyn BufRead,
    /// Lines to the simulator.
    pub output: &'a mut dyn Write,
    /// Reads PDL inside of lines.
    pub read_value: ReadValue<'a>,
    /// Messages of the application at certain moments.
    pub cues: Cues,
    /// True if a `reset` is permitted: the run is not recorded, so a new beginning loses no data.
    pub may_reset: bool,
}

/// End of a run at an outside clock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ForeignEnd {
    /// The end as of any run.
    pub end: RunEnd,
    /// True if the simulator requests a reset.
    pub reset: bool,
}

/// Runs `agents` by the clock of an external simulator until it sends `stop`, its lines end, or the application ends.
///
/// # Errors
/// Like [`crate::fly_all`]; and when an answer cannot be written.
pub fn run(
    agents: &mut [Agent],
    link: &mut SimulatorLink<'_>,
    deliberator: &mut dyn Deliberator,
    observers: &mut [&mut dyn Observer],
    options: RunSettings,
) -> Result<ForeignEnd, RunError> {
    let said: Said = Rc::default();
    let mut vehicle = Remote(Rc::clone(&said));
    let names = if agents.len() > 1 { agents.iter().map(|agent| agent.name.to_string()).collect() } else { Vec::new() };
    let mut listener = Listener { said: Rc::clone(&said), names, turn: 0 };
    let mut all: Vec<&mut dyn Observer> = observers.iter_mut().map(|observer| &mut **observer as _).collect();
    all.push(&mut listener);
    let until = options.until;
    let queue = Box::new(SolverThread::new(options.solver_timeout));
    let mut flight = Flight::new(step, agents, &mut vehicle, deliberator, &mut all, queue, options)?;
    let greeting =
        json!({"apex": env!("CARGO_PKG_VERSION"), "agents": flight.names(), "wake": 0, "say": texts(&link.cues.init)});
    write_line(link, &greeting, Time::ZERO)?;
    let (mut now, mut first, mut reset) = (Time::ZERO, true, false);
    let reason = loop {
        let Some(line) = read_request(link, now)? else { break EndReason::Stopped };
        let request = match line.and_then(|line| understand(&line, now, link.read_value)) {
            Ok(request) => request,
            Err(fault) => {
                write_line(link, &json!({"error": fault}), now)?;
                continue;
            }
        };
        let request_is_reset = matches!(request, SimulatorRequest::Reset);
        let (to, inputs) = match request {
            SimulatorRequest::Reset if !link.may_reset => {
                let fault = "this run cannot be reset, because it is recorded; stop it and start another one";
                write_line(link, &json!({"error": fault}), now)?;
                continue;
            }
            SimulatorRequest::Stop | SimulatorRequest::Reset => {
                reset = request_is_reset;
                flight.stop()?;
                flight.flush(now)?;
                answer(link, &said, now, None, Some(&EndReason::Stopped), false)?;
                break EndReason::Stopped;
            }
            SimulatorRequest::Advance(to, inputs) => (to.min(until), inputs),
        };
        if let Some(fault) = inputs.iter().find_map(|input| flight.check(input).err()) {
            write_line(link, &json!({"error": fault.to_string()}), now)?;
            continue;
        }
        let mut ended = flight.advance(to, inputs)?;
        now = to;
        if ended.is_none() && now >= until {
            ended = Some(EndReason::Until);
        }
        // The simulator acts on the answer: the step is committed before the answer is sent, and nothing is uncommitted during the wait
        // for the next line.
        flight.flush(now)?;
        answer(link, &said, now, flight.next_wake(), ended.as_ref(), first)?;
        first = false;
        if let Some(reason) = ended {
            break reason;
        }
    };
    Ok(ForeignEnd { end: flight.close(reason)?, reset })
}

/// Messages of the agents since the last answer, ready to be sent.
type Said = Rc<RefCell<Vec<Json>>>;

enum SimulatorRequest {
    Advance(Time, Vec<Input>),
    Stop,
    Reset,
}

/// A line of the simulator, or the reason for which it is refused.
type RequestLine = Result<String, String>;

/// Returns the next line; `None` at the end of the simulator's lines. A line that is too long is refused with its rest, which
/// must not be taken for another request.
fn read_request(link: &mut SimulatorLink<'_>, now: Time) -> Result<Option<RequestLine>, RunError> {
    let mut bytes = Vec::new();
    let most = INPUT_LINE_BYTES_MAX as u64 + 1;
    let read = (&mut link.input).take(most).read_until(b'\n', &mut bytes);
    let count = read.map_err(|error| broken(now, &error))?;
    if count == 0 {
        return Ok(None);
    }
    if bytes.len() > INPUT_LINE_BYTES_MAX && !bytes.ends_with(b"\n") {
        link.input.skip_until(b'\n').map_err(|error| broken(now, &error))?;
        return Ok(Some(Err(format!("the line is longer than {INPUT_LINE_BYTES_MAX} bytes, and refused as a whole"))));
    }
    Ok(Some(match std::str::from_utf8(&bytes).map(str::trim) {
        // A simulator that waits for the answer to each of its lines would wait forever.
        Ok("") => Err("the line is empty; a request is an object, for example {\"advance\": 10}".into()),
        Ok(line) => Ok(line.to_string()),
        Err(error) => Err(format!("the line is not UTF-8 text: {error}")),
    }))
}

/// Reads `{"advance": T, "inputs": [..]}` or `{"stop": true}`.
fn understand(line: &str, now: Time, read_value: ReadValue<'_>) -> Result<SimulatorRequest, String> {
    let request = unique_json::parse(line).map_err(|error| format!("this is not JSON: {error}"))?;
    let Json::Object(fields) = request else { return Err("a request is an object".into()) };
    if let Some(stranger) = fields.keys().find(|key| !["advance", "inputs", "stop", "reset"].contains(&key.as_str())) {
        return Err(format!(
            "\"{stranger}\" is not known; requests have \"advance\" with \"inputs\", \"stop\" or \"reset\""
        ));
    }
    if fields.get("stop") == Some(&Json::Bool(true)) {
        return Ok(SimulatorRequest::Stop);
    }
    if fields.get("reset") == Some(&Json::Bool(true)) {
        return Ok(SimulatorRequest::Reset);
    }
    let Some(time) = fields.get("advance") else {
        return Err("\"advance\" is missing; expected seconds of mission time".into());
    };
    let to = match time.as_f64() {
        Some(seconds) if (0.0..=9e9).contains(&seconds) => Time::from_seconds(seconds),
        _ => return Err(format!("\"advance\" is {time}; expected seconds of mission time")),
    };
    if to < now {
        return Err(format!("\"advance\" goes back from {now} to {to}; time only goes forward"));
    }
    let inputs = match fields.get("inputs") {
        None => Vec::new(),
        Some(Json::Array(items)) => {
            let read = |(index, item): (usize, &Json)| {
                let told = |fault: String| format!("input {}: {fault}", index + 1);
                let Json::Object(fields) = item else { return Err(told("expected an object".into())) };
                let input = read_fields(fields, to, read_value).map_err(told)?;
                reserved::check(&input.kind, Entrance::Outside).map_err(told)?;
                match input.at {
                    at if at < now => Err(told(format!("{at} is before {now}, where the simulation is"))),
                    at if at > to => Err(told(format!("{at} is after {to}, to which time advances"))),
                    _ => Ok(input),
                }
            };
            items.iter().enumerate().map(read).collect::<Result<_, _>>()?
        }
        Some(other) => return Err(format!("\"inputs\" is {other}; expected a list")),
    };
    Ok(SimulatorRequest::Advance(to, inputs))
}

fn answer(
    link: &mut SimulatorLink<'_>,
    said: &Said,
    now: Time,
    wake: Option<Time>,
    ended: Option<&EndReason>,
    first: bool,
) -> Result<(), RunError> {
    let mut line = Map::new();
    line.insert("t".into(), seconds(now));
    line.insert("effects".into(), Json::Array(said.take()));
    let cues = match ended {
        Some(_) => &link.cues.stop,
        None if first => &link.cues.start,
        None => &link.cues.step,
    };
    if !cues.is_empty() {
        line.insert("say".into(), texts(cues));
    }
    match ended {
        Some(reason) => line.insert("end".into(), Json::from(reason.text())),
        None => line.insert("wake".into(), wake.map_or(Json::Null, seconds)),
    };
    write_line(link, &Json::Object(line), now)
}

fn write_line(link: &mut SimulatorLink<'_>, line: &Json, now: Time) -> Result<(), RunError> {
    writeln!(link.output, "{line}").and_then(|()| link.output.flush()).map_err(|error| broken(now, &error))
}

fn broken(at: Time, error: &std::io::Error) -> RunError {
    RunError::Vehicle { at, message: format!("the link to the simulator broke: {error}") }
}

fn texts(forms: &[Value]) -> Json {
    forms.iter().map(|form| Json::from(form.to_string())).collect()
}

/// Returns seconds with all of their decimals.
fn seconds(time: Time) -> Json {
    serde_json::from_str(&seconds_text(time)).unwrap_or(Json::Null)
}

/// Commands and withdrawals, which go to the simulator with the next answer.
struct Remote(Said);

impl Vehicle for Remote {
    fn next_report(&self) -> Option<Time> {
        None
    }

    fn advance(&mut self, _: Time, _: &mut Vec<Input>) -> Result<(), String> {
        Ok(())
    }

    fn command(&mut self, command: CommandId, form: &Value, at: Time) {
        self.0.borrow_mut().push(json!({"t": seconds(at), "command": command.0, "form": form.to_string()}));
    }

    fn withdraw(&mut self, command: CommandId, at: Time) {
        self.0.borrow_mut().push(json!({"t": seconds(at), "withdraw": command.0}));
    }

    fn acts_outside(&self) -> bool {
        false
    }
}

/// Messages, prints and questions, which go to the simulator with the next answer.
struct Listener {
    said: Said,
    /// The names of the agents, where there are several.
    names: Vec<String>,
    turn: usize,
}

impl Listener {
    fn say(&self, mut line: Json) {
        if let (Some(name), Json::Object(fields)) = (self.names.get(self.turn), &mut line) {
            fields.insert("agent".into(), Json::from(name.as_str()));
        }
        self.said.borrow_mut().push(line);
    }
}

impl Observer for Listener {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.turn = agent;
        Ok(())
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        let t = seconds(batch.now);
        for effect in effects {
            match effect {
                Effect::Inform { form, .. } => self.say(json!({"t": t, "inform": form.to_string()})),
                Effect::Print { text, .. } => self.say(json!({"t": t, "print": text})),
                Effect::Ask { question, text, options, .. } => {
                    self.say(json!({"t": t, "ask": question.0, "text": text, "options": texts(options)}));
                }
                Effect::WithdrawQuestion { question, reason } => {
                    self.say(json!({"t": t, "withdraw-question": question.0, "reason": reason}));
                }
                _ => {}
            }
        }
        Ok(())
    }
}
