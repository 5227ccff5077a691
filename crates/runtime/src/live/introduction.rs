//! The line by which a source introduces itself: `{"source": "nav-1", "class": "vehicle"}`.

use super::class::SourceClass;
use crate::unique_json;
use serde_json::{Map, Value as Json};

/// Maximum number of characters of a name.
const NAME_MAX: usize = 64;

/// The name and the class of a source, as it states them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Introduction {
    /// Its name: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// Its class.
    pub class: SourceClass,
}

impl Introduction {
    /// Reads a line; `None` if it is not an introduction.
    ///
    /// # Errors
    /// The error in an introduction.
    pub fn read(line: &str) -> Option<Result<Introduction, String>> {
        // Most lines are not introductions; this test avoids parsing them twice.
        if !line.contains("\"source\"") {
            return None;
        }
        match unique_json::parse(line) {
            Ok(Json::Object(fields)) if fields.contains_key("source") => Some(Introduction::of(&fields)),
            _ => None,
        }
    }

    fn of(fields: &Map<String, Json>) -> Result<Introduction, String> {
        if let Some(stranger) = fields.keys().find(|key| !["source", "class"].contains(&key.as_str())) {
            return Err(format!(
                "unknown member \"{stranger}\" next to \"source\"; an introduction has \"source\" and \"class\" only"
            ));
        }
        let name = match fields.get("source") {
            Some(Json::String(name)) if is_name(name) => name.clone(),
            other => {
                let found = other.map_or_else(String::new, ToString::to_string);
                return Err(format!(
                    "\"source\" is {found}; expected a name of 1 to {NAME_MAX} letters, digits, `-`, `_` and `.` that \
                     begins with a letter, and not `nil` or `t`"
                ));
            }
        };
        let class = match fields.get("class") {
            Some(Json::String(word)) => SourceClass::of_word(word),
            _ => None,
        };
        let class = class.ok_or_else(|| {
            let words: Vec<&str> = SourceClass::ALL.into_iter().map(SourceClass::word).collect();
            format!("\"class\" of source {name} is not one of {}", words.join(", "))
        })?;
        Ok(Introduction { name, class })
    }
}

fn is_name(text: &str) -> bool {
    text.len() <= NAME_MAX
        && text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text.chars().all(|each| each.is_ascii_alphanumeric() || ['-', '_', '.'].contains(&each))
        // The truth values of PDL cannot be names in messages.
        && !["nil", "t"].iter().any(|value| text.eq_ignore_ascii_case(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_introduction_states_a_name_and_a_class() {
        let read = |line: &str| Introduction::read(line);
        let nav = Introduction { name: "nav-1".into(), class: SourceClass::Vehicle };
        assert_eq!(read(r#"{"source": "nav-1", "class": "vehicle"}"#), Some(Ok(nav)));
        for line in [r#"{"event": "(go)"}"#, "(source)", r#"{"event": "(said \"source\")"}"#, "{\"source\""] {
            assert_eq!(read(line), None, "{line}");
        }
        for (line, fault) in [
            (r#"{"source": "nav"}"#, "is not one of operator, safing, vehicle, feed"),
            (r#"{"source": "nav", "class": "pilot"}"#, "is not one of operator"),
            (r#"{"source": "1", "class": "feed"}"#, "begins with a letter"),
            (r#"{"source": "NIL", "class": "feed"}"#, "not `nil` or `t`"),
            (r#"{"source": "a\u001bb", "class": "feed"}"#, "expected a name"),
            (r#"{"source": 3, "class": "feed"}"#, "\"source\" is 3"),
            (r#"{"source": "a", "class": "feed", "rate": 3}"#, "unknown member \"rate\""),
        ] {
            let refusal = read(line).unwrap().unwrap_err();
            assert!(refusal.contains(fault), "{line}: {refusal}");
        }
    }
}
