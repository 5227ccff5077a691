//! Inputs that arrive late. A line with `"came": 16` arrives at 16 s, regardless of its `"t"`, because the vehicle's link delayed it.

use apex_model::time::Time;
use apex_runtime::input_lines::{InputErrors, read_inputs};
use apex_runtime::ports::Input;
use serde_json::Value as Json;

/// A page's inputs, separated by their source.
#[derive(Debug, Default, PartialEq)]
pub struct Inputs {
    /// Inputs that arrive at their time.
    pub prompt: Vec<Input>,
    /// Inputs that arrive later, with their arrivals.
    pub late: Vec<(Time, Input)>,
}

/// Reads the lines of an inputs block.
///
/// # Errors
/// Invalid lines with their numbers, and lines that arrive before they happen.
pub fn read(text: &str) -> Result<Inputs, String> {
    let mut inputs = Inputs::default();
    let mut prompt = String::new();
    for (index, line) in text.lines().enumerate() {
        match came(line) {
            None => prompt.push_str(line),
            Some((came, rest)) => {
                // Empty lines before the line give it its line number in messages.
                let input = lines(&format!("{}{rest}", "\n".repeat(index)))?.pop();
                let input = input.ok_or_else(|| format!("inputs:{}: nothing came", index + 1))?;
                if came < input.at {
                    return Err(format!("inputs:{}: it cannot come at {came}, before it happens", index + 1));
                }
                inputs.late.push((came, input));
            }
        }
        prompt.push('\n');
    }
    inputs.prompt = lines(&prompt)?;
    inputs.late.sort_by_key(|(came, _)| *came);
    Ok(inputs)
}

fn lines(text: &str) -> Result<Vec<Input>, String> {
    read_inputs("inputs", text, &|datum| apex_pdl::read_value(datum).map_err(|error| format!("{error:?}")))
        .map_err(|InputErrors(faults)| faults.join("\n"))
}

/// Returns the arrival time stated in the line, and the line without it.
fn came(line: &str) -> Option<(Time, String)> {
    let Ok(Json::Object(mut fields)) = serde_json::from_str(line) else { return None };
    let came = fields.remove("came")?.as_f64()?;
    Some((Time::from_seconds(came), Json::Object(fields).to_string()))
}

/// Removes and returns the late inputs that are due at `to`, in order of arrival; the others stay.
pub fn take_due(late: &mut Vec<(Time, Input)>, to: Time) -> impl Iterator<Item = Input> {
    let count = late.iter().take_while(|(came, _)| *came <= to).count();
    late.drain(..count).map(|(_, input)| input).collect::<Vec<_>>().into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::event::EventKind;
    use apex_model::value::Value;

    #[test]
    fn lines_that_came_later_are_held_back() {
        let text =
            "{\"t\": 1, \"event\": \"(a)\"}\n{\"t\": 2, \"measurement\": \"(h uav)\", \"value\": 3, \"came\": 9}\n";
        let mut inputs = read(text).unwrap();
        assert_eq!(inputs.prompt.len(), 1);
        assert_eq!(take_due(&mut inputs.late, Time::from_seconds(8.0)).count(), 0);
        let input = take_due(&mut inputs.late, Time::from_seconds(9.0)).next().unwrap();
        assert_eq!(input.at, Time::from_seconds(2.0));
        assert!(matches!(input.kind, EventKind::Measurement(_, Value::Integer(3))));
    }

    #[test]
    fn what_is_wrong_with_a_line_is_reported_with_its_number() {
        let early = "\n{\"t\": 2, \"event\": \"(a)\", \"came\": 1}";
        assert_eq!(read(early).unwrap_err(), "inputs:2: it cannot come at 1s, before it happens");
        assert!(read("\n\n{\"t\": 2, \"evnt\": \"(a)\", \"came\": 3}").unwrap_err().starts_with("inputs:3: expected"));
    }
}
