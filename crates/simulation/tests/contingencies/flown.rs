//! Missions with a world file, and readings from their records.

#![allow(dead_code, reason = "two tests use it, each a part")]

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded;
use apex_model::effect::Effect;
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::record::RecordReader;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;

/// Two airfields 60 km apart, one of them home.
const BASES: &str = r#"{"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"id": "home", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [-117.0, 37.0]}},
{"type": "Feature", "properties": {"id": "field", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [-117.0, 37.54]}}]}"#;

const WIND: &str = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,20000,250,5,0.02\n";

/// Clouds that a mission may expect: north of 37.2 degrees from 3,000 to 5,000 m.
const CLOUDS: &str = "south_deg,north_deg,west_deg,east_deg,base_m,top_m,cover\n37.2,39,-118,-116,3000,5000,0.9\n";

/// Parts of a mission.
pub(crate) struct Flight {
    pub(crate) vehicle: &'static str,
    /// Guards, as steps of the program.
    pub(crate) guards: &'static str,
    /// The work, as steps of a sequence.
    pub(crate) work: &'static str,
    /// Members of the world file.
    pub(crate) world: &'static str,
    /// Further options of the application.
    pub(crate) options: &'static str,
    /// Lines of the scenario.
    pub(crate) scenario: &'static str,
    /// Civil time of the start.
    pub(crate) start: &'static str,
    /// Airspace, for missions that name `zone.geojson`.
    pub(crate) zone: &'static str,
}

impl Default for Flight {
    fn default() -> Flight {
        Flight {
            vehicle: "predator-b",
            guards: "",
            work: "",
            world: "",
            options: "",
            scenario: "",
            start: "2026-06-01T18:00:00Z",
            zone: "",
        }
    }
}

/// A recorded flight.
pub(crate) struct Flown {
    _folder: tempfile::TempDir,
    record: PathBuf,
    pub(crate) end: String,
    /// Instants, and messages of the world and of tasks as text.
    pub(crate) said: Vec<(f64, String)>,
    /// Commands with their instants, as text.
    pub(crate) commands: Vec<(f64, String)>,
    /// Measurements: instant, variable, value.
    measured: Vec<(f64, String, Value)>,
}

impl Flight {
    pub(crate) fn load(&self, folder: &std::path::Path) -> Result<Mission, apex_mission::error::MissionError> {
        let text = format!(
            "(defapplication \"Contingencies\" :type native-sim :libraries (\"vehicle\" \"contingencies\" \"replanning\")\n\
             :vehicle (sim :model {} :at home) :duration 6h :start \"{}\" :targets \"bases.geojson\"\n\
             :forecast \"winds.csv\" :scenario \"scenario.jsonl\" :world \"world.json\" {}\n\
             :agents ((agent uav-1 :initial-task (fly the mission))))\n\
             (procedure (index (fly the mission)) (step work (work)) {}\n  (step finish (terminate) (waitfor (end ?work))))\n\
             (procedure :sequential (index (work)) {})\n",
            self.vehicle, self.start, self.options, self.guards, self.work
        );
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        write("mission.pdl", &text);
        write("bases.geojson", BASES);
        write("winds.csv", WIND);
        write("clouds.csv", CLOUDS);
        write("zone.geojson", self.zone);
        write("scenario.jsonl", self.scenario);
        write(
            "world.json",
            &format!("{{\"format\": \"apex-world-1\"{}{}}}", if self.world.is_empty() { "" } else { ", " }, self.world),
        );
        Mission::load(folder)
    }

    pub(crate) fn fly(&self) -> Flown {
        let folder = tempfile::tempdir().unwrap();
        let mission = self.load(folder.path()).unwrap_or_else(|error| panic!("{error:?}"));
        fly(mission, folder)
    }
}

/// Flies the mission in a folder; the record is in `folder`.
pub(crate) fn fly_mission(shipped: &std::path::Path, folder: tempfile::TempDir) -> Flown {
    fly(Mission::load(shipped).unwrap_or_else(|error| panic!("{error:?}")), folder)
}

fn fly(mission: Mission, folder: tempfile::TempDir) -> Flown {
    let mission = Arc::new(mission);
    let record = folder.path().join("flight.apex");
    let mut recorder = apex_simulation::create_record(&record, &mission, None).unwrap();
    let terms = MissionFlight::terms(&mission, None);
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let outcome = apex_simulation::fly(Arc::clone(&mission), means, None, terms, &mut recorder, &mut [])
        .unwrap_or_else(|error| panic!("{error:?}"));
    drop(recorder);
    let (mut said, mut commands, mut measured) = (Vec::new(), Vec::new(), Vec::new());
    for step in RecordReader::open(&record).unwrap().steps_of_all(Time::END).unwrap() {
        let step = step.unwrap();
        for event in &step.batch.events {
            match &event.kind {
                EventKind::Occurrence(form) => said.push((event.at.seconds(), form.to_string())),
                EventKind::Measurement(variable, value) => {
                    measured.push((event.at.seconds(), variable.to_string(), value.clone()));
                }
                _ => {}
            }
        }
        for effect in &step.decoded_effects().unwrap() {
            let now_s = step.batch.now.seconds();
            match effect {
                Effect::Inform { form, .. } => said.push((now_s, form.to_string())),
                Effect::Command { form, .. } => commands.push((now_s, form.to_string())),
                _ => {}
            }
        }
    }
    Flown { _folder: folder, record, end: outcome.end.reason.text(), said, commands, measured }
}

impl Flown {
    /// Returns the instant of the first message with this beginning.
    pub(crate) fn first_s(&self, text: &str) -> f64 {
        let found = self.said.iter().find(|(_, said)| said.starts_with(text));
        found.map(|(at_s, _)| *at_s).unwrap_or_else(|| panic!("no {text}\n{}", self.story()))
    }

    pub(crate) fn count(&self, text: &str) -> usize {
        self.said.iter().filter(|(_, said)| said.starts_with(text)).count()
    }

    /// Returns the numbers of a variable with their instants.
    pub(crate) fn numbers(&self, variable: &str) -> Vec<(f64, f64)> {
        let of = self.measured.iter().filter(|(_, name, _)| name == variable);
        of.filter_map(|(at_s, _, value)| Some((*at_s, value.as_number()?.0))).collect()
    }

    /// Returns the last number of a variable at an instant.
    pub(crate) fn number_at(&self, variable: &str, at_s: f64) -> f64 {
        let numbers = self.numbers(variable);
        let found = numbers.iter().rev().find(|(known_s, _)| *known_s <= at_s);
        found.unwrap_or_else(|| panic!("no {variable} until {at_s} s")).1
    }

    /// Returns the words of a variable with their instants.
    pub(crate) fn words(&self, variable: &str) -> Vec<(f64, String)> {
        let of = self.measured.iter().filter(|(_, name, _)| name == variable);
        of.map(|(at_s, _, value)| (*at_s, value.to_string())).collect()
    }

    /// Returns the last word of a variable at an instant.
    pub(crate) fn word_at(&self, variable: &str, at_s: f64) -> String {
        let words = self.words(variable);
        let found = words.iter().rev().find(|(known_s, _)| *known_s <= at_s);
        found.unwrap_or_else(|| panic!("no {variable} until {at_s} s")).1.clone()
    }

    /// Returns the places of a variable with their instants: degrees north and east, metres.
    pub(crate) fn places(&self, variable: &str) -> Vec<(f64, [f64; 3])> {
        let of = self.measured.iter().filter(|(_, name, _)| name == variable);
        let number = |items: &[Value], index: usize| items[index].as_number().unwrap().0;
        let place = |items: &[Value]| [number(items, 0), number(items, 1), number(items, 2)];
        of.filter_map(|(at_s, _, value)| Some((*at_s, place(value.as_list()?)))).collect()
    }

    /// Returns the last place that the aircraft reported: degrees north and east, metres.
    pub(crate) fn last_place(&self) -> (f64, f64, f64) {
        let of = self.measured.iter().rev().find(|(_, name, _)| name == "(location uav-1)").unwrap();
        let items = of.2.as_list().unwrap();
        let number = |index: usize| items[index].as_number().unwrap().0;
        (number(0), number(1), number(2))
    }

    /// Returns the distance from the vehicle's last place to a given one, m.
    pub(crate) fn last_distance_m(&self, latitude_deg: f64, longitude_deg: f64) -> f64 {
        const DEGREE_M: f64 = 111_195.0;
        let (latitude, longitude, _) = self.last_place();
        let east = (longitude - longitude_deg) * DEGREE_M * latitude_deg.to_radians().cos();
        ((latitude - latitude_deg) * DEGREE_M).hypot(east)
    }

    pub(crate) fn story(&self) -> String {
        let mut text = format!("{}\n", self.end);
        for (at_s, said) in &self.said {
            writeln!(text, "{at_s:9.1} {said}").unwrap();
        }
        text
    }

    /// Returns the result of the independent check of the recorded flight.
    pub(crate) fn verified(&self) -> apex_mission::verification::CheckResult {
        let reader = RecordReader::open(&self.record).unwrap();
        let mission = recorded::mission_of(&reader).unwrap().unwrap();
        apex_mission::verification::verify(&reader, &mission).unwrap()
    }

    /// Replay repeats the decisions from the record alone.
    pub(crate) fn assert_replays(&self) {
        let report = recorded::replay(&RecordReader::open(&self.record).unwrap()).unwrap();
        assert_eq!(report.difference, None, "{report}");
    }
}
