//! Missions over invented sites, and readings from their records.

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded;
use apex_model::effect::Effect;
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::record::RecordReader;
use apex_runtime::target_state::TargetChange;
use std::fmt::Write;
use std::sync::Arc;

const HOME: (f64, f64) = (37.4, -121.1);
const DEGREE_M: f64 = 111_195.0;

/// Builder of a mission.
pub(crate) struct World {
    vehicle: String,
    sites: Vec<(String, f64, f64)>,
    modem: String,
    options: String,
    scenario: String,
    duration: String,
    program: &'static str,
}

pub(crate) const PLANNED: &str = "(solver auto (index (patrol the sites)) :budget 100ms)
(procedure
  (index (fly the mission))
  (step up (take off to 110m))
  (step patrol (patrol the sites) (waitfor (end ?up)) (restart-when (new plan)))
  (step plan (keep planning (patrol the sites)))
  (step touch (keep in touch over 900MHzModem))
  (step clock (wait CLOCK))
  (step home (return to home at 110m) (waitfor (end ?clock)) (priority 10))
  (step finish (terminate) (waitfor (end ?home))))";

impl World {
    pub(crate) fn new(vehicle: &str) -> World {
        let (modem, options, scenario) = (String::new(), String::new(), String::new());
        World {
            vehicle: vehicle.to_string(),
            sites: Vec::new(),
            modem,
            options,
            scenario,
            duration: "30min".to_string(),
            program: PLANNED,
        }
    }

    /// Returns the world with one more site, at the given distances east and north of home.
    pub(crate) fn site(mut self, id: &str, east_m: f64, north_m: f64) -> World {
        self.sites.push((id.to_string(), east_m, north_m));
        self
    }

    /// Sets the options of the modem in the world.
    pub(crate) fn modem(mut self, options: &str) -> World {
        self.modem = options.to_string();
        self
    }

    /// Sets further options of the application.
    pub(crate) fn options(mut self, options: &str) -> World {
        self.options = options.to_string();
        self
    }

    /// Sets the time after which the program returns home, unless something else leads home before.
    pub(crate) fn lasting(mut self, duration: &str) -> World {
        self.duration = duration.to_string();
        self
    }

    /// Adds an event to the scenario: seconds and PDL.
    pub(crate) fn event(mut self, at_s: f64, event: &str) -> World {
        writeln!(self.scenario, "{{\"t\": {at_s}, \"event\": \"{event}\"}}").unwrap();
        self
    }

    /// Returns the model as a mission names it. The camera of the mapper is fixed downward and sees no site from a circle around it: here
    /// the aircraft has one on a gimbal.
    fn model(&self, folder: &std::path::Path) -> String {
        if self.vehicle != "fixed-wing-mapper" {
            return self.vehicle.clone();
        }
        let shipped =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../library/vehicles/fixed-wing-mapper.json");
        let text = std::fs::read_to_string(shipped).unwrap().replace("\"mapping-camera\"", "\"quadrotor-camera\"");
        std::fs::write(folder.join("mapper.json"), text).unwrap();
        "\"mapper.json\"".to_string()
    }

    pub(crate) fn load(&self, folder: &std::path::Path) -> Result<Mission, apex_mission::error::MissionError> {
        let text = format!(
            "(defapplication \"Touch\" :type native-sim :libraries (\"vehicle\" \"contingencies\" \"replanning\")\n\
             :vehicle (sim :model {} :at home) :duration {} :end-margin 1min :targets \"sites.geojson\" :scenario \"scenario.jsonl\"\n\
             :modems ((900MHzModem {})) {}\n:agents ((agent uav-1 :initial-task (fly the mission))))\n{}",
            self.model(folder),
            self.duration,
            self.modem,
            self.options,
            self.program.replace("CLOCK", if self.duration == "30min" { "25min" } else { "100min" })
        );
        std::fs::write(folder.join("mission.pdl"), text).unwrap();
        std::fs::write(folder.join("scenario.jsonl"), &self.scenario).unwrap();
        let feature = |id: &str, kind: &str, at: (f64, f64)| {
            format!(
                "{{\"type\": \"Feature\", \"properties\": {{\"id\": \"{id}\", \"kind\": \"{kind}\"}}, \"geometry\": \
                 {{\"type\": \"Point\", \"coordinates\": [{:.6}, {:.6}]}}}}",
                at.1, at.0
            )
        };
        let sites = self.sites.iter().map(|(id, east_m, north_m)| feature(id, "structure", at(*east_m, *north_m)));
        let features: Vec<String> = std::iter::once(feature("home", "base", HOME)).chain(sites).collect();
        let collection = format!("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", features.join(",\n"));
        std::fs::write(folder.join("sites.geojson"), collection).unwrap();
        Mission::load(folder)
    }

    pub(crate) fn fly(&self) -> Flown {
        let folder = tempfile::tempdir().unwrap();
        let mission = Arc::new(self.load(folder.path()).unwrap_or_else(|error| panic!("{error:?}")));
        let record = folder.path().join("flight.apex");
        let mut recorder = apex_simulation::create_record(&record, &mission, None).unwrap();
        let terms = MissionFlight::terms(&mission, None);
        let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
        let outcome = apex_simulation::fly(Arc::clone(&mission), means, None, terms, &mut recorder, &mut []).unwrap();
        drop(recorder);
        let reader = RecordReader::open(&record).unwrap();
        let (mut events, mut said, mut plans) = (Vec::new(), Vec::new(), Vec::new());
        for step in reader.steps_of_all(Time::END).unwrap() {
            let step = step.unwrap();
            events.extend(step.batch.events.iter().map(|event| (event.at.seconds(), event.kind.clone())));
            for effect in &step.decoded_effects().unwrap() {
                match effect {
                    Effect::Inform { form, .. } => said.push((step.batch.now.seconds(), form.clone())),
                    Effect::Command { form, .. } => plans.push((step.batch.now.seconds(), form.to_string())),
                    _ => {}
                }
            }
        }
        let changes = recorded::situation_at(&reader, &mission, Time::END).unwrap().target_changes;
        Flown {
            folder,
            changes,
            events,
            said,
            commands: plans,
            end: (outcome.end.at.seconds(), outcome.end.reason.text()),
        }
    }
}

/// Returns latitude and longitude of the place at the given distances east and north of home.
pub(crate) fn at(east_m: f64, north_m: f64) -> (f64, f64) {
    (HOME.0 + north_m / DEGREE_M, HOME.1 + east_m / (DEGREE_M * HOME.0.to_radians().cos()))
}

/// Returns metres between two places.
pub(crate) fn apart_m(a: (f64, f64), b: (f64, f64)) -> f64 {
    ((a.0 - b.0) * DEGREE_M).hypot((a.1 - b.1) * DEGREE_M * a.0.to_radians().cos())
}

/// A flight, read from its record.
pub(crate) struct Flown {
    folder: tempfile::TempDir,
    events: Vec<(f64, EventKind)>,
    said: Vec<(f64, Value)>,
    pub(crate) commands: Vec<(f64, String)>,
    changes: Vec<TargetChange>,
    pub(crate) end: (f64, String),
}

impl Flown {
    /// Returns the messages of the agent that begin with `head`.
    pub(crate) fn said(&self, head: &str) -> Vec<(f64, String)> {
        let of = self.said.iter().filter(|(_, form)| form.head().is_some_and(|word| word.is(head)));
        of.map(|(at_s, form)| (*at_s, form.to_string())).collect()
    }

    /// Returns all statements of the flight, and all places to which the vehicle was sent.
    pub(crate) fn story(&self) -> String {
        let said = self.said.iter().map(|(at_s, form)| (*at_s, form.to_string()));
        let failed = self.events.iter().filter_map(|(at_s, kind)| match kind {
            EventKind::CommandAcknowledged(_, Err(reason)) => Some((*at_s, format!("failed: {reason}"))),
            _ => None,
        });
        let mut all: Vec<(f64, String)> = said.chain(self.commands.iter().cloned()).chain(failed).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.push(self.end.clone());
        all.iter().map(|(at_s, text)| format!("{at_s:8.1} {text}\n")).collect()
    }

    /// Returns the time and place of each report.
    pub(crate) fn track(&self) -> Vec<(f64, (f64, f64), f64)> {
        let location = |(at_s, kind): &(f64, EventKind)| match kind {
            EventKind::Measurement(variable, Value::List(items)) if variable.attribute.is("location") => {
                let number = |index: usize| items[index].as_number().unwrap().0;
                Some((*at_s, (number(0), number(1)), number(2)))
            }
            _ => None,
        };
        self.events.iter().filter_map(location).collect()
    }

    /// Returns the time and level of each sample.
    pub(crate) fn levels(&self) -> Vec<(f64, f64)> {
        let level = |(at_s, kind): &(f64, EventKind)| match kind {
            EventKind::Measurement(variable, value) if variable.attribute.is("signal-level") => {
                Some((*at_s, value.as_number().unwrap().0))
            }
            _ => None,
        };
        self.events.iter().filter_map(level).collect()
    }

    /// Returns the last place before `until_s` with a good link: all samples from ten seconds before to five seconds after it are 0.3 or
    /// more, so that it does not lie at the edge of the coverage.
    pub(crate) fn last_good_place(&self, until_s: f64) -> (f64, f64) {
        let levels: Vec<(f64, f64)> = self.levels().into_iter().filter(|(at_s, _)| *at_s < until_s).collect();
        let is_good = |from_s: f64, to_s: f64| {
            let mut within = levels.iter().filter(|(at_s, _)| (from_s..=to_s).contains(at_s));
            within.all(|(_, level)| *level >= 0.3)
        };
        // The link counts as good if every sample from 10 s before up to the first sample at least 5 s later is good.
        let stays = |at_s: f64| {
            let later = levels.iter().find(|(later_s, _)| *later_s >= at_s + 5.0).map(|(later_s, _)| *later_s);
            later.is_some_and(|later_s| is_good(at_s - 10.0, later_s))
        };
        let good_s = levels.iter().rev().map(|(at_s, _)| *at_s).find(|at_s| stays(*at_s));
        let good_s = good_s.unwrap_or_else(|| panic!("never good before {until_s} s"));
        self.track().into_iter().rfind(|(at_s, ..)| *at_s <= good_s).unwrap().1
    }

    /// Returns the least distance from a place between two instants.
    pub(crate) fn nearest_m(&self, place: (f64, f64), (from_s, until_s): (f64, f64)) -> f64 {
        let within = |(at_s, ..): &(f64, (f64, f64), f64)| (from_s..=until_s).contains(at_s);
        self.track().into_iter().filter(within).map(|(_, here, _)| apart_m(place, here)).fold(f64::INFINITY, f64::min)
    }

    /// Returns the goal of the first flight after an instant.
    pub(crate) fn goal_after(&self, at_s: f64) -> (f64, f64) {
        let to = self.commands.iter().find(|(then_s, text)| *then_s >= at_s && text.starts_with("(fly-to ("));
        let text = &to.unwrap_or_else(|| panic!("no flight after {at_s} s\n{}", self.story())).1;
        let numbers: Vec<f64> = text
            .trim_start_matches("(fly-to (")
            .split([' ', ')'])
            .map_while(|word| word.parse().ok())
            .take(2)
            .collect();
        (numbers[0], numbers[1])
    }

    /// Returns the mean of the samples within five seconds of the last pass of a place before an instant.
    pub(crate) fn mean_level_near(&self, place: (f64, f64), before_s: f64) -> f64 {
        let track = self.track();
        let before = track.iter().filter(|(at_s, ..)| *at_s < before_s);
        let pass = before.min_by(|a, b| apart_m(place, a.1).total_cmp(&apart_m(place, b.1))).unwrap();
        let near: Vec<f64> = self
            .levels()
            .into_iter()
            .filter(|(at_s, _)| (at_s - pass.0).abs() <= 5.0)
            .map(|(_, level)| level)
            .collect();
        near.iter().sum::<f64>() / near.len() as f64
    }

    /// Returns the greatest distance from a place between two instants.
    pub(crate) fn farthest_m(&self, place: (f64, f64), (from_s, until_s): (f64, f64)) -> f64 {
        let within = |(at_s, ..): &(f64, (f64, f64), f64)| (from_s..=until_s).contains(at_s);
        self.track().into_iter().filter(within).map(|(_, here, _)| apart_m(place, here)).fold(0.0, f64::max)
    }

    /// Returns the number of times that the vehicle came within `near_m` of a place between two instants.
    pub(crate) fn passes(&self, place: (f64, f64), near_m: f64, (from_s, until_s): (f64, f64)) -> usize {
        let mut was_near = false;
        let mut passes = 0;
        for (_, here, _) in self.track().into_iter().filter(|(at_s, ..)| (from_s..=until_s).contains(at_s)) {
            let is_near = apart_m(place, here) <= near_m;
            passes += usize::from(is_near && !was_near);
            was_near = is_near;
        }
        passes
    }

    /// Returns true if the vehicle's last report has it on the ground.
    pub(crate) fn landed(&self) -> bool {
        let on_ground = |(_, kind): &(f64, EventKind)| match kind {
            EventKind::Measurement(variable, value) if variable.attribute.is("on-ground") => Some(value.is_true()),
            _ => None,
        };
        self.events.iter().filter_map(on_ground).next_back() == Some(true)
    }

    /// Returns the reason for which the last plan left a target out, from the report.
    pub(crate) fn reason_left_out(&self, target: &str) -> String {
        let changes = self.changes.iter().rev().filter(|change| change.target == target);
        changes.map(|change| change.detail.clone()).next().unwrap_or_default()
    }

    /// Replay poses the problems, derives the readings and repeats the decisions.
    pub(crate) fn assert_replays(&self) {
        let reader = RecordReader::open(&self.folder.path().join("flight.apex")).unwrap();
        let report = recorded::replay(&reader).unwrap();
        assert_eq!(report.difference, None, "{report}");
    }
}
