//! Messages that change the situation of a mission. Only this file knows their PDL forms.

use super::contingency;
use super::updates::MissionUpdate;
use apex_model::value::Value;

/// A message of the mission's procedures, of the vehicle or of the scenario.
#[derive(Clone, Debug, PartialEq)]
pub enum MissionEvent {
    /// `(observing TARGET)`: an observation begins.
    Observing(String),
    /// `(observed TARGET)`: an observation has ended.
    Observed(String),
    /// `(not-observed TARGET WHY)`: an observation has failed.
    NotObserved {
        /// The target.
        target: String,
        /// Reason, as the procedure states it.
        why: String,
    },
    /// `(wings-level-violation TARGET)`: a segment of a line has lost its data.
    WingsLevelViolation(String),
    /// `(segment-weighed TARGET FROM TO again|leave GAIN PRICE TEXT)`: the decision to fly a lost segment again or not.
    SegmentWeighed {
        /// The target.
        target: String,
        /// True if the segment is flown again.
        is_again: bool,
        /// Both values as text.
        text: String,
    },
    /// `(replan-wanted REASON)`.
    ReplanWanted(String),
    /// `(communication-lost LINK)`.
    CommunicationLost(String),
    /// `(communication-regained LINK)`.
    CommunicationRegained(String),
    /// `(communication-not-regained LINK)`.
    CommunicationNotRegained(String),
    /// `(awaiting-instructions LINK DEFAULT)`.
    AwaitingInstructions {
        /// The link that is good again.
        link: String,
        /// Response without an instruction.
        default: String,
    },
    /// `(instructed LINK INSTRUCTION)`: by the operator or by default.
    Instructed {
        /// The link.
        link: String,
        /// Instruction to the aircraft.
        instruction: String,
    },
    /// `(contingency-route LINK PLACE WHY)`.
    ContingencyRoute {
        /// The link.
        link: String,
        /// End of the flight.
        place: String,
        /// `silent` or `instructed`.
        why: String,
    },
    /// `(image-in-memory TARGET)`: a picture has been taken.
    ImageInMemory(String),
    /// `(low-fuel VEHICLE)`.
    LowFuel,
    /// `(requirement-broken NAMES WHY)`: no way keeps these requirements.
    RequirementBroken {
        /// Violated requirements.
        names: Vec<String>,
        /// Reason.
        why: String,
    },
    /// A message of library `contingencies`.
    Contingency {
        /// The line of the report.
        line: String,
        /// True if the aircraft lands.
        lands: bool,
    },
    /// New data of the mission.
    Update(MissionUpdate),
}

impl MissionEvent {
    /// Reads a message; `None` if it does not concern the mission's state.
    pub fn read(form: &Value) -> Option<MissionEvent> {
        let [Value::Symbol(head), items @ ..] = form.as_list()? else { return None };
        let subject = items.first()?.to_string();
        let item = |index: usize| items.get(index).map(Value::to_string).unwrap_or_default();
        Some(match head.folded() {
            "observing" => MissionEvent::Observing(subject),
            "observed" => MissionEvent::Observed(subject),
            "not-observed" => {
                let why = items.get(1).map_or_else(|| "it failed".to_string(), Value::to_string);
                MissionEvent::NotObserved { target: subject, why }
            }
            "wings-level-violation" => MissionEvent::WingsLevelViolation(subject),
            "segment-weighed" => {
                let [_, _, _, verdict, _, _, Value::Text(text)] = items else { return None };
                let is_again = verdict.as_symbol().is_some_and(|verdict| verdict.is("again"));
                MissionEvent::SegmentWeighed { target: subject, is_again, text: text.to_string() }
            }
            "replan-wanted" => MissionEvent::ReplanWanted(subject),
            "communication-lost" => MissionEvent::CommunicationLost(subject),
            "communication-not-regained" => MissionEvent::CommunicationNotRegained(subject),
            "awaiting-instructions" => MissionEvent::AwaitingInstructions { link: subject, default: item(1) },
            "instructed" => MissionEvent::Instructed { link: subject, instruction: item(1) },
            "contingency-route" => MissionEvent::ContingencyRoute { link: subject, place: item(1), why: item(2) },
            "communication-regained" => MissionEvent::CommunicationRegained(subject),
            "image-in-memory" => MissionEvent::ImageInMemory(subject),
            "low-fuel" => MissionEvent::LowFuel,
            "requirement-broken" => {
                let words =
                    |value: &Value| if let Value::Text(text) = value { text.to_string() } else { value.to_string() };
                let named = items.first()?;
                let names = named.as_list().unwrap_or(std::slice::from_ref(named)).iter().map(words).collect();
                MissionEvent::RequirementBroken { names, why: words(items.get(1)?) }
            }
            head => match contingency::line(head, items) {
                Some(line) => {
                    MissionEvent::Contingency { line, lands: matches!(head, "engine-out" | "landing-because") }
                }
                None => MissionEvent::Update(MissionUpdate::read(head, items)?),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_other_matters_are_not_read() {
        let form = |words: &[&str]| Value::list(words.iter().map(|word| Value::symbol(word)));
        assert_eq!(MissionEvent::read(&form(&["ready", "camera-1"])), None);
        assert_eq!(MissionEvent::read(&form(&["observed"])), None);
        assert_eq!(MissionEvent::read(&Value::symbol("observed")), None);
        assert_eq!(MissionEvent::read(&form(&["Observed", "barn"])), Some(MissionEvent::Observed("barn".into())));
    }

    #[test]
    fn a_violation_names_each_requirement() {
        let read = |named: Value| match MissionEvent::read(&Value::list([
            Value::symbol("requirement-broken"),
            named,
            Value::text("no way is open"),
        ])) {
            Some(MissionEvent::RequirementBroken { names, why }) => (names, why),
            other => panic!("{other:?}"),
        };
        let several = Value::list([Value::text("north; range"), Value::text("permitted area")]);
        assert_eq!(read(several).0, ["north; range", "permitted area"]);
        assert_eq!(read(Value::symbol("north")), (vec!["north".to_string()], "no way is open".to_string()));
    }
}
