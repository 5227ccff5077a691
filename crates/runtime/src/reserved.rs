//! Messages that only Apex itself sends. They state facts of the run, of its record and of its mission: sent by another source, they would forge
//! who commanded what, what was recorded, or which requirement is at risk.
//!
//! This is the only list; `docs/reference/trace.md` shows it to users.

use apex_model::event::{EventKind, MISSION_PACE};

/// Facts of the run and its record: the log of commands, authority, live sources, the recorder, the pace. A name that ends with `-` is a
/// beginning.
const OF_THE_RUN: [&str; 5] = ["operator-command", "authority", "live-source", "recording-", MISSION_PACE];
/// Results that the mission computes. A file of scripted inputs may contain them, to test what a program does then.
const OF_THE_MISSION: [&str; 3] = ["requirement-", "segment-weighed", "plan-outdated"];

/// Place at which an input enters a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entrance {
    /// A file of scripted inputs, which is known before the run.
    Script,
    /// An operator, a live source or a simulator, during the run.
    Outside,
}

/// Checks that an input may come from this entrance.
///
/// # Errors
/// The reason for which a message is refused.
pub fn check(kind: &EventKind, entrance: Entrance) -> Result<(), String> {
    let head = match kind {
        EventKind::Occurrence(form) => form.head(),
        EventKind::Measurement(variable, _) => Some(&variable.attribute).filter(|attribute| attribute.is(MISSION_PACE)),
        _ => None,
    };
    let Some(head) = head.map(|head| head.folded()) else { return Ok(()) };
    let is_of =
        |names: &[&str]| names.iter().any(|name| head == *name || name.ends_with('-') && head.starts_with(name));
    if is_of(&OF_THE_RUN) {
        return Err(format!("only Apex sends the message ({head} ..): it states a fact of the run or its record"));
    }
    if entrance == Entrance::Outside && is_of(&OF_THE_MISSION) {
        return Err(format!(
            "only Apex sends the message ({head} ..): the mission computes it; a file of scripted inputs may contain it"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::event::StateVariable;
    use apex_model::symbol::Symbol;
    use apex_model::value::Value;

    fn said(head: &str, entrance: Entrance) -> Result<(), String> {
        check(&EventKind::Occurrence(Value::list([Value::symbol(head), Value::Integer(5)])), entrance)
    }

    #[test]
    fn facts_of_the_run_come_from_no_entrance() {
        for head in
            ["operator-command", "Authority", "live-source", "recording-lost", "recording-resumed", "mission-pace"]
        {
            for entrance in [Entrance::Script, Entrance::Outside] {
                assert!(said(head, entrance).unwrap_err().contains("only Apex sends"), "{head}");
            }
        }
    }

    #[test]
    fn the_pace_of_the_run_is_no_measurement_from_outside() {
        let measured = |attribute: &str| {
            let variable = StateVariable::new(Symbol::new(attribute), Value::nil());
            check(&EventKind::Measurement(variable, Value::Real(1e9)), Entrance::Script)
        };
        assert!(measured("mission-pace").unwrap_err().contains("only Apex"));
        assert_eq!(measured("altitude"), Ok(()));
        // Of other names the list is about messages: `authority` may be measured.
        assert_eq!(measured("authority"), Ok(()));
    }

    #[test]
    fn results_of_the_mission_come_from_scripts_only() {
        for head in ["requirement-at-risk", "requirement-kept", "segment-weighed", "plan-outdated"] {
            assert_eq!(said(head, Entrance::Script), Ok(()), "{head}");
            assert!(said(head, Entrance::Outside).is_err(), "{head}");
        }
        for head in ["new-value", "recorder", "authority-lost", "plan-imposed", "off-schedule"] {
            assert_eq!(said(head, Entrance::Outside), Ok(()), "{head}");
        }
    }
}
