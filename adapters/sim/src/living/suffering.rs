//! Effects of the dynamic world on the vehicle: beginning and end of failures, fires, pictures in clouds, detectors, ice.

use super::FaultKind;
use super::disturbances::Disturbances;
use super::downlink::{Downlink, SCANNER, Stored};
use super::faults::{FaultChange, FaultSpan};
use super::ignitions::{Fire, Ignitions};
use super::life::{DETECTOR_K_MAX, Living};
use super::perimeters::Perimeters;
use super::sky::{SightLine, is_clear};
use super::wind_error::WindError;
use crate::atmosphere::Air;
use crate::camera::{Aim, Camera, CameraState, FixedDirection};
use crate::config::WorldConfig;
use crate::world::SimulatedWorld;
use apex_geo::wind::{self, Wind};
use apex_model::event::EventKind;
use apex_model::problem::Position;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use apex_vehicle::{Airframe, EnergyModel};
use libm::{atan2, cos, hypot, sin, tan};

/// Height above the ground at which the wind is sampled that drives the growth of fires.
const OPEN_WIND_M: f64 = 10.0;
/// Least angle below the horizon at which the ground in the middle of a picture is computed.
const LOWEST_SIGHT_RAD: f64 = 10.0 * apex_geo::geodesy::RAD_PER_DEG;

impl Living {
    /// Builds the dynamic world and draws its random parts from the seed; `None` without a world file.
    pub(crate) fn of(config: &WorldConfig) -> Option<Living> {
        let spec = config.living.clone()?;
        let (seed, altitude_m) = (config.seed, config.ground.elevation_m + OPEN_WIND_M);
        let open_wind = |position: Position, time_s: f64| {
            let wind = wind::at(&config.wind, position, altitude_m, time_s);
            hypot(wind.east_mps, wind.north_mps)
        };
        let ignitions =
            spec.ignitions.clone().map(|ignitions| Ignitions::new(ignitions, config.sites.clone(), seed, open_wind));
        let faults = super::faults::Faults::new(&spec.faults, seed);
        Some(Living {
            disturbances: Disturbances::new(&faults),
            faults,
            ignitions,
            perimeters: spec.perimeters.clone().map(|spec| Perimeters::new(spec, &config.burning)),
            wind_error: spec.wind_error.clone().map(|error| WindError::new(error, seed)),
            downlink: spec.downlink.clone().map(Downlink::new),
            detectors_k: vec![super::life::BAY_K; config.model.cameras.len()],
            ice_s: 0.0,
            epoch_unix_s: config.epoch_unix_s,
            seed,
            spec,
        })
    }
}

impl SimulatedWorld {
    /// Returns the wind at the vehicle's position now.
    pub(crate) fn wind_that_blows(&self) -> Wind {
        let (position, altitude_m, now_s) = (self.position(), self.state.altitude_m, self.now.seconds());
        let wind = wind::at(&self.wind_field, position, altitude_m, now_s);
        self.living.as_ref().map_or(wind, |living| living.wind(wind, position, altitude_m, now_s))
    }

    /// Returns true if fires may break out in this world.
    pub fn has_ignitions(&self) -> bool {
        self.living.as_ref().is_some_and(|living| living.ignitions.is_some())
    }

    /// Returns true for a helicopter that descends in autorotation and so touches down before its goal. Vehicles with fixed-pitch rotors
    /// fall instead.
    pub(crate) fn is_autorotating_down(&self) -> bool {
        let rotors = self.model.airframe == Airframe::Rotorcraft && self.model.glide_ratio > 0.0;
        rotors && !self.state.engine_running && self.flight.is_landing()
    }

    /// Returns true if a failure of this kind, of this object, holds now.
    pub(crate) fn suffers(&self, kind: FaultKind, of: &str) -> bool {
        self.living.as_ref().is_some_and(|living| living.faults.find(kind, of, self.now).is_some())
    }

    /// Begins and ends failures, and reports new fires. The messages `(truth-..)` state facts that only the simulator knows.
    pub(crate) fn suffer(&mut self, inputs: &mut Vec<Input>) {
        let Some(living) = &mut self.living else { return };
        let changes = living.faults.changes(self.now);
        let fires = living.ignitions.as_mut().map(|ignitions| {
            let fires = ignitions.broken_out(self.now.seconds());
            let name = |site: usize| ignitions.sites.get(site).map_or("", |site| site.name.as_str()).to_owned();
            fires.iter().map(|fire| (name(fire.site), fire.broke_out_s)).collect::<Vec<_>>()
        });
        for (name, broke_out_s) in fires.unwrap_or_default() {
            let age = crate::instants::span((self.now.seconds() - broke_out_s).max(0.0));
            self.say_truth("truth-fire", &[Value::symbol(&name), Value::Duration(age)], inputs);
        }
        self.report_perimeters(inputs);
        for change in changes {
            let word = Value::symbol(change.span.kind.word());
            let named = (!change.span.of.is_empty()).then(|| Value::symbol(&change.span.of));
            let arguments: Vec<Value> = std::iter::once(word).chain(named).collect();
            let name = if change.begins { "truth-fault" } else { "truth-fault-over" };
            self.say_truth(name, &arguments, inputs);
            self.take_effect(&change, inputs);
            (self.changed, self.settled) = (true, false);
        }
    }

    /// Reports the outlines of growing fires when reports are due. Each fire burns in the wind over its place.
    fn report_perimeters(&mut self, inputs: &mut Vec<Input>) {
        let (now, field) = (self.now, &self.wind_field);
        let ground = &mut self.ground;
        let Some(perimeters) = self.living.as_mut().and_then(|living| living.perimeters.as_mut()) else { return };
        if perimeters.next_s().is_none_or(|at_s| at_s > now.seconds()) {
            return;
        }
        let elevations = std::cell::RefCell::new(ground);
        let reports = perimeters.reports(now, |place, time_s| {
            let ground_m = elevations.borrow_mut().elevation_m_below(place);
            let wind = wind::at(field, place, ground_m + OPEN_WIND_M, time_s);
            (wind.east_mps, wind.north_mps)
        });
        inputs.extend(reports.into_iter().map(|form| Input::new(now, EventKind::Occurrence(form))));
    }

    fn say_truth(&self, name: &str, arguments: &[Value], inputs: &mut Vec<Input>) {
        let form = std::iter::once(Value::symbol(name)).chain(arguments.iter().cloned());
        inputs.push(Input::new(self.now, EventKind::Occurrence(Value::list(form))));
    }

    fn take_effect(&mut self, change: &FaultChange, inputs: &mut Vec<Input>) {
        let of = change.span.of.clone();
        match change.span.kind {
            FaultKind::Engine if change.begins => self.state.engine_running = false,
            FaultKind::Engine => self.state.engine_running = !self.crashed && self.available() > 0.0,
            FaultKind::Navigation => self.navigate(0.0),
            FaultKind::PayloadPower if change.begins => {
                self.scanner_on = false;
                self.stop_cameras(|_| true, "the payload has no power", inputs);
            }
            FaultKind::Gimbal => {
                let mine = self.cameras.iter_mut().filter(|camera| camera.model.name.eq_ignore_ascii_case(&of));
                mine.for_each(|camera| camera.stuck = change.begins);
            }
            FaultKind::Sensor if change.begins => {
                if of == "scanner" {
                    self.scanner_on = false;
                }
                let is_mine = |camera: &Camera| camera.model.name.eq_ignore_ascii_case(&of);
                self.fail_exposures(is_mine, "it delivers no images", inputs);
            }
            _ => {}
        }
    }

    /// Switches the matching cameras off and answers their commands with a failure.
    fn stop_cameras(&mut self, which: impl Fn(&Camera) -> bool, why: &str, inputs: &mut Vec<Input>) {
        let mut failed = Vec::new();
        for camera in self.cameras.iter_mut().filter(|camera| which(camera)) {
            failed.extend(camera.command.take().map(|command| (command, format!("{}: {why}", camera.model.name))));
            camera.stop(true);
        }
        for (command, reason) in failed {
            self.answer(command, Err(reason), inputs);
        }
    }

    /// Ends the exposures of matching cameras, and answers the waiting commands with a failure.
    fn fail_exposures(&mut self, which: impl Fn(&Camera) -> bool, why: &str, inputs: &mut Vec<Input>) {
        let mut failed = Vec::new();
        for camera in self.cameras.iter_mut().filter(|camera| which(camera) && camera.state == CameraState::Exposing) {
            failed.extend(camera.command.take().map(|command| (command, format!("{}: {why}", camera.model.name))));
            (camera.state, camera.timer, camera.pictures_left) = (CameraState::Pointing, None, 0);
        }
        for (command, reason) in failed {
            self.answer(command, Err(reason), inputs);
        }
    }

    /// Advances detector temperatures, ice, downlink and looks by the `dt` seconds that end now.
    pub(crate) fn live_on(&mut self, dt: f64, inputs: &mut Vec<Input>) {
        let (now, now_s) = (self.now, self.now.seconds());
        let (position, altitude_m) = (self.position(), self.state.altitude_m);
        let Some(living) = &mut self.living else { return };
        let icing =
            !self.state.on_ground && living.is_icing(position, altitude_m, Air::at(altitude_m).temperature_k, now_s);
        living.freeze(icing, dt);
        for (index, camera) in self.cameras.iter_mut().enumerate() {
            let (powered, name) = (camera.state != CameraState::Off, &camera.model.name);
            let cooled = living.faults.find(FaultKind::Cooling, name, now).is_none();
            living.warm(index, powered, cooled, dt);
            let hot = living.detectors_k.get(index).is_some_and(|detector_k| *detector_k >= DETECTOR_K_MAX);
            camera.broken = hot || living.faults.find(FaultKind::Sensor, name, now).is_some();
        }
        let level_of = |name: &str| self.radios.iter().find(|radio| radio.modem.name.eq_ignore_ascii_case(name));
        let mut line = None;
        let delivered = match &mut living.downlink {
            Some(downlink) => {
                line = downlink.scan(self.scanner_on, now_s);
                if self.state.on_ground {
                    downlink.read_out();
                }
                let level = level_of(&downlink.spec.over).map_or(0.0, |radio| radio.level);
                downlink.send(level, now_s, dt)
            }
            None => Vec::new(),
        };
        let cameras = &self.cameras;
        let seen: Vec<(String, f64, f64)> = match &mut living.ignitions {
            Some(ignitions) => {
                ignitions.end_looks(|index| cameras.get(index).is_none_or(|camera| !camera.is_looking()));
                let fires = ignitions.sighted(now_s);
                let named = |fire: &Fire| {
                    Some((ignitions.sites.get(fire.site)?.name.clone(), fire.broke_out_s, fire.area_m2(now_s)))
                };
                fires.iter().filter_map(named).collect()
            }
            None => Vec::new(),
        };
        if let Some(head) = line.and_then(Stored::message) {
            let form = [head, SCANNER, "line"].map(Value::symbol);
            inputs.push(Input::new(now, EventKind::Occurrence(Value::list(form))));
        }
        for picture in delivered {
            let form = [Value::symbol("image-on-ground"), Value::symbol(&picture.camera), picture.target];
            inputs.push(Input::new(now, EventKind::Occurrence(Value::list(form))));
        }
        let mut last = "";
        for (site, broke_out_s, area_m2) in &seen {
            let age = Value::Duration(crate::instants::span(now_s - broke_out_s));
            let area = Value::Real(crate::packet::rounded(*area_m2, 10.0));
            self.say_truth("truth-fire-seen", &[Value::symbol(site), age, area], inputs);
            // Two fires at one structure give one sighting.
            if site != last {
                self.say_truth("fire-sighted", &[Value::symbol(site)], inputs);
            }
            last = site;
        }
    }

    /// Returns true if a picture taken now shows the ground: no cloud below, a cool detector, a working sensor.
    pub(crate) fn is_picture_clear(&self, camera: &Camera) -> bool {
        let now_s = self.now.seconds();
        let (place, altitude_m) = match &camera.aim {
            Some(Aim::At(spot, altitude_m)) => {
                (self.navigation.truth(spot.position), self.state.altitude_m - altitude_m)
            }
            Some(Aim::Along(direction)) => self.seen_along(direction),
            Some(Aim::Down) | None => (self.position(), self.state.altitude_m - self.ground_m),
        };
        let off_nadir_rad = atan2(crate::path::bearing(self.position(), place).1, altitude_m.max(0.1));
        let Some(living) = &self.living else { return true };
        let sight = SightLine { place, altitude_m: self.state.altitude_m, off_nadir_rad };
        !camera.broken && is_clear(&living.spec.clouds, living.seed, sight, now_s)
    }

    /// Returns the ground in the middle of a picture in a fixed direction, with the height above it; a view above the horizon ends where one
    /// 10 degrees below it does.
    fn seen_along(&self, direction: &FixedDirection) -> (Position, f64) {
        let above_m = (self.state.altitude_m - self.ground_m).max(0.0);
        let away_m = above_m / tan((-direction.tilt_rad).max(LOWEST_SIGHT_RAD));
        (
            crate::motion::moved(
                self.position(),
                away_m * cos(direction.azimuth_rad),
                away_m * sin(direction.azimuth_rad),
            ),
            above_m,
        )
    }

    /// Begins a look for a picture that shows the ground, and puts the picture into the downlink's store.
    pub(crate) fn keep_picture(&mut self, camera: &Camera, inputs: &mut Vec<Input>) {
        let now_s = self.now.seconds();
        let index = self.cameras.iter().position(|known| known.model.name == camera.model.name).unwrap_or(0);
        let target = camera.aim.as_ref().map_or_else(Value::nil, Aim::given);
        let navigation = self.navigation.clone();
        let Some(living) = &mut self.living else { return };
        let mut said: Vec<Value> = Vec::new();
        if let (Some(ignitions), Some(Aim::At(spot, _))) = (&mut living.ignitions, &camera.aim)
            && let Some(site) = ignitions.site_at(navigation.truth(spot.position))
            && ignitions.begin_look(index, site, now_s)
            && let Some(site) = ignitions.sites.get(site)
        {
            said.push(Value::list([Value::symbol("fire-sighted"), Value::symbol(&site.name)]));
        }
        if let Some(downlink) = &mut living.downlink
            && let Some(head) = downlink.store(&camera.model.name, target.clone(), camera.data, now_s).message()
        {
            said.push(Value::list([Value::symbol(head), Value::symbol(&camera.model.name), target]));
        }
        inputs.extend(said.into_iter().map(|form| Input::new(self.now, EventKind::Occurrence(form))));
    }

    /// Returns true if clouds hide the ground below from the scanner.
    pub(crate) fn is_ground_hidden(&self) -> bool {
        self.living.as_ref().is_some_and(|living| {
            let sight = SightLine { place: self.position(), altitude_m: self.state.altitude_m, off_nadir_rad: 0.0 };
            !is_clear(&living.spec.clouds, living.seed, sight, self.now.seconds())
        })
    }

    /// Returns the rate at which the vehicle consumes energy, including the effect of ice, and the rate of losses through leaks. A flow
    /// meter measures only the first.
    pub(crate) fn drain_suffered(&self, drain_per_s: f64) -> (f64, f64) {
        let Some(living) = &self.living else { return (drain_per_s, 0.0) };
        let (factor, leak_per_s) = living.drain(matches!(self.model.energy, EnergyModel::Fuel(_)), self.now);
        (drain_per_s * factor, leak_per_s)
    }

    /// Applies failures of sensors to the readings in `inputs` from `first` on.
    pub(crate) fn disturb(&mut self, inputs: &mut Vec<Input>, first: usize) {
        let Some(living) = &mut self.living else { return };
        let spans: Vec<FaultSpan> = living.faults.active(self.now).cloned().collect();
        living.disturbances.apply(&spans, &self.vehicle, inputs, first);
    }
}
