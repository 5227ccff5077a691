//! Scripted inputs: JSON lines of events and measurements with their instants.

use crate::error::{MissionError, MissionResult};
use crate::files::{read_text, unreadable};
use crate::sources::DataFile;
use apex_model::value::Value;
use apex_runtime::input_lines::{InputErrors, read_inputs};
use apex_runtime::input_stream::{InputStream, survey};
use apex_runtime::ports::Input;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Reads scripted inputs from a file.
///
/// # Errors
/// An unreadable file, lines that are not inputs.
pub fn read(path: &Path) -> MissionResult<Vec<Input>> {
    parse(&path.display().to_string(), &read_text(path)?)
}

/// Inputs of a run: in memory, or read while they are needed.
pub enum ScriptedInputs {
    /// In memory, in order of time.
    Held(Vec<Input>),
    /// Read while they are needed.
    Streamed(Box<InputStream>),
}

/// Files of fewer bytes are read as a whole.
const HELD_BYTES_MAX: u64 = 1 << 20;

/// Opens a file of scripted inputs. A long file is checked first, then streamed if its lines are in order of time and contain no
/// acknowledgements.
///
/// # Errors
/// An unreadable file, lines that are not inputs.
pub fn open(path: &Path) -> MissionResult<ScriptedInputs> {
    let is_long = std::fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > HELD_BYTES_MAX);
    if !is_long {
        return read(path).map(ScriptedInputs::Held);
    }
    let file = || File::open(path).map(BufReader::new).map_err(|error| unreadable(path, &error));
    let name = path.display().to_string();
    let found = survey(&name, file()?, &read_value).map_err(not_inputs)?;
    if !found.can_be_streamed {
        return read(path).map(ScriptedInputs::Held);
    }
    let stream = InputStream::new(&name, Box::new(file()?), found.agents, Box::new(read_value));
    Ok(ScriptedInputs::Streamed(Box::new(stream)))
}

fn read_value(text: &str) -> Result<Value, String> {
    apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message)
}

fn not_inputs(errors: InputErrors) -> MissionError {
    MissionError::data(errors.to_string())
        .help("each line is {\"t\": SECONDS, \"event\": \"(FORM)\"} or {\"t\": SECONDS, \"measurement\": \"(ATTRIBUTE OBJECT)\", \"value\": VALUE}")
}

/// Reads the scripted inputs of a mission.
pub(crate) fn of_mission(file: &DataFile) -> MissionResult<Vec<Input>> {
    parse(&file.place, &file.text()?)
}

/// Reads scripted inputs from a text; `name` is its name in messages.
///
/// # Errors
/// Lines that are not inputs.
pub fn parse(name: &str, text: &str) -> MissionResult<Vec<Input>> {
    read_inputs(name, text, &read_value).map_err(not_inputs)
}
