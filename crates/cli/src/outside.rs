//! `apex run` of a `:type foreign-sim` application: an outside simulator owns the clock, over standard input and output or
//! over a port of this machine.

use crate::trouble::{Outcome, Trouble};
use crate::{console, sources};
use apex_model::library::Library;
use apex_model::value::Value;
use apex_runtime::foreign::{self, Cues, SimulatorLink};
use apex_runtime::ports::Observer;
use apex_runtime::program::NoDeliberator;
use apex_runtime::{FlyOptions, RunEnd};
use std::io::{BufRead, BufReader, Write};
use std::sync::Arc;

/// Runs until the simulator stops or the application ends; a reset begins again where nothing is recorded.
pub fn run(
    library: &Arc<Library>,
    port: Option<u16>,
    recorded: bool,
    observers: &mut [&mut dyn Observer],
    options: &dyn Fn() -> FlyOptions,
) -> Outcome<RunEnd> {
    let (mut input, mut output): (Box<dyn BufRead>, Box<dyn Write>) = match port {
        None => (Box::new(std::io::stdin().lock()), Box::new(std::io::stdout())),
        Some(port) => {
            let lost = |error| Trouble::failure("the simulator could not connect").because(error);
            let (stream, _) = console::bind(port)?.accept().map_err(lost)?;
            (Box::new(BufReader::new(stream.try_clone().map_err(lost)?)), Box::new(stream))
        }
    };
    let mut cues = cues(library);
    loop {
        let mut agents = sources::crew_of(library)?;
        let mut link = SimulatorLink {
            input: &mut *input,
            output: &mut *output,
            read_value: &|text| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message),
            cues: cues.clone(),
            may_reset: !recorded,
        };
        let ended = foreign::run(&mut agents, &mut link, &mut NoDeliberator, observers, options())
            .map_err(|error| Trouble::failure(error.to_string()))?;
        if !ended.reset {
            return Ok(ended.end);
        }
        cues.init = forms(library, "reset");
    }
}

fn cues(library: &Library) -> Cues {
    let of = |name: &str| forms(library, name);
    Cues { init: of("init"), start: of("start"), step: of("step"), stop: of("stop") }
}

/// The forms of an option: one form, or a list of them.
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
