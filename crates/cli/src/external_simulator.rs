//! `apex run` of a `:type foreign-sim` application: an external simulator owns the clock, over standard input and output or
//! over a port of this machine.

use crate::console;
use crate::error::{CliError, CliResult};
use apex_model::library::Library;
use apex_runtime::RunEnd;
use apex_runtime::foreign::{Cues, ForeignEnd, SimulatorLink};
use std::io::{BufRead, BufReader, Write};

/// Runs one episode over the link, from its greeting to its end or reset.
pub type Episode<'a> = dyn FnMut(&mut SimulatorLink<'_>) -> CliResult<ForeignEnd> + 'a;

/// Runs episodes until the simulator stops or the application ends; a reset begins the next one. A recorded run cannot be reset.
///
/// # Errors
/// The simulator could not connect; or the error of `episode`.
pub fn run(library: &Library, port: Option<u16>, recorded: bool, episode: &mut Episode<'_>) -> CliResult<RunEnd> {
    let (mut input, mut output): (Box<dyn BufRead>, Box<dyn Write>) = match port {
        None => (Box::new(std::io::stdin().lock()), Box::new(std::io::stdout())),
        Some(port) => {
            let lost = |error| CliError::failure("the simulator could not connect").because(error);
            let (stream, _) = console::bind(port)?.accept().map_err(lost)?;
            (Box::new(BufReader::new(stream.try_clone().map_err(lost)?)), Box::new(stream))
        }
    };
    let mut cues = Cues::of(library);
    loop {
        let mut link = SimulatorLink {
            input: &mut *input,
            output: &mut *output,
            read_value: &|text| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message),
            cues: cues.clone(),
            may_reset: !recorded,
        };
        let ended = episode(&mut link)?;
        if !ended.reset {
            return Ok(ended.end);
        }
        cues = cues.after_reset(library);
    }
}
