//! The members that the body of each command has. A member that is unknown or missing refuses the whole body: a misspelt limit of time or
//! epoch would else be no limit at all.

use serde_json::{Map, Value as Json};

/// Members of each command: required ones, then the others.
const COMMANDS: [(&str, &[&str], &[&str]); 15] = [
    ("pause", &[], &[]),
    ("resume", &[], &[]),
    ("pace", &["pace"], &[]),
    ("step", &[], &[]),
    ("stop", &[], &[]),
    ("answer", &["agent", "question", "answer"], &[]),
    ("message", &["form"], &["agent"]),
    ("add-target", &["target"], &[]),
    ("remove-target", &["target"], &[]),
    ("value-target", &["target", "value"], &[]),
    ("acknowledge", &["alarm", "at_ns"], &["signal"]),
    ("take-authority", &[], &[]),
    ("offer-authority", &["to"], &[]),
    ("refuse-authority", &[], &[]),
    ("release-authority", &[], &[]),
];
/// Members that every command may have.
const TERMS: [&str; 3] = ["do", "epoch", "until_ms"];
/// Maximum number of characters of each text except a message.
const TEXT_MAX: usize = 200;
/// Maximum number of characters of an unknown member in a message.
const SHOWN_MAX: usize = 40;

/// Checks the members of a body.
///
/// # Errors
/// The member that is unknown, missing or too long, with the nearest known one.
pub(super) fn check(body: &Map<String, Json>) -> Result<(), String> {
    let Some(Json::String(name)) = body.get("do") else {
        return Err("`do` is missing: the name of the command".into());
    };
    let Some((_, required, others)) = COMMANDS.iter().find(|(known, ..)| known == name) else {
        let names = COMMANDS.iter().map(|(known, ..)| *known);
        return Err(format!("there is no command `{}`{}", shown(name), nearest(name, names)));
    };
    let known = || TERMS.iter().chain(*required).chain(*others).copied();
    if let Some(stranger) = body.keys().find(|key| !known().any(|known| known == key.as_str())) {
        return Err(format!("`{name}` has no member `{}`{}", shown(stranger), nearest(stranger, known())));
    }
    if let Some(missing) = required.iter().find(|member| !body.contains_key(**member)) {
        let null = if *missing == "pace" { "; null is as fast as possible" } else { "" };
        return Err(format!("`{name}` needs the member `{missing}`{null}"));
    }
    for (member, value) in body {
        let Json::String(text) = value else { continue };
        let length = text.chars().count();
        if *member != "form" && length > TEXT_MAX {
            return Err(format!("`{member}` has {length} characters; at most {TEXT_MAX} are permitted"));
        }
        if text.trim().is_empty() && required.contains(&member.as_str()) && *member != "answer" {
            return Err(format!("`{member}` is empty"));
        }
    }
    Ok(())
}

/// Returns the beginning of a name that a caller sent.
fn shown(name: &str) -> String {
    name.chars().take(SHOWN_MAX).collect::<String>().escape_debug().to_string()
}

/// Returns a clause with the known name that differs in the fewest characters, if it is similar.
fn nearest<'a>(wrong: &str, known: impl Iterator<Item = &'a str>) -> String {
    let wrong: String = wrong.chars().take(SHOWN_MAX).collect::<String>().to_lowercase();
    let found = known.map(|name| (edits(&wrong, name), name)).min();
    let similar = found.filter(|(count, name)| *count <= 1 + name.chars().count() / 3);
    similar.map_or_else(String::new, |(_, name)| format!("; the nearest is `{name}`"))
}

/// Returns the number of characters to insert, delete or replace between two names (Levenshtein 1966).
fn edits(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (index, from) in from.chars().enumerate() {
        let mut next = vec![index + 1];
        for (column, (to, pair)) in to.iter().zip(row.windows(2)).enumerate() {
            let [diagonal, above] = pair else { continue };
            let left = next.get(column).copied().unwrap_or(usize::MAX - 1);
            next.push((diagonal + usize::from(from != *to)).min(above + 1).min(left + 1));
        }
        row = next;
    }
    row.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(text: &str) -> Result<(), String> {
        match apex_runtime::parse_unique_json(text).map_err(|error| error.to_string())? {
            Json::Object(body) => check(&body),
            _ => Err("no object".into()),
        }
    }

    #[test]
    fn bodies_have_exactly_the_members_of_their_command() {
        for body in [
            r#"{"do": "pause", "epoch": 3, "until_ms": 5}"#,
            r#"{"do": "pace", "pace": null}"#,
            r#"{"do": "message", "form": "(go)", "agent": "pilot"}"#,
        ] {
            assert_eq!(checked(body), Ok(()), "{body}");
        }
        for (body, fault) in [
            (r#"{"do": "pace"}"#, "`pace` needs the member `pace`; null is as fast as possible"),
            (r#"{"do": "pause", "untilms": 1}"#, "`pause` has no member `untilms`; the nearest is `until_ms`"),
            (r#"{"do": "stop", "epocH": 99}"#, "`stop` has no member `epocH`; the nearest is `epoch`"),
            (r#"{"do": "pause", "x": 1}"#, "`pause` has no member `x`"),
            (r#"{"do": "pauze"}"#, "there is no command `pauze`; the nearest is `pause`"),
            (r#"{"do": "pause", "do": "resume"}"#, "the key `do` is given twice"),
            (r#"{"do": 1}"#, "`do` is missing"),
            (r#"{"do": "acknowledge", "alarm": " ", "at_ns": 0}"#, "`alarm` is empty"),
            (r#"{"do": "acknowledge", "alarm": "x"}"#, "`acknowledge` needs the member `at_ns`"),
        ] {
            let refusal = checked(body).unwrap_err();
            assert!(refusal.contains(fault), "{body}: {refusal}");
        }
        let long = format!(r#"{{"do": "acknowledge", "alarm": "{}", "at_ns": 0}}"#, "a".repeat(5_000));
        assert!(checked(&long).unwrap_err().contains("`alarm` has 5000 characters"));
    }
}
