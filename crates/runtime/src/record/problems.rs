//! Planning problems, their answers and the situations of the mission, as recorded.

use super::reader::RecordReader;
use crate::error::RecordError;
use apex_model::effect::SolveRequestId;
use apex_model::event::SolverReport;
use apex_model::time::Time;
use rusqlite::{OptionalExtension, params};

/// A row of the `problem` table.
#[derive(Clone, Debug, PartialEq)]
pub struct ProblemRow {
    /// The request, numbered as outside of the agents.
    pub request: SolveRequestId,
    /// Instant of its creation.
    pub at: Time,
    /// The goal to plan for.
    pub goal: String,
    /// The requested solver, or `auto`.
    pub solver: String,
    /// The problem as JSON.
    pub problem: String,
    /// The answer and the instant at which it takes effect; `None` if no answer arrived.
    pub answer: Option<(Time, SolverReport)>,
    /// The plan as JSON, if the answer contains one.
    pub plan: Option<String>,
}

/// The mission's situation after a batch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SituationRow {
    /// The batch's number.
    pub batch_number: i64,
    /// Its instant.
    pub at: Time,
    /// The encoded value.
    pub body: Vec<u8>,
}

impl RecordReader {
    /// Returns all planning problems in the order in which they were posed.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn problems(&self) -> Result<Vec<ProblemRow>, RecordError> {
        let broken = |error| self.damaged("the planning problems", error);
        // Of several answers to one request the last counts.
        let sql = "SELECT p.request, p.t_ns, p.goal, p.solver, p.body, a.due_ns, a.report, a.plan FROM problem p \
                   LEFT JOIN answer a ON a.position = (SELECT max(position) FROM answer WHERE request = p.request) \
                   ORDER BY p.t_ns, p.batch, p.request";
        let mut statement = self.connection.prepare(sql).map_err(broken)?;
        let mut rows = statement.query([]).map_err(broken)?;
        let mut problems = Vec::new();
        while let Some(row) = rows.next().map_err(broken)? {
            let request = SolveRequestId(row.get::<_, i64>(0).map_err(broken)? as u64);
            let due: Option<i64> = row.get(5).map_err(broken)?;
            let report: Option<Vec<u8>> = row.get(6).map_err(broken)?;
            let garbled = |error| self.garbled(format!("the answer to request {} is garbled ({error})", request.0));
            let report = report.map(|bytes| postcard::from_bytes(&bytes).map_err(garbled)).transpose()?;
            problems.push(ProblemRow {
                request,
                at: Time(row.get(1).map_err(broken)?),
                goal: row.get(2).map_err(broken)?,
                solver: row.get(3).map_err(broken)?,
                problem: row.get(4).map_err(broken)?,
                answer: due.map(Time).zip(report),
                plan: row.get(7).map_err(broken)?,
            });
        }
        Ok(problems)
    }

    /// Returns all answers of solvers in order of arrival: request, instant of effect, answer.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub(crate) fn answers(&self) -> Result<Vec<(SolveRequestId, Time, SolverReport)>, RecordError> {
        let broken = |error| self.damaged("the answers of solvers", error);
        let mut statement =
            self.connection.prepare("SELECT request, due_ns, report FROM answer ORDER BY position").map_err(broken)?;
        let mut rows = statement.query([]).map_err(broken)?;
        let mut answers = Vec::new();
        while let Some(row) = rows.next().map_err(broken)? {
            let request = SolveRequestId(row.get::<_, i64>(0).map_err(broken)? as u64);
            let body = row.get_ref(2).and_then(|cell| Ok(cell.as_blob()?)).map_err(broken)?;
            let report = postcard::from_bytes(body)
                .map_err(|error| self.garbled(format!("the answer to request {} is garbled ({error})", request.0)))?;
            answers.push((request, Time(row.get(1).map_err(broken)?), report));
        }
        Ok(answers)
    }

    /// Returns the last stored situation of the mission that is not later than `to`.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn situation_before(&self, to: Time) -> Result<Option<SituationRow>, RecordError> {
        let sql = "SELECT batch, t_ns, body FROM situation WHERE t_ns <= ?1 ORDER BY batch DESC LIMIT 1";
        let row = self.connection.query_row(sql, params![to.0], situation);
        row.optional().map_err(|error| self.damaged("the situations", error))
    }

    /// Returns all stored situations of the mission, in order.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn situations(&self) -> Result<Vec<SituationRow>, RecordError> {
        let broken = |error| self.damaged("the situations", error);
        let mut statement =
            self.connection.prepare("SELECT batch, t_ns, body FROM situation ORDER BY batch").map_err(broken)?;
        let rows = statement.query_map([], situation).map_err(broken)?;
        rows.collect::<Result<_, _>>().map_err(broken)
    }
}

fn situation(row: &rusqlite::Row<'_>) -> rusqlite::Result<SituationRow> {
    Ok(SituationRow { batch_number: row.get(0)?, at: Time(row.get(1)?), body: row.get(2)? })
}
