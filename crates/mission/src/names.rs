//! Names of a mission for the check of its program: places, cameras, radios, aircraft, planners and scripted messages.

use crate::Mission;
use crate::deliberation::HUMAN;
use apex_model::event::EventKind;
use apex_model::interface::NameKind;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use apex_pdl::{Diagnostic, KnownNames};
use apex_planning::Registry;
use std::collections::{BTreeMap, BTreeSet};

/// Compares the names in a mission's program with its data, and its solvers with `registry`.
///
/// Returns the findings in order of place. Names that the mission does not have are errors; messages that nothing sends are warnings.
pub fn check_names(mission: &Mission, registry: &Registry) -> Vec<Diagnostic> {
    apex_pdl::check_names(&mission.library, &known_names(mission, registry))
}

fn known_names(mission: &Mission, registry: &Registry) -> KnownNames {
    fn symbols<'a>(names: impl Iterator<Item = &'a str>) -> BTreeSet<Symbol> {
        names.map(Symbol::new).collect()
    }
    let fields = mission.airfields.iter().map(|airfield| airfield.id.as_str());
    let places = symbols(fields.chain(mission.targets.iter().map(|target| target.id.as_str())));
    let cameras = symbols(mission.model.cameras.iter().map(|camera| camera.name.as_str()));
    let radios = mission.modems.iter().map(|modem| modem.name.as_str());
    let modems = symbols(radios.chain(mission.link_map.iter().map(|link| link.name.as_str())));
    let crew = mission.library.crew();
    let aircraft = symbols(crew.iter().map(|agent| agent.name.printed()));
    let planners = registry.iter().map(|solver| solver.name());
    let solvers = symbols(planners.chain(["auto", HUMAN, crate::acquisition::SOLVER]));
    let heads = mission.scenario.iter().filter_map(|input| match &input.kind {
        EventKind::Occurrence(Value::List(items)) => items.first()?.as_symbol().cloned(),
        _ => None,
    });
    let mut names =
        BTreeMap::from([(NameKind::Place, places), (NameKind::Camera, cameras), (NameKind::Aircraft, aircraft)]);
    // `:modems` are the radios of the built-in simulator; another world may have others.
    if mission.library.application.as_ref().is_none_or(|application| application.kind.is("native-sim")) {
        names.insert(NameKind::Modem, modems);
    }
    KnownNames { names, solvers, messages: heads.collect(), duration: Some(mission.settings.duration) }
}
