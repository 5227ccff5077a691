//! Blocks with the name of a file of this package: programs and telemetry that are also used from the command line.

use crate::page::Block;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Returns the text of the file named by the block; `None` if it names no file.
///
/// # Errors
/// The file cannot be read.
pub fn text_of(block: &Block) -> Option<Result<String, String>> {
    let named = !block.argument.is_empty() && matches!(block.kind.as_str(), "pdl" | "inputs");
    named.then(|| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(&block.argument);
        fs::read_to_string(&path).map_err(|error| format!("spec/{}: {error}", block.argument))
    })
}

/// Returns the text that the page shows of the file: the whole program, or the number of samples of each variable.
///
/// # Errors
/// A line of the inputs is not JSON.
pub fn shown(block: &Block, text: &str) -> Result<String, String> {
    match block.kind.as_str() {
        "inputs" => summary(text),
        _ => Ok(text.to_string()),
    }
}

/// Returns the times of the first and last input, and a line for each kind: `361 x (roll-angle uav), -8.25 to 25.1`.
fn summary(text: &str) -> Result<String, String> {
    let mut kinds: BTreeMap<String, (usize, f64, f64)> = BTreeMap::new();
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for line in text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')) {
        let fields: serde_json::Value = serde_json::from_str(line).map_err(|error| format!("{line}: {error}"))?;
        let number = |name: &str| fields.get(name).and_then(serde_json::Value::as_f64);
        let word = |name: &str| fields.get(name).and_then(serde_json::Value::as_str);
        let at = number("t").unwrap_or(0.0);
        (first, last) = (first.min(at), last.max(at));
        let name = match (word("measurement"), word("event")) {
            (Some(variable), _) => variable.to_string(),
            (None, Some(event)) => event.to_string(),
            (None, None) => "acknowledged commands".to_string(),
        };
        let entry = kinds.entry(name).or_insert((0, f64::INFINITY, f64::NEG_INFINITY));
        entry.0 += 1;
        if let Some(value) = number("value") {
            (entry.1, entry.2) = (entry.1.min(value), entry.2.max(value));
        }
    }
    let mut told = format!("{first} s to {last} s\n");
    for (name, (count, least, most)) in kinds {
        let range = if least <= most { format!(", {least} to {most}") } else { String::new() };
        told.push_str(&format!("{count} x {name}{range}\n"));
    }
    Ok(told)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(kind: &str, argument: &str) -> Block {
        Block { kind: kind.into(), argument: argument.into(), line: 1, body: String::new() }
    }

    #[test]
    fn only_programs_and_inputs_name_files() {
        assert_eq!(text_of(&block("pdl", "")), None);
        assert_eq!(text_of(&block("why", "a@2s")), None);
        let missing = text_of(&block("inputs", "missions/none.jsonl")).expect("a file is named").unwrap_err();
        assert!(missing.starts_with("spec/missions/none.jsonl: "), "{missing}");
    }

    #[test]
    fn inputs_are_summed_up() {
        let text = "{\"t\": 1, \"measurement\": \"(a b)\", \"value\": 3}\n{\"t\": 2.5, \"measurement\": \"(a b)\", \"value\": -1}\n\
                    {\"t\": 3, \"acknowledge\": 0}\n{\"t\": 4, \"event\": \"(go)\"}\n";
        let expected = "1 s to 4 s\n2 x (a b), -1 to 3\n1 x (go)\n1 x acknowledged commands\n";
        assert_eq!(shown(&block("inputs", "x"), text).as_deref(), Ok(expected));
    }
}
