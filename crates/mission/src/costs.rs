//! Costs of ignorance that a mission's program defines: functions of the age of an event, tabulated for the planners.

use super::settings::Settings;
use super::targets::{Target, TargetKind};
use crate::error::{MissionError, MissionResult};
use crate::program;
use apex_executive::{Agent, call, load};
use apex_metrics::tabulate::tabulate;
use apex_model::library::Library;
use apex_model::problem::CostFunction;
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::sync::Arc;

/// Permitted error of tables, as a share of the cost.
const RELATIVE_ERROR: f64 = 1e-3;
const EXAMPLE: &str =
    "write for example `:costs ((barn hay-cost))` and `(defun hay-cost (age) (* 60 (- 1 (exp (- (/ age 10min))))))`";

/// Gives structures the costs that the application's `:costs` names.
///
/// # Errors
/// A name that is not a structure or not a function of the program, or a function that is not a cost.
pub(super) fn apply(settings: &Settings, library: &Arc<Library>, targets: &mut [Target]) -> MissionResult {
    if settings.costs.is_empty() {
        return Ok(());
    }
    let place = settings.place_of("costs");
    let agent = load(Arc::clone(library), &program::agent_of(library), program::host_functions())
        .map_err(|reason| MissionError::setting("`:costs` cannot be computed").at(place).because(reason))?;
    for (name, function) in &settings.costs {
        let Some(site) = targets.iter_mut().find(|target| target.id == *name).and_then(site_of) else {
            let structures = targets.iter_mut().filter_map(|target| site_of(target).is_some().then_some(&*target.id));
            let structures: Vec<&str> = structures.take(12).collect();
            return Err(MissionError::setting(format!("`:costs` names `{name}`, which is not a structure"))
                .at(place)
                .help(format!("structures are: {}", structures.join(", "))));
        };
        if settings.costs.iter().filter(|(other, _)| other == name).count() > 1 {
            return Err(MissionError::setting(format!("`:costs` names `{name}` twice"))
                .at(place)
                .help("give it one function"));
        }
        if !library.functions.contains_key(function) {
            return Err(MissionError::setting(format!(
                "`:costs` names `{function}`, which is not a function of the program"
            ))
            .at(place)
            .help(EXAMPLE));
        }
        let response_s = match &site.cost {
            CostFunction::Delayed { response_s, .. } => *response_s,
            _ => 0.0,
        };
        let oldest_s = settings.duration.seconds() + site.initial_age_s + response_s;
        let points =
            tabulate(&mut |age_s| cost_at(&agent, function, age_s), oldest_s, RELATIVE_ERROR).map_err(|why| {
                MissionError::setting(format!("`{function}` cannot be the cost of `{name}`"))
                    .at(place)
                    .because(why)
                    .help(EXAMPLE)
            })?;
        let table = CostFunction::Table { points };
        site.cost = match response_s > 0.0 {
            true => CostFunction::Delayed { response_s, cost: Box::new(table) },
            false => table,
        };
    }
    Ok(())
}

fn site_of(target: &mut Target) -> Option<&mut super::Site> {
    match &mut target.kind {
        TargetKind::Site(site) => Some(site),
        TargetKind::Fire(_) | TargetKind::Plain | TargetKind::Base => None,
    }
}

fn cost_at(agent: &Agent, function: &Symbol, age_s: f64) -> Result<f64, String> {
    let value = call(agent, function, &[Value::Duration(Duration::from_seconds(age_s))])?;
    match value.as_number() {
        Some((cost, Dimension::NONE)) => Ok(cost),
        _ => Err(format!("`{function}` gives {value}, which is not a number; divide the age by a time")),
    }
}
