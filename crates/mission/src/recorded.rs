//! The mission in a flight record: loads it, replays it, and returns its situation and report at an instant.

use crate::Mission;
use crate::crew;
use crate::deliberation::{MissionDeliberator, PlanningResources};
use crate::error::{MissionError, MissionResult};
use crate::flight::{MISSION_FACTS, facts, target_rows};
use crate::program;
use crate::recording::read;
use crate::report::{Report, report};
use crate::score::{FlownScore, told};
use crate::situation::Situation;
use apex_model::event::Batch;
use apex_model::source::SourceFile;
use apex_model::time::Time;
use apex_runtime::program::NoDeliberator;
use apex_runtime::record::{RecordReader, RecordedStep, RestoredProgram, SITUATION_LAYOUT, TargetRow, fold_both};
use apex_runtime::replay::{Difference, Differing, ReplayReport, replay_with};
use std::sync::Arc;

/// Returns the mission that a record holds; `None` if its program is not a mission.
///
/// # Errors
/// A record that cannot be read, a program or data that this version does not accept.
pub fn mission_of(reader: &RecordReader) -> MissionResult<Option<Mission>> {
    if reader.meta("mission").map_err(read)?.is_none() {
        return Ok(None);
    }
    let data = reader.sources().map_err(read)?.into_iter().filter(|source| source.role == "data");
    let data = data.map(|source| (source.name, source.body)).collect();
    Mission::from_sources(&reader.pdl_sources().map_err(read)?, data).map(Some)
}

/// Returns the program of a record with the host functions of its flight: those of its mission, if the record contains one.
///
/// # Errors
/// A message that states why the record's program or mission cannot be loaded.
pub fn load_program(reader: &RecordReader, sources: &[SourceFile]) -> Result<RestoredProgram, String> {
    match mission_of(reader).map_err(|error| error.to_string())? {
        Some(mission) => crew::load_recorded_mission(&mission, sources),
        None => program::load_recorded(sources),
    }
}

/// Replays a record: decisions byte for byte, every planning problem posed again, every derived row and the report made again.
///
/// # Errors
/// A record that cannot be read, or whose mission cannot be loaded.
pub fn replay(reader: &RecordReader) -> MissionResult<ReplayReport> {
    let report = match mission_of(reader)? {
        Some(mission) => {
            let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
            let mission = Arc::new(mission);
            let mut deliberator = MissionDeliberator::new(Arc::clone(&mission), means);
            let load = |sources: &[SourceFile]| crew::load_recorded_mission(&mission, sources);
            let mut report = replay_with(reader, &load, &mut deliberator).map_err(read)?;
            if report.difference.is_none() {
                report.difference = description_difference(reader, &mission)?;
            }
            if report.difference.is_none() {
                report.difference = report_difference(reader, &mission)?;
            }
            return Ok(report);
        }
        None => replay_with(reader, &program::load_recorded, &mut NoDeliberator),
    };
    report.map_err(read)
}

/// Returns the first fact or target of the record that does not follow from the mission's files.
fn description_difference(reader: &RecordReader, mission: &Mission) -> MissionResult<Option<Difference>> {
    let differ = |row: String, column: &'static str, recorded: Option<String>, replayed: Option<String>| {
        let what = Differing::Row(row, column);
        Ok(Some(Difference { at: Time::ZERO, batch: 0, what, recorded, replayed }))
    };
    let made = facts(mission);
    for key in MISSION_FACTS {
        let made = made.iter().find(|(known, _)| *known == key).map(|(_, value)| value.clone());
        let stored = reader.meta(key).map_err(read)?;
        if stored != made {
            return differ(format!("fact `{key}`"), "value", stored, made);
        }
    }
    let (stored, made) = (reader.target_rows().map_err(read)?, target_rows(mission));
    let longest = stored.len().max(made.len());
    let Some(index) = (0..longest).find(|index| stored.get(*index) != made.get(*index)) else { return Ok(None) };
    let shown = |rows: &[TargetRow]| rows.get(index).map(|row| format!("{row:?}"));
    differ(format!("target {}", index + 1), "", shown(&stored), shown(&made))
}

/// Returns the first section of the stored report that does not follow from the steps; `None` before the flight has ended.
fn report_difference(reader: &RecordReader, mission: &Mission) -> MissionResult<Option<Difference>> {
    let stored = reader.report_sections().map_err(read)?;
    if stored.is_empty() && !reader.is_complete().map_err(read)? {
        return Ok(None);
    }
    let made = report_of(reader, mission)?.sections();
    let made: Vec<(String, String)> = made.iter().map(|(name, body)| ((*name).to_string(), body.to_string())).collect();
    let longest = stored.len().max(made.len());
    let Some(index) = (0..longest).find(|index| stored.get(*index) != made.get(*index)) else { return Ok(None) };
    let at = reader.span().map_err(read)?.map_or(Time::ZERO, |(_, end)| end);
    let shown = |sections: &[(String, String)]| sections.get(index).map(|(name, body)| format!("{name}: {body}"));
    let what = Differing::Row(format!("report {}", index + 1), "body");
    Ok(Some(Difference { at, batch: 0, what, recorded: shown(&stored), replayed: shown(&made) }))
}

/// Returns the situation after the last step not later than `at`.
///
/// # Errors
/// A record that cannot be read.
pub fn situation_at(reader: &RecordReader, mission: &Mission, at: Time) -> MissionResult<Situation> {
    let (last, mut situation) = stored_situation(reader, at)?;
    for step in reader.steps_of_all(at).map_err(read)?.with_effects_after(last) {
        let step = step.map_err(read)?;
        continue_situation(reader, mission, (last, &mut situation), &step)?;
    }
    Ok(situation)
}

/// Returns the last stored situation not later than `at` and the number of its batch; an empty one before the first batch if there is
/// none.
fn stored_situation(reader: &RecordReader, at: Time) -> MissionResult<(i64, Situation)> {
    // A snapshot of another build may decode into something else; the steps are always valid.
    let ours = reader.has_layout(SITUATION_LAYOUT, env!("APEX_SITUATION_LAYOUT")).map_err(read)?;
    let stored = if ours { reader.situation_before(at).map_err(read)? } else { None };
    let stored = stored.and_then(|row| Some((row.batch_number, postcard::from_bytes(&row.body).ok()?)));
    Ok(stored.unwrap_or_default())
}

/// Observes a step in the situation, unless the stored situation contains it: that of batch `last` and of those before.
fn continue_situation(
    reader: &RecordReader,
    mission: &Mission,
    (last, situation): (i64, &mut Situation),
    step: &RecordedStep,
) -> MissionResult<()> {
    if step.batch_number > last {
        let effects = step.decoded_effects().map_err(|fault| damaged(reader, fault))?;
        situation.observe(mission, step.agent, &step.batch, &effects);
    }
    Ok(())
}

/// A situation with the observations until then; an error if the targets are invalid.
type Folded = (Situation, Result<Option<FlownScore>, String>);

/// Returns the situation after the last step not later than `until`, and the observations until then. The situation continues the last
/// stored one, which replay compares with the steps; the observations are computed from the steps alone.
pub(crate) fn folded_until(reader: &RecordReader, mission: &Mission, until: Time) -> MissionResult<Folded> {
    let (last, mut situation) = stored_situation(reader, until)?;
    // Made at the first batch, so that the second thread divides the targets into grid cells.
    let mut flown: Option<Result<Option<FlownScore>, String>> = None;
    let see = |flown: &mut Option<_>, batch: &Batch| {
        if let Ok(Some(flown)) = flown.get_or_insert_with(|| FlownScore::new(mission)) {
            FlownScore::observe(flown, batch);
        }
    };
    let fold = |step: &RecordedStep| continue_situation(reader, mission, (last, &mut situation), step);
    let steps = reader.steps_of_all(until).map_err(read)?.with_effects_after(last);
    fold_both(steps, (&mut flown, see), fold, read)?;
    Ok((situation, flown.unwrap_or_else(|| FlownScore::new(mission))))
}

fn damaged(reader: &RecordReader, fault: impl std::fmt::Display) -> MissionError {
    MissionError::record_file(format!("the flight record {} is damaged", reader.path().display())).because(fault)
}

/// Returns the report as if the recorded flight had ended at `at`, computed from its steps until then.
///
/// # Errors
/// A record that cannot be read.
pub fn report_until(reader: &RecordReader, mission: &Mission, at: Time) -> MissionResult<Report> {
    let (situation, flown) = folded_until(reader, mission, at)?;
    let report = report(mission, &situation, told(&flown), (at, "the flight was under way".to_string()));
    Ok(Report { failed_because: None, not_landed: None, landed_away: None, ..report })
}

/// The report of the recorded flight, computed from its steps.
///
/// # Errors
/// A record that cannot be read.
pub fn report_of(reader: &RecordReader, mission: &Mission) -> MissionResult<Report> {
    let (situation, flown) = folded_until(reader, mission, Time::END)?;
    let end = match (
        reader.meta("end_ns").map_err(read)?.and_then(|text| text.parse().ok()),
        reader.meta("end_reason").map_err(read)?,
    ) {
        (Some(end), Some(reason)) => (Time(end), reason),
        _ => {
            let end = reader.span().map_err(read)?.map_or(Time::ZERO, |(_, end)| end);
            (end, "the record ends here, without the end of the flight".to_string())
        }
    };
    Ok(report(mission, &situation, told(&flown), end))
}
