//! The text of an explanation and its data agree in every name, instant and cause, over the runs of all pages.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at an unexpected result")]

use apex_model::time::Time;
use apex_runtime::explain::{Explainer, Question};
use apex_spec::explained::disagreements;
use apex_spec::question::{Recorded, recorded};
use apex_spec::{page, verdict};
use serde_json::Value;

/// Number of queried tasks in one run, spread over all of its tasks.
const TASKS_MAX: usize = 3;
/// Number of falsified versions of one answer that are tried.
const TRIES_MAX: usize = 12;

/// Returns the answers about some tasks and all resources of a run, as data and as text.
fn answers(Recorded { reader, program, .. }: &Recorded) -> Vec<(Value, String)> {
    let load = |_: &[apex_model::source::SourceFile]| Ok(program.clone());
    let mut found = Vec::new();
    if reader.has_several_agents() {
        return found;
    }
    let tasks = reader.tasks().unwrap();
    let stride = tasks.len().div_ceil(TASKS_MAX).max(1);
    let explainer = Explainer::new(reader, &load);
    for (number, task) in tasks.iter().step_by(stride).enumerate() {
        // Alternately an early instant, a late one, and the end.
        let at = match number % 3 {
            0 => task.created,
            1 => Time::END,
            _ => task.ended.unwrap_or(Time::END),
        };
        let question = Question::new(&task.id.to_string(), at);
        let why = explainer.why(&question).unwrap();
        found.push((serde_json::to_value(&why).unwrap(), why.to_string()));
        let why_not = explainer.why_not(&question).unwrap();
        found.push((serde_json::to_value(&why_not).unwrap(), why_not.to_string()));
    }
    let mut names: Vec<String> = program.0.resources.keys().map(ToString::to_string).collect();
    let needs = program.0.primitives.iter().flat_map(|each| &each.profile);
    names.extend(needs.filter_map(|need| match &need.resource {
        apex_model::expression::Template::Constant(name) => Some(name.to_string()),
        _ => None,
    }));
    names.sort();
    names.dedup();
    let middle = tasks.get(tasks.len() / 2).map_or(Time::END, |task| task.created);
    for name in names.iter().take(2) {
        let asked = explainer.why(&Question::new(name, middle));
        found.extend(asked.ok().map(|why| (serde_json::to_value(&why).unwrap(), why.to_string())));
    }
    found
}

fn all() -> Vec<(String, Value, String)> {
    let mut all = Vec::new();
    for path in page::files() {
        let text = std::fs::read_to_string(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let runs = verdict::scenarios(&text).into_iter().filter(|(block, _)| block.kind == "trace");
        for (block, scenario) in runs {
            let Ok(run) = recorded(&scenario) else { continue };
            all.extend(answers(&run).into_iter().map(|(data, text)| (format!("{name}:{}", block.line), data, text)));
        }
    }
    all
}

/// Adds to `found` the paths of the members of `data` that can be falsified.
fn paths(data: &Value, path: &str, found: &mut Vec<String>) {
    match data {
        Value::Object(members) => {
            members.iter().for_each(|(name, part)| paths(part, &format!("{path}/{name}"), found));
        }
        Value::Array(parts) => {
            parts.iter().enumerate().for_each(|(number, part)| paths(part, &format!("{path}/{number}"), found));
            if !parts.is_empty() {
                found.push(path.to_string());
            }
        }
        Value::Null => {}
        _ => found.push(path.to_string()),
    }
}

/// Returns true for members that the text must show at any depth: time, subject, event, cause; and the lists of these.
fn is_shown(path: &str) -> bool {
    let parts: Vec<&str> = path.split('/').collect();
    let own = ["because", "history", "waiting", "blocked"];
    let shown = ["t", "what", "because", "causes", "state", "now", "history", "waiting", "goal"];
    parts.last().is_some_and(|last| shown.contains(last))
        && (parts.len() == 2 || own.contains(parts.get(1).unwrap_or(&"")))
}

/// Returns another value of the same kind; `None` if there is none with another meaning.
fn other(value: &Value) -> Option<Value> {
    match value {
        Value::Number(number) => number.as_f64().map(|number| Value::from(number + 0.625)),
        Value::String(text) if !text.is_empty() => Some(Value::from(format!("{text} T77"))),
        Value::Array(parts) => parts.split_last().map(|(_, rest)| Value::from(rest.to_vec())),
        _ => None,
    }
}

#[test]
fn text_and_data_say_the_same_on_all_pages() {
    let all = all();
    assert!(all.len() > 1_000, "{} answers", all.len());
    let mut wrong = Vec::new();
    let (mut tried, mut blind) = (0, Vec::new());
    for (number, (name, data, text)) in all.iter().enumerate() {
        wrong.extend(disagreements(data, text).into_iter().map(|what| format!("{name}: {what}")));
        // Falsified data of `why` are noticed.
        if data.get("question") != Some(&Value::from("why")) || data.get("task").is_none() {
            continue;
        }
        let mut members = Vec::new();
        paths(data, "", &mut members);
        // The middle of a long history is only in the data, and the text states how many moments are left out.
        let is_long = data.get("history").and_then(Value::as_array).is_some_and(|moments| moments.len() > 40);
        members.retain(|path| is_shown(path) && !(is_long && path.starts_with("/history/")));
        let stride = members.len().div_ceil(TRIES_MAX).max(1);
        for path in members.iter().skip(number % stride).step_by(stride) {
            let mut spoiled = data.clone();
            let place = spoiled.pointer_mut(path).unwrap();
            let Some(value) = other(place) else { continue };
            *place = value;
            tried += 1;
            if disagreements(&spoiled, text).is_empty() {
                blind.push(format!("{name}: {path}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{} facts:\n{}", wrong.len(), wrong.get(..wrong.len().min(25)).unwrap().join("\n"));
    assert!(tried > 2_000, "{tried}");
    assert!(
        blind.is_empty(),
        "{} of {tried} are not noticed:\n{}",
        blind.len(),
        blind.get(..blind.len().min(25)).unwrap().join("\n")
    );
}
