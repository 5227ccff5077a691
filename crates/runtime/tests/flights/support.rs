//! A program, its inputs, and a way to fly it into a record.

use apex_executive::state::agent::Agent;
use apex_model::event::{EventKind, StateVariable};
use apex_model::host::HostFunctions;
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::mission_loop::{RunEnd, RunSettings};
use apex_runtime::ports::{Deliberator, Input, Observer};
use apex_runtime::program::{NoDeliberator, run_with};
use apex_runtime::record::{RecordOptions, RecordReader, Recorder, RestoredProgram};
use std::path::PathBuf;
use std::sync::Arc;
use tempfile::TempDir;

/// Two cameras' worth of work: waits, resources, events, a measurement, an interruption.
pub(crate) const CAMERA: &str = r#"
(procedure
  (index (do-domain))
  (step patrol (patrol) (priority 3))
  (step look (look-at fire) (waitfor (fire-seen)) (priority 7))
  (step high (print "high") (waitfor (altitude ac-1 > 7000)))
  (step done (end-application "seen") (waitfor ?look ?high)))
(primitive (index (patrol)) (profile flight-path) (duration 100s))
(primitive (index (look-at ?what)) (profile flight-path) (duration 5s) (on-start (inform (looking ?what))))
"#;

pub(crate) fn load(sources: &[SourceFile]) -> Result<RestoredProgram, String> {
    let texts = sources
        .iter()
        .map(|source| apex_pdl::SourceText { name: source.name.to_string(), text: source.text.to_string() })
        .collect();
    let mut resolve = |_| Err("there is nothing to require".into());
    let options = apex_pdl::CheckOptions { fragment: false, host: &[], resolve: &mut resolve };
    let checked = apex_pdl::check(texts, options);
    if checked.has_errors() {
        return Err(apex_pdl::render(&checked.diagnostics, &checked.library.sources, false));
    }
    let declaration = checked.library.crew().swap_remove(0);
    Ok((Arc::new(checked.library), declaration, HostFunctions::default()))
}

pub(crate) fn program(pdl: &str) -> RestoredProgram {
    load(&[SourceFile { name: Arc::from("camera.pdl"), text: Arc::from(pdl) }]).unwrap()
}

pub(crate) fn event(seconds: f64, form: &str) -> Input {
    let form = apex_pdl::read_value(form).unwrap();
    Input::new(Time::from_seconds(seconds), EventKind::Occurrence(form))
}

pub(crate) fn altitude(seconds: f64, value: i64) -> Input {
    let variable = StateVariable::new(Symbol::new("altitude"), Value::symbol("ac-1"));
    Input::new(Time::from_seconds(seconds), EventKind::Measurement(variable, Value::Integer(value)))
}

pub(crate) fn camera_inputs() -> Vec<Input> {
    vec![altitude(1.0, 6500), event(3.5, "(fire-seen)"), altitude(20.0, 7200)]
}

pub(crate) struct Recorded {
    _folder: TempDir,
    pub(crate) path: PathBuf,
    pub(crate) agent: Agent,
    pub(crate) end: RunEnd,
}

impl Recorded {
    pub(crate) fn reader(&self) -> RecordReader {
        RecordReader::open(&self.path).unwrap()
    }
}

pub(crate) fn record(
    pdl: &str,
    inputs: Vec<Input>,
    deliberator: &mut dyn Deliberator,
    more: &mut [&mut dyn Observer],
) -> Recorded {
    record_with(pdl, deliberator, more, RunSettings { inputs, ..RunSettings::default() })
}

pub(crate) fn record_with(
    pdl: &str,
    deliberator: &mut dyn Deliberator,
    more: &mut [&mut dyn Observer],
    options: RunSettings,
) -> Recorded {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flight.apex");
    let (library, declaration, host) = program(pdl);
    let mut recorder = Recorder::create(&path, &library, RecordOptions::default()).unwrap();
    recorder.program(&library).unwrap();
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    let mut observers: Vec<&mut dyn Observer> = vec![&mut recorder];
    for observer in more {
        observers.push(&mut **observer);
    }
    let end = run_with(&mut agent, deliberator, &mut observers, options).unwrap();
    recorder.finish(end.at, &end.reason.text()).unwrap();
    Recorded { _folder: folder, path, agent, end }
}

pub(crate) fn camera() -> Recorded {
    record(CAMERA, camera_inputs(), &mut NoDeliberator, &mut [])
}

impl Recorded {
    /// Returns the reader with the folder that keeps its file alive.
    pub(crate) fn reader_kept(self) -> (RecordReader, Recorded) {
        (self.reader(), self)
    }
}
