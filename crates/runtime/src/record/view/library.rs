//! The program of a record: its files and their declarations. All of it is known from the start of the flight.

use super::RecordView;
use crate::error::RecordError;
use apex_forms::print::Style::Brief;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::library::{Library, ResourceKind};
use apex_model::procedure::{Activity, Procedure, ProcedureKind, Step};
use rusqlite::OptionalExtension;
use serde::Serialize;

/// Declarations of the program of a record.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ProgramContents {
    /// The files, in the order in which they were loaded.
    pub files: Vec<ProgramFile>,
    /// The names of the agents, in the order of their numbers.
    pub agents: Vec<String>,
    /// Procedures, primitives and solvers, in written order of each kind.
    pub procedures: Vec<ProcedureRow>,
    /// Declared resources.
    pub resources: Vec<DeclaredName>,
    /// Declared state variables; others may be measured, too.
    pub variables: Vec<DeclaredName>,
}

/// A file of the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ProgramFile {
    /// Its name in the record.
    pub name: String,
    /// Number of its lines.
    pub lines: usize,
}

/// A declared name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DeclaredName {
    /// The name.
    pub name: String,
    /// Details of the declaration: a unit, `unitary`, `capacity 3`.
    pub detail: String,
    /// `file:line:column` of the declaration.
    pub place: String,
}

/// A procedure, primitive or solver.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ProcedureRow {
    /// `procedure`, `primitive` or `solver`.
    pub kind: String,
    /// The class of goals that the definition serves.
    pub index: String,
    /// `file:line:column`
    pub place: String,
    /// Order of the steps: `concurrent`, `sequential`, `ranked`, `soft-sequential`; empty without steps.
    pub order: String,
    /// The steps in written order.
    pub steps: Vec<StepRow>,
}

/// A step of a procedure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct StepRow {
    /// Its tag.
    pub tag: String,
    /// Its activity as PDL text.
    pub activity: String,
    /// `file:line:column`
    pub place: String,
    /// The tags of the steps for whose end it waits.
    pub after: Vec<String>,
    /// Other conditions for which it waits, as PDL text.
    pub waits: Vec<String>,
    /// True if it repeats or responds.
    pub repeats: bool,
    /// True if it ends the procedure.
    pub ends: bool,
}

/// A file of the program with its text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ProgramText {
    /// Its name in the record.
    pub name: String,
    /// Its lines.
    pub lines: Vec<String>,
}

impl RecordView {
    /// Returns the files of the record's program, and the declarations of `library`.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn program(&self, library: Option<&Library>) -> Result<ProgramContents, RecordError> {
        let files = self.reader.pdl_sources()?;
        let files =
            files.into_iter().map(|file| ProgramFile { lines: file.text.lines().count(), name: file.name.to_string() });
        let mut contents = ProgramContents {
            files: files.collect(),
            agents: self.reader.agents().to_vec(),
            procedures: Vec::new(),
            resources: Vec::new(),
            variables: Vec::new(),
        };
        if let Some(library) = library {
            declare(library, &mut contents);
        }
        Ok(contents)
    }

    /// Returns the text of a file of the program; `None` if the record has no such file.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn program_text(&self, name: &str) -> Result<Option<ProgramText>, RecordError> {
        let body: Option<Vec<u8>> = self.query("the sources", |connection| {
            connection
                .prepare_cached("SELECT CAST(body AS BLOB) FROM source WHERE name = ?1 ORDER BY position LIMIT 1")?
                .query_row([name], |row| row.get(0))
                .optional()
        })?;
        Ok(body.map(|body| ProgramText {
            name: name.to_owned(),
            lines: String::from_utf8_lossy(&body).lines().map(str::to_owned).collect(),
        }))
    }
}

fn declare(library: &Library, contents: &mut ProgramContents) {
    let procedures = library.procedures.iter().map(|each| procedure(library, each));
    let primitives =
        library.primitives.iter().map(|each| plain(library, "primitive", &Brief.pattern(&each.index), each.place));
    let solvers = library.solvers.iter().map(|each| plain(library, "solver", &Brief.pattern(&each.index), each.place));
    contents.procedures = procedures.chain(primitives).chain(solvers).collect();
    let resources = library.resources.iter().map(|(name, declared)| DeclaredName {
        name: name.to_string(),
        detail: match &declared.kind {
            ResourceKind::Unitary => "one holder".to_owned(),
            ResourceKind::Capacity(units) => format!("capacity {units}"),
            ResourceKind::Depletable(amount) => format!("depletable, {amount}"),
            ResourceKind::Renewable(amount) => format!("renewable, up to {amount}"),
        },
        place: library.describe_place(declared.place),
    });
    contents.resources = resources.collect();
    let variables = library.state_variables.iter().map(|(name, declared)| DeclaredName {
        name: name.to_string(),
        detail: declared.unit.as_ref().or(declared.value_type.as_ref()).map(ToString::to_string).unwrap_or_default(),
        place: library.describe_place(declared.place),
    });
    contents.variables = variables.collect();
}

fn plain(library: &Library, kind: &str, index: &str, place: apex_model::source::Place) -> ProcedureRow {
    ProcedureRow {
        kind: kind.to_owned(),
        index: index.to_owned(),
        place: library.describe_place(place),
        order: String::new(),
        steps: Vec::new(),
    }
}

fn procedure(library: &Library, procedure: &Procedure) -> ProcedureRow {
    let order = match procedure.kind {
        ProcedureKind::Concurrent => "concurrent",
        ProcedureKind::Sequential => "sequential",
        ProcedureKind::Ranked => "ranked",
        ProcedureKind::SoftSequential => "soft-sequential",
    };
    let is_sequential = procedure.kind == ProcedureKind::Sequential;
    let mut before: Option<&Step> = None;
    let mut steps = Vec::new();
    for each in &procedure.steps {
        let mut row = step(library, each);
        if let Some(before) = before.filter(|_| is_sequential) {
            row.after.insert(0, before.tag.to_string());
        }
        row.after.dedup();
        steps.push(row);
        before = Some(each);
    }
    let index = Brief.pattern(&procedure.index);
    ProcedureRow { order: order.to_owned(), steps, ..plain(library, "procedure", &index, procedure.place) }
}

fn step(library: &Library, step: &Step) -> StepRow {
    let (mut after, mut waits) = (Vec::new(), Vec::new());
    step.waitfor.iter().for_each(|condition| sort(condition, &mut after, &mut waits));
    StepRow {
        tag: step.tag.to_string(),
        activity: Brief.activity(&step.activity),
        place: library.describe_place(step.place),
        after,
        waits,
        repeats: step.repeating.is_some() || step.responding.is_some(),
        ends: matches!(&step.activity, Activity::Terminate { task: None, .. }),
    }
}

/// Sorts the conditions of a `waitfor`: ends of other steps that must all occur become edges, all other conditions remain text.
fn sort(condition: &Condition, after: &mut Vec<String>, waits: &mut Vec<String>) {
    match &condition.kind {
        ConditionKind::TaskEnded(tag) => after.push(tag.to_string()),
        ConditionKind::And(parts, constraints) if constraints.is_empty() => {
            parts.iter().for_each(|part| sort(part, after, waits));
        }
        _ => waits.push(Brief.condition(condition)),
    }
}
