//! Planning of missions and problems for Python; answers are passed as the JSON of `docs/reference/schema/plan.schema.json`.

use crate::errors::{input, mission as failed, planning};
use crate::planner::{Planners, registry};
use apex_mission::deliberation::{PlanningResources, SolveOptions, name_obstacles, solve_for_landing};
use apex_mission::error::{MissionError, MissionResult};
use apex_mission::export::json;
use apex_mission::export::table::PlanFacts;
use apex_mission::plan::input::PlanInput;
use apex_mission::plan::{problem_file, proof, turns};
use apex_mission::{TargetKind, program};
use apex_model::time::Duration;
use apex_pdl::{Diagnostic, Severity};
use apex_portfolio::ProfileTable;
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::CancelToken;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// The longest time that a caller may state, in seconds: a hundred years.
const TIME_S_MAX: f64 = 3.2e9;

/// Planners, the table that selects among them, and the limits of one request.
#[pyclass(module = "apex_autonomy", frozen)]
pub(crate) struct Means {
    pub(crate) inner: PlanningResources,
}

#[pymethods]
impl Means {
    /// Returns the planners that ship and `planners`; `table` is the text of a profile table.
    #[new]
    #[pyo3(signature = (planners, *, table=None, solver_timeout_s=None, solver_memory_mib=None))]
    fn new(
        python: Python<'_>,
        planners: Planners,
        table: Option<&str>,
        solver_timeout_s: Option<f64>,
        solver_memory_mib: Option<u32>,
    ) -> PyResult<Means> {
        let mut inner = PlanningResources::of(&Arc::new(registry(planners)?));
        if let Some(text) = table {
            let read = ProfileTable::read(text).map_err(|error| {
                let place = format!("the profile table:{}:{}", error.line, error.column);
                failed(python, MissionError::data(error.message).at(place).because(error.reason).help(error.help))
            });
            inner.table = Some(Arc::new(read?));
        }
        if let Some(timeout_s) = solver_timeout_s {
            inner.timeout = std::time::Duration::from_secs_f64(positive(timeout_s, "solver_timeout_s")?);
        }
        if let Some(mebibytes) = solver_memory_mib {
            inner.memory_bytes = u64::from(mebibytes) << 20;
        }
        Ok(Means { inner })
    }
}

/// A mission that was read from a folder or a program.
#[pyclass(module = "apex_autonomy", name = "Mission", frozen)]
pub(crate) struct LoadedMission {
    pub(crate) inner: Arc<apex_mission::Mission>,
    warnings: Vec<String>,
}

#[pymethods]
impl LoadedMission {
    #[staticmethod]
    fn load(python: Python<'_>, path: PathBuf) -> PyResult<LoadedMission> {
        let loaded = python.detach(|| -> MissionResult<LoadedMission> {
            let checked = program::load_program(&path)?;
            let render = |diagnostic: &Diagnostic| {
                let one = std::slice::from_ref(diagnostic);
                apex_pdl::render(one, &checked.library.sources, false).trim_end().to_string()
            };
            let is_warning = |diagnostic: &&Diagnostic| diagnostic.severity == Severity::Warning;
            let warnings = checked.diagnostics.iter().filter(is_warning).map(render).collect();
            let inner = Arc::new(apex_mission::Mission::of_program(&path, Arc::new(checked.library))?);
            Ok(LoadedMission { inner, warnings })
        });
        loaded.map_err(|failure| failed(python, failure))
    }
    #[getter]
    fn name(&self) -> &str {
        &self.inner.settings.name
    }
    #[getter]
    fn vehicle(&self) -> &str {
        &self.inner.model.name
    }
    #[getter]
    fn duration_s(&self) -> f64 {
        self.inner.settings.duration.seconds()
    }
    #[getter]
    fn seed(&self) -> u64 {
        self.inner.settings.seed
    }
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }
    #[getter]
    fn targets_json(&self) -> String {
        let target = |target: &apex_mission::Target| {
            let kind = match target.kind {
                TargetKind::Fire(_) => "fire",
                TargetKind::Site(_) => "site",
                TargetKind::Base => "base",
                TargetKind::Plain => "place",
            };
            serde_json::json!({
                "id": target.id,
                "name": target.name,
                "kind": kind,
                "latitude_deg": target.position.latitude_deg,
                "longitude_deg": target.position.longitude_deg,
                "elevation_m": target.elevation_m,
                "worth": target.worth(),
            })
        };
        serde_json::Value::from_iter(self.inner.targets.iter().map(target)).to_string()
    }
    /// Plans for the mission at its start: the posed problem and the answer, both JSON.
    fn plan_json(
        &self,
        python: Python<'_>,
        solver: Option<&str>,
        budget_s: Option<f64>,
        seed: Option<u64>,
        means: &Means,
    ) -> PyResult<(String, String)> {
        let budget = budget_s.map(|budget_s| positive(budget_s, "budget_s")).transpose()?;
        let planned = python.detach(|| -> MissionResult<(String, String)> {
            let mut input = PlanInput::of_mission(apex_mission::Mission::clone(&self.inner))?;
            input.budget = budget.map_or(input.budget, Duration::from_seconds);
            input.seed = seed.unwrap_or(input.seed);
            let answer = answer(&input, solver, &means.inner)?;
            Ok((serde_json::json!(input.problem).to_string(), answer))
        });
        planned.map_err(|failure| planning(python, failure))
    }
}

/// Plans for a problem in JSON; the answer is JSON too.
#[pyfunction]
pub(crate) fn plan_json(
    python: Python<'_>,
    problem: &str,
    solver: Option<&str>,
    budget_s: f64,
    seed: u64,
    means: &Means,
) -> PyResult<String> {
    let budget = Duration::from_seconds(positive(budget_s, "budget_s")?);
    let planned = python.detach(|| {
        let mut input = PlanInput::of_json(problem, "the problem")?;
        (input.budget, input.seed) = (budget, seed);
        answer(&input, solver, &means.inner)
    });
    planned.map_err(|failure| planning(python, failure))
}

/// Returns the problem of a test mission, of a file of JSON, or of a benchmark's file, as JSON.
#[pyfunction]
pub(crate) fn problem_json(python: Python<'_>, path: PathBuf) -> PyResult<String> {
    let found = python.detach(|| match PlanInput::find(&path)? {
        Some(input) => Ok(problem_file::write(&input.problem)),
        None => Err(MissionError::planning(format!("{} is not a planning problem", path.display())).help(
            "give a problem's file or the name of a test mission; `Mission.plan` poses the problem of a mission",
        )),
    });
    found.map_err(|failure| planning(python, failure))
}

/// Solves, proves a bound, and writes both.
fn answer(input: &PlanInput, solver: Option<&str>, means: &PlanningResources) -> MissionResult<String> {
    let wish = SolveOptions { means, solver, budget: input.budget, seed: input.seed, previous: None };
    let (mut invocations, cancel) = (Invocations::new(), CancelToken::new());
    let mut solved = solve_for_landing(input.mission(), input.problem.clone(), wish, &mut invocations, &cancel)
        .map_err(|reason| MissionError::planning("no plan was found").because(reason))?;
    if let Some(mission) = input.mission() {
        name_obstacles(mission, &mut solved);
    }
    let proven = proof::prove(&mut solved, input.is_tour(), input.bound_budget)?;
    let turns = turns::of(&solved.problem, &solved.plan, input.mission());
    let facts = PlanFacts { proven: &proven, turns, survival: None, air_changes: input.air_changes() };
    Ok(json::write(&input.name, input.benchmark.as_ref(), &solved, &facts))
}

/// Returns a number greater than zero: seconds, or a factor of time.
pub(crate) fn positive(number: f64, name: &str) -> PyResult<f64> {
    match number > 0.0 && number <= TIME_S_MAX {
        true => Ok(number),
        false => {
            Err(input(format!("`{name}` is {number:?}: write a number greater than 0 and at most {TIME_S_MAX:e}")))
        }
    }
}
