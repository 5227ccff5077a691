//! A plan in the executive's form: a sequential procedure with typed steps.
//!
//! Text is for operators only. Only [`PlannedActivity::goal`] and [`PlannedActivity::from_goal`] contain the notation of activities as
//! goals of `library/aerial-observation.pdl`.

mod location;

pub use location::Location;

use crate::problem::Plan;
use crate::quantity::Dimension;
use crate::source::SourceFile;
use crate::symbol::Symbol;
use crate::time::Duration;
use crate::value::Value;
use serde::{Deserialize, Serialize};

/// A solver's plan as a procedure. Its index is the goal of the request that it answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedProcedure {
    /// The solver that made it.
    pub solver: Symbol,
    /// One line for the operator: value, bound, targets left out.
    pub summary: String,
    /// Activities in order.
    pub steps: Vec<PlannedStep>,
    /// True for a cycle that begins again when it ends.
    pub repeat: bool,
    /// The checked plan with its visits, times and routes; `None` if the procedure was not made by a planner.
    pub plan: Option<Box<Plan>>,
    /// The same procedure as PDL text, so that places in it can be displayed.
    pub source: SourceFile,
}

/// One step of a planned procedure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedStep {
    /// The step's tag.
    pub tag: Symbol,
    /// Activity of the step.
    pub activity: PlannedActivity,
    /// Line of the step in the procedure's text, from 1.
    pub line: u32,
}

/// Manner in which a site is inspected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LookFrom {
    /// From one point: for vehicles that hover.
    Point,
    /// From a circle around the point: for vehicles that cannot hover.
    Circle,
}

/// Activity of a step of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum PlannedActivity {
    /// Fly every line over a target with the scanner on.
    Observe {
        /// The target's id.
        target: String,
        /// Ends of each line, in the order flown.
        lines: Vec<(Location, Location)>,
        /// Expected end, since the mission's start; `None` if it is not stated.
        due: Option<Duration>,
    },
    /// Fly every line over a target and take pictures by distance.
    Photograph {
        /// The target's id.
        target: String,
        /// Ends of each line, in the order flown.
        lines: Vec<(Location, Location)>,
        /// The camera.
        camera: String,
        /// Distance over ground between pictures.
        every_m: f64,
        /// True airspeed along the lines.
        speed_mps: f64,
        /// Expected end, since the mission's start.
        due: Duration,
    },
    /// Fly to a point and take pictures from there.
    Inspect {
        /// The target's id.
        target: String,
        /// Location of the hover.
        from: Location,
        /// The camera.
        camera: String,
        /// Name of the target of the camera.
        at: String,
        /// Number of pictures.
        count: u32,
        /// Expected end, since the mission's start.
        due: Duration,
    },
    /// Fly to a site and observe it.
    Visit {
        /// The site's id.
        site: String,
        /// Point or circle.
        from: LookFrom,
        /// The point, or the centre of the circle.
        at: Location,
        /// Duration of the observation.
        dwell: Duration,
        /// The camera that looks; `None`: the vehicle carries none.
        camera: Option<String>,
    },
    /// Fly to a point.
    FlyTo(Location),
    /// Stay at a point.
    Loiter {
        /// The point.
        at: Location,
        /// Duration.
        time: Duration,
    },
    /// Stay at a point until an instant; if that has passed, only fly there.
    LoiterUntil {
        /// The point.
        at: Location,
        /// End, since the mission's start.
        until: Duration,
    },
    /// Any other ground goal.
    Goal(Value),
    /// Fly a manoeuvre of library "manoeuvres" at a target and take pictures by distance.
    Perform {
        /// The target's id, or the name of its look.
        target: String,
        /// Name of the place that the manoeuvre is flown around.
        at: String,
        /// The manoeuvre, for example `(orbit :radius 60m :height 40m)`.
        form: Value,
        /// The camera.
        camera: String,
        /// Airspeed of a fixed wing, ground speed of a rotorcraft.
        speed_mps: f64,
        /// Distance over ground between pictures.
        every_m: f64,
        /// Expected end, since the mission's start.
        due: Duration,
    },
}

impl PlannedActivity {
    /// Returns the target that the activity observes; `None` for a transit.
    pub fn target(&self) -> Option<&str> {
        match self {
            PlannedActivity::Observe { target, .. }
            | PlannedActivity::Photograph { target, .. }
            | PlannedActivity::Inspect { target, .. }
            | PlannedActivity::Perform { target, .. } => Some(target),
            PlannedActivity::Visit { site, .. } => Some(site),
            PlannedActivity::FlyTo(_)
            | PlannedActivity::Loiter { .. }
            | PlannedActivity::LoiterUntil { .. }
            | PlannedActivity::Goal(_) => None,
        }
    }

    /// Returns the goal that the step pursues.
    pub fn goal(&self) -> Value {
        let word = Value::symbol;
        match self {
            PlannedActivity::Observe { target, lines, due } => {
                let lines = lines.iter().map(|(from, to)| Value::list([from.value(), to.value()]));
                let lines = Value::list(lines);
                let due = due.iter().flat_map(|due| [word("due"), Value::Duration(*due)]);
                Value::list([word("observe"), word(target), word("along"), lines].into_iter().chain(due))
            }
            PlannedActivity::Photograph { target, lines, camera, every_m, speed_mps, due } => {
                let lines = lines.iter().map(|(from, to)| Value::list([from.value(), to.value()]));
                let every = Value::measured(*every_m, Dimension::LENGTH);
                let speed = Value::measured(*speed_mps, Dimension::SPEED);
                let head = [word("photograph"), word(target), word("along"), Value::list(lines)];
                let how = [word("with"), word(camera), word("every"), every, word("at"), speed];
                Value::list(head.into_iter().chain(how).chain([word("due"), Value::Duration(*due)]))
            }
            PlannedActivity::Inspect { target, from, camera, at, count, due } => {
                let head = [word("inspect"), word(target), word("from"), from.value(), word("with"), word(camera)];
                let how = [word("pointed"), word("at"), word(at), word("taking"), Value::Integer(i64::from(*count))];
                Value::list(head.into_iter().chain(how).chain([word("due"), Value::Duration(*due)]))
            }
            PlannedActivity::Visit { site, from, at, dwell, camera } => {
                let from = word(match from {
                    LookFrom::Point => "at",
                    LookFrom::Circle => "around",
                });
                let head = [word("visit"), word(site), from, at.value(), word("for"), Value::Duration(*dwell)];
                let with = camera.iter().flat_map(|camera| [word("with"), word(camera)]);
                Value::list(head.into_iter().chain(with))
            }
            PlannedActivity::FlyTo(to) => Value::list([word("fly"), word("to"), to.value()]),
            PlannedActivity::Loiter { at, time } => {
                Value::list([word("loiter"), word("at"), at.value(), word("for"), Value::Duration(*time)])
            }
            PlannedActivity::LoiterUntil { at, until } => {
                Value::list([word("loiter"), word("at"), at.value(), word("until"), Value::Duration(*until)])
            }
            PlannedActivity::Goal(goal) => goal.clone(),
            PlannedActivity::Perform { target, at, form, camera, speed_mps, every_m, due } => {
                let head = [word("perform"), form.clone(), word("at"), word(at), word("for"), word(target)];
                let how = [word("with"), word(camera), word("at"), Value::measured(*speed_mps, Dimension::SPEED)];
                let every = [word("every"), Value::measured(*every_m, Dimension::LENGTH)];
                let due = [word("due"), Value::Duration(*due)];
                Value::list(head.into_iter().chain(how).chain(every).chain(due))
            }
        }
    }

    /// Reads a ground goal. A goal of any other form is [`PlannedActivity::Goal`], and so is one with a location instead of a named
    /// target, because the other variants contain names.
    pub fn from_goal(goal: &Value) -> PlannedActivity {
        known_goal(goal).unwrap_or_else(|| PlannedActivity::Goal(goal.clone()))
    }
}

/// Returns the name of a target, camera or place; `None` for a location.
fn name_of(value: &Value) -> Option<String> {
    value.as_list().is_none().then(|| value.to_string())
}

/// Returns true if the items at the given indices are the given words.
fn has_words(items: &[Value], words: &[(usize, &str)]) -> bool {
    let is = |(index, word): &(usize, &str)| {
        items.get(*index).and_then(Value::as_symbol).is_some_and(|symbol| symbol.is(word))
    };
    words.iter().all(is)
}

fn photograph(goal: &Value) -> Option<PlannedActivity> {
    let items = goal.as_list()?;
    let [_, target, _, lines, _, camera, _, every, _, speed, _, Value::Duration(due)] = items else { return None };
    let measured = |value: &Value, dimension: Dimension| match value.as_number()? {
        (number, found) if found == dimension => Some(number),
        _ => None,
    };
    let ends = |line: &Value| match line.as_list()? {
        [from, to] => Some((Location::from_value(from)?, Location::from_value(to)?)),
        _ => None,
    };
    has_words(items, &[(2, "along"), (4, "with"), (6, "every"), (8, "at"), (10, "due")]).then_some(())?;
    Some(PlannedActivity::Photograph {
        target: name_of(target)?,
        lines: lines.as_list()?.iter().map(ends).collect::<Option<_>>()?,
        camera: name_of(camera)?,
        every_m: measured(every, Dimension::LENGTH)?,
        speed_mps: measured(speed, Dimension::SPEED)?,
        due: *due,
    })
}

fn perform(goal: &Value) -> Option<PlannedActivity> {
    let items = goal.as_list()?;
    let [_, form, _, at, _, target, _, camera, _, speed, _, every, _, Value::Duration(due)] = items else {
        return None;
    };
    let words = [(2, "at"), (4, "for"), (6, "with"), (8, "at"), (10, "every"), (12, "due")];
    has_words(items, &words).then_some(())?;
    let measured = |value: &Value, dimension: Dimension| {
        value.as_number().filter(|(_, found)| *found == dimension).map(|(number, _)| number)
    };
    Some(PlannedActivity::Perform {
        target: target.to_string(),
        at: at.to_string(),
        form: form.clone(),
        camera: camera.to_string(),
        speed_mps: measured(speed, Dimension::SPEED)?,
        every_m: measured(every, Dimension::LENGTH)?,
        due: *due,
    })
}

fn inspect(goal: &Value) -> Option<PlannedActivity> {
    let items = goal.as_list()?;
    let [_, target, _, from, _, camera, _, _, at, _, Value::Integer(count), _, Value::Duration(due)] = items else {
        return None;
    };
    has_words(items, &[(2, "from"), (4, "with"), (6, "pointed"), (7, "at"), (9, "taking"), (11, "due")])
        .then_some(())?;
    Some(PlannedActivity::Inspect {
        target: name_of(target)?,
        from: Location::from_value(from)?,
        camera: name_of(camera)?,
        at: name_of(at)?,
        count: u32::try_from(*count).ok()?,
        due: *due,
    })
}

fn known_goal(goal: &Value) -> Option<PlannedActivity> {
    let is = |value: &Value, word: &str| value.as_symbol().is_some_and(|symbol| symbol.is(word));
    match goal.as_list()? {
        [head, target, along, lines, rest @ ..] if is(head, "observe") && is(along, "along") => {
            let due = match rest {
                [] => None,
                [word, Value::Duration(due)] if is(word, "due") => Some(*due),
                _ => return None,
            };
            let ends = |line: &Value| match line.as_list()? {
                [from, to] => Some((Location::from_value(from)?, Location::from_value(to)?)),
                _ => None,
            };
            let lines = lines.as_list()?.iter().map(ends).collect::<Option<_>>()?;
            Some(PlannedActivity::Observe { target: name_of(target)?, lines, due })
        }
        [head, ..] if is(head, "photograph") => photograph(goal),
        [head, ..] if is(head, "inspect") => inspect(goal),
        [head, ..] if is(head, "perform") => perform(goal),
        [head, site, from, at, time, Value::Duration(dwell), rest @ ..] if is(head, "visit") && is(time, "for") => {
            let camera = match rest {
                [] => None,
                [with, camera] if is(with, "with") => Some(name_of(camera)?),
                _ => return None,
            };
            let from = match from.as_symbol()? {
                word if word.is("at") => LookFrom::Point,
                word if word.is("around") => LookFrom::Circle,
                _ => return None,
            };
            let at = Location::from_value(at)?;
            Some(PlannedActivity::Visit { site: name_of(site)?, from, at, dwell: *dwell, camera })
        }
        [head, to, place] if is(head, "fly") && is(to, "to") => Location::from_value(place).map(PlannedActivity::FlyTo),
        [head, word, place, span, Value::Duration(time)] if is(head, "loiter") && is(word, "at") && is(span, "for") => {
            Some(PlannedActivity::Loiter { at: Location::from_value(place)?, time: *time })
        }
        [head, word, place, span, Value::Duration(until)]
            if is(head, "loiter") && is(word, "at") && is(span, "until") =>
        {
            Some(PlannedActivity::LoiterUntil { at: Location::from_value(place)?, until: *until })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Position;

    fn location(latitude_deg: f64) -> Location {
        Location { position: Position::new(latitude_deg, -118.25), altitude_m: 6_500.0 }
    }

    #[test]
    fn every_activity_is_read_back_from_its_goal() {
        let minute = Duration::from_seconds(60.0);
        let lines = vec![(location(34.5), location(34.75)), (location(35.0), location(35.5))];
        let visit = |from, camera: Option<&str>| PlannedActivity::Visit {
            site: "barn".into(),
            from,
            at: location(1.5),
            dwell: minute,
            camera: camera.map(str::to_owned),
        };
        let look = |from| visit(from, None);
        let camera = || "camera-1".to_owned();
        let observe = |due| PlannedActivity::Observe { target: "butler-2".into(), lines: lines.clone(), due };
        let all = [
            observe(Some(minute)),
            observe(None),
            look(LookFrom::Point),
            look(LookFrom::Circle),
            visit(LookFrom::Point, Some("camera-1")),
            PlannedActivity::Photograph {
                target: "dam".into(),
                lines: lines.clone(),
                camera: camera(),
                every_m: 12.5,
                speed_mps: 5.0,
                due: minute,
            },
            PlannedActivity::Inspect {
                target: "valve-3".into(),
                from: location(1.5),
                camera: camera(),
                at: "valve-3".into(),
                count: 2,
                due: minute,
            },
            PlannedActivity::FlyTo(location(2.5)),
            PlannedActivity::Loiter { at: location(3.5), time: minute },
            PlannedActivity::LoiterUntil { at: location(3.5), until: minute },
            PlannedActivity::Goal(Value::list([Value::symbol("say"), Value::Integer(3)])),
            PlannedActivity::Perform {
                target: "dam/oblique".into(),
                at: "dam".into(),
                form: Value::list([Value::symbol("orbit"), Value::symbol(":radius"), Value::Real(60.0)]),
                camera: camera(),
                speed_mps: 5.0,
                every_m: 12.5,
                due: minute,
            },
        ];
        for activity in all {
            assert_eq!(PlannedActivity::from_goal(&activity.goal()), activity);
        }
    }

    #[test]
    fn a_location_in_place_of_a_target_is_kept_as_a_location() {
        let visit = PlannedActivity::Inspect {
            target: "valve-3".into(),
            from: location(1.5),
            camera: "camera-1".into(),
            at: "valve-3".into(),
            count: 1,
            due: Duration::from_seconds(60.0),
        };
        let replaced =
            |item: &Value| if *item == Value::symbol("valve-3") { location(0.5).value() } else { item.clone() };
        let goal = Value::list(visit.goal().as_list().unwrap_or_default().iter().map(replaced));
        assert_eq!(PlannedActivity::from_goal(&goal).goal(), goal);
    }

    #[test]
    fn goals_that_lack_a_part_stay_plain_goals() {
        let visit = PlannedActivity::FlyTo(location(2.5)).goal();
        let short = Value::list(visit.as_list().unwrap_or_default().iter().take(2).cloned());
        assert_eq!(PlannedActivity::from_goal(&short), PlannedActivity::Goal(short.clone()));
        let word = Value::symbol("observe");
        assert_eq!(PlannedActivity::from_goal(&word), PlannedActivity::Goal(word.clone()));
    }
}
