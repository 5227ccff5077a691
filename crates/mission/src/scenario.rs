//! Scripted inputs: JSON lines of events and measurements with their instants.

use crate::error::{MissionError, MissionResult};
use crate::files::read_text;
use crate::sources::DataFile;
use apex_runtime::input_lines::read_inputs;
use apex_runtime::ports::Input;
use std::path::Path;

/// Reads scripted inputs from a file.
///
/// # Errors
/// An unreadable file, lines that are not inputs.
pub fn read(path: &Path) -> MissionResult<Vec<Input>> {
    parse(&path.display().to_string(), &read_text(path)?)
}

/// Reads the scripted inputs of a mission.
pub(crate) fn of_mission(file: &DataFile) -> MissionResult<Vec<Input>> {
    parse(&file.place, &file.text()?)
}

/// Reads scripted inputs from a text; `name` says in messages where it is from.
///
/// # Errors
/// Lines that are not inputs.
pub fn parse(name: &str, text: &str) -> MissionResult<Vec<Input>> {
    let read_value = |text: &str| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message);
    read_inputs(name, text, &read_value).map_err(|errors| {
        MissionError::data(errors.to_string())
            .help("each line is {\"t\": SECONDS, \"event\": \"(FORM)\"} or {\"t\": SECONDS, \"measurement\": \"(ATTRIBUTE OBJECT)\", \"value\": VALUE}")
    })
}
