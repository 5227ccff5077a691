//! The simulated world: time, the vehicle in it, and its reports.
//!
//! Time advances in steps chosen by the simulator and cut only at the instants of commands and scheduled events; all instants are whole
//! milliseconds. So the same commands at the same times give the same inputs, regardless of how often `advance` is called in between. The
//! end of the next step is always known, so that no input is delivered after its instant.

use crate::atmosphere::{Air, ICE_K};
use crate::camera::Camera;
use crate::config::{Happening, NamedPlace, ScheduledEvent, WorldConfig};
use crate::fixed_wing;
use crate::flight::{ActiveOrder, Order, Progress};
use crate::instants;
use crate::left_lines::LeftLines;
use crate::living::FaultKind;
use crate::living::life::{self, Living};
use crate::living::navigation::NavigationError;
use crate::motion::{Demand, State, drain_per_s};
use crate::packet::{Extent, Reporter};
use crate::phase::Phase;
use crate::radio::Radio;
use crate::rotorcraft;
use crate::situation::Situation;
use crate::terrain::Terrain;
use crate::turbulence::Turbulence;
use apex_geo::geodesy::{self, RAD_PER_DEG};
use apex_geo::wind::{self, Wind};
use apex_model::effect::CommandId;
use apex_model::event::EventKind;
use apex_model::problem::{Position, WindField};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::ports::Input;
use apex_vehicle::{Airframe, VehicleModel};
use libm::{cos, sin};
use std::collections::VecDeque;

/// Length of a step while something changes; other steps are at least as long.
pub(crate) const STEP_S: f64 = 0.5;

/// A message received from the executive that waits for its time.
#[derive(Clone, Debug)]
pub(crate) enum Received {
    Command(CommandId, Value),
    Withdrawal(CommandId),
}

/// A command with a setpoint: altitude, speed or heading.
#[derive(Clone, Debug)]
pub(crate) struct Setpoint {
    pub(crate) command: CommandId,
    pub(crate) text: String,
    pub(crate) answer: Value,
}

/// The simulated world with its one vehicle. Commands and variables: `docs/reference/simulator.md`.
#[derive(Clone, Debug)]
pub struct SimulatedWorld {
    pub(crate) vehicle: String,
    pub(crate) model: VehicleModel,
    pub(crate) wind_field: WindField,
    pub(crate) ground: Terrain,
    pub(crate) places: Vec<NamedPlace>,
    pub(crate) now: Time,
    pub(crate) planned_stop: Time,
    /// Instant of the next packet of more than attitude.
    pub(crate) packet_due: Time,
    /// Instant of the next sample of attitude, if a sensor is in use.
    pub(crate) attitude_due: Time,
    pub(crate) state: State,
    pub(crate) wind: Wind,
    pub(crate) ground_m: f64,
    pub(crate) flight: ActiveOrder,
    pub(crate) altitude_m: f64,
    pub(crate) true_airspeed: f64,
    pub(crate) nose_rad: Option<f64>,
    pub(crate) altitude_command: Option<Setpoint>,
    pub(crate) speed_command: Option<Setpoint>,
    pub(crate) heading_command: Option<Setpoint>,
    pub(crate) left_lines: LeftLines,
    pub(crate) waits: Vec<(Time, CommandId, Value)>,
    pending: VecDeque<(Time, Received)>,
    scheduled: VecDeque<ScheduledEvent>,
    pub(crate) scanner_on: bool,
    pub(crate) cameras: Vec<Camera>,
    pub(crate) radios: Vec<Radio>,
    pub(crate) heard_at: Time,
    pub(crate) turbulence: Turbulence,
    /// `None` only while the reporter writes, because it reads the rest of the world meanwhile.
    pub(crate) reporter: Option<Reporter>,
    /// True if nothing changes, so that the next step may be long.
    pub(crate) settled: bool,
    /// True if something happened in flight that must be sent in a packet at once.
    pub(crate) changed: bool,
    pub(crate) crashed: bool,
    pub(crate) home: Position,
    /// Failures, weather that moves, fires; `None` without a world file.
    pub(crate) living: Option<Box<Living>>,
    /// Error of the position in the state.
    pub(crate) navigation: NavigationError,
}

impl SimulatedWorld {
    /// Sets up the world of `config` at mission time zero.
    ///
    /// # Errors
    /// A message that names the impossible part of the configuration.
    pub fn new(config: WorldConfig) -> Result<SimulatedWorld, String> {
        config.check()?;
        let living = Living::of(&config).map(Box::new);
        let WorldConfig { vehicle, model, start, seed, wind, ground, modems, places, mut events, .. } = config;
        for event in &mut events {
            event.at = instants::not_before(event.at.max(Time::ZERO));
        }
        events.sort_by_key(|event| event.at);
        let cameras: Vec<Camera> = model.cameras.iter().cloned().map(Camera::new).collect();
        let numbered = modems.into_iter().zip(0u64..);
        let radios: Vec<Radio> = numbered.map(|(modem, index)| Radio::new(modem, seed, index)).collect();
        let home = radios.iter().find_map(|radio| radio.modem.level.station).unwrap_or(start.position);
        let wind_now = wind::at(&wind, start.position, start.altitude_m, 0.0);
        let state = initial_state(&start, &model, wind_now);
        let mut ground = Terrain::new(ground);
        let ground_m = ground.elevation_m_below(start.position);
        let (altitude_m, true_airspeed) = (start.altitude_m, model.true_airspeed_m_s_cruise);
        let here = Situation {
            model: &model,
            state: &state,
            wind: wind_now,
            ground_m,
            now: Time::ZERO,
            altitude_m,
            true_airspeed,
        };
        let order = if start.airborne { Order::Hold } else { Order::Parked };
        let flight = ActiveOrder::begin(None, order, &here);
        let reporter = Reporter::new(&vehicle, &model, &cameras, &radios);
        let turbulence = Turbulence::new(model.attitude_hold.clone(), seed);
        Ok(SimulatedWorld {
            vehicle,
            model,
            wind_field: wind,
            ground,
            places,
            now: Time::ZERO,
            planned_stop: Time::ZERO,
            packet_due: Time::ZERO,
            attitude_due: Time::ZERO,
            state,
            wind: wind_now,
            ground_m,
            flight,
            altitude_m,
            true_airspeed,
            nose_rad: None,
            altitude_command: None,
            speed_command: None,
            heading_command: None,
            left_lines: LeftLines::default(),
            waits: Vec::new(),
            pending: VecDeque::new(),
            scheduled: events.into(),
            scanner_on: false,
            cameras,
            radios,
            heard_at: Time::ZERO,
            turbulence,
            reporter: Some(reporter),
            settled: false,
            changed: true,
            crashed: false,
            home,
            living,
            navigation: NavigationError::default(),
        })
    }

    /// Returns the vehicle's name.
    pub fn vehicle(&self) -> &str {
        &self.vehicle
    }

    /// Returns the true altitude of the vehicle above mean sea level.
    pub fn altitude_m(&self) -> f64 {
        self.state.altitude_m
    }

    /// Returns the energy on board: kg of fuel or J of the battery.
    pub fn stored(&self) -> f64 {
        self.state.stored
    }

    /// Returns the part of the world that a flight order reads.
    pub(crate) fn situation(&self) -> Situation<'_> {
        Situation {
            model: &self.model,
            state: &self.state,
            wind: self.wind,
            ground_m: self.ground_m,
            now: self.now,
            altitude_m: self.altitude_m,
            true_airspeed: self.true_airspeed,
        }
    }

    /// Returns true for a wrecked vehicle.
    pub(crate) fn is_crashed(&self) -> bool {
        self.crashed
    }

    /// Returns the instant of the next event that depends on the clock and not on the motion.
    fn next_due(&self) -> Option<Time> {
        let pending = self.pending.front().map(|(at, _)| *at);
        let scheduled = self.scheduled.front().map(|event| event.at);
        let waits = self.waits.iter().map(|(at, ..)| *at);
        let cameras = self.cameras.iter().filter_map(|camera| camera.timer);
        let slews = self.cameras.iter().filter_map(|camera| camera.slew_until);
        let deadline = self.flight.deadline();
        let living = life::next_due(self.living.as_deref(), self.now);
        pending
            .into_iter()
            .chain(scheduled)
            .chain(waits)
            .chain(cameras)
            .chain(slews)
            .chain(deadline)
            .chain(living)
            .min()
    }

    fn next_stop(&self) -> Time {
        let due = self.next_due().unwrap_or(Time::END);
        due.min(self.planned_stop).max(self.now)
    }

    /// Returns the end of the next step. Nothing is reported before it, and the reports of the step have that instant.
    pub(crate) fn next_instant(&self) -> Time {
        self.next_stop().min(self.now + instants::span(self.step_s()))
    }

    /// Flies one step, up to `next`, and adds the reports due then.
    pub(crate) fn live_until(&mut self, next: Time, inputs: &mut Vec<Input>) {
        let dt = next - self.now;
        if dt > Duration::ZERO {
            self.now = next;
            self.fly(dt.seconds(), inputs);
        }
        if self.changed || self.next_stop() <= self.now {
            self.attend(inputs);
        }
    }

    /// Returns a long step only if nothing changes, and never past the end of the flight's stage by more than the shortest step.
    fn step_s(&self) -> f64 {
        let longest_s = if self.settled { self.model.report.cruise_s } else { STEP_S };
        let left_s = self.flight.stage_m / self.state.ground_speed().max(1.0);
        let left_s = left_s.min(self.flight.line_speed_due_s(&self.situation()));
        left_s.min(longest_s).max(self.flight.step_s_min())
    }

    /// Advances the world by one step of `dt` seconds, which ends now.
    fn fly(&mut self, dt: f64, inputs: &mut Vec<Input>) {
        self.wind = self.wind_that_blows();
        self.navigate(dt);
        let ground_roll = self.flight.ground_roll().filter(|_| self.state.on_ground);
        if let Some(speed) = ground_roll {
            let speed = if speed.is_finite() { speed } else { self.model.true_airspeed_m_s_max };
            fixed_wing::roll(&mut self.state, &self.model, speed, dt);
            (self.state.roll_rad, self.state.roll_rate_rad_s) = (0.0, 0.0);
            self.turbulence.rest();
            self.settled = speed == 0.0 && self.state.true_airspeed == 0.0;
        } else if !self.crashed {
            self.fly_in_air(dt, inputs);
        }
        let position = self.position();
        self.ground_m = self.ground.elevation_m_below(position);
        self.burn(dt, inputs);
        self.meet_ground(inputs);
        self.move_cameras(dt, inputs);
        self.live_on(dt, inputs);
        let limit = self.model.level_roll_deg_max * RAD_PER_DEG;
        // Like `situation`, but borrows single fields, so that the flight may change meanwhile.
        let here = Situation {
            model: &self.model,
            state: &self.state,
            wind: self.wind,
            ground_m: self.ground_m,
            now: self.now,
            altitude_m: self.altitude_m,
            true_airspeed: self.true_airspeed,
        };
        match self.flight.progress(&here, limit, dt) {
            Progress::Going => {}
            Progress::StageChanged => self.changed = true,
            Progress::Done(value) => self.flight_done(value, inputs),
            Progress::Failed(reason) => self.flight_failed(&reason, inputs),
        }
        self.meet_setpoints(inputs);
    }

    fn fly_in_air(&mut self, dt: f64, inputs: &mut Vec<Input>) {
        if self.state.on_ground {
            self.state.on_ground = false;
            self.happen("airborne", inputs);
        }
        let (altitude_m, true_airspeed) = self.flight.profile(&self.situation());
        let looking = self.cameras.iter().find_map(|camera| camera.nose_rad(&self.state));
        let nose_rad = self.flight.nose_rad(self.state.position).or(looking).or(self.nose_rad);
        let demand = Demand { path: self.flight.path(&self.situation()), altitude_m, true_airspeed, nose_rad };
        let bank = self.state.bank_rad;
        self.settled = match self.model.airframe {
            Airframe::FixedWing => fixed_wing::fly(&mut self.state, &demand, &self.model, self.wind, dt),
            Airframe::Rotorcraft => rotorcraft::fly(&mut self.state, &demand, &self.model, self.wind, dt),
        };
        self.turbulence.fly((self.wind.edr, self.state.altitude_m - self.ground_m), self.state.true_airspeed, dt);
        self.state.roll_rad = self.state.bank_rad + self.turbulence.roll_rad;
        self.state.roll_rate_rad_s = (self.state.bank_rad - bank) / dt + self.turbulence.roll_rate_rad_s;
        self.state.flight_time_s += dt;
    }

    fn burn(&mut self, dt: f64, inputs: &mut Vec<Input>) {
        let (drain_per_s, leak_per_s) = self.drain_suffered(drain_per_s(&self.state, &self.model));
        self.state.drain_per_s = drain_per_s;
        self.state.stored = (self.state.stored - (drain_per_s + leak_per_s) * dt).max(0.0);
        if self.state.engine_running && self.available() == 0.0 {
            self.state.engine_running = false;
            self.happen("fuel-exhausted", inputs);
        }
    }

    /// Returns the energy that is usable at the outside temperature, kg or J.
    pub(crate) fn available(&self) -> f64 {
        let air = Air::at(self.state.altitude_m);
        self.model.available(self.state.stored, air.temperature_k - ICE_K)
    }

    /// Sends the event `(NAME VEHICLE)`.
    pub(crate) fn happen(&mut self, name: &str, inputs: &mut Vec<Input>) {
        let form = Value::list([Value::symbol(name), Value::symbol(&self.vehicle)]);
        inputs.push(Input::new(self.now, EventKind::Occurrence(form)));
        self.changed = true;
    }

    fn meet_ground(&mut self, inputs: &mut Vec<Input>) {
        if self.state.on_ground || self.state.altitude_m > self.ground_m {
            return;
        }
        // A climb from an airfield passes the airfield's level; only a descent ends there.
        if self.state.vertical_speed >= 0.0 && self.flight.phase() == Phase::Climbing {
            return;
        }
        self.state.altitude_m = self.ground_m;
        self.state.on_ground = true;
        (self.state.vertical_speed, self.state.bank_rad, self.state.roll_rad) = (0.0, 0.0, 0.0);
        if self.model.airframe == Airframe::Rotorcraft {
            (self.state.north, self.state.east, self.state.true_airspeed) = (0.0, 0.0, 0.0);
        }
        if self.flight.is_touching_down() || self.is_autorotating_down() {
            return self.happen("landed", inputs);
        }
        self.crashed = true;
        self.state.engine_running = false;
        (self.state.north, self.state.east, self.state.true_airspeed) = (0.0, 0.0, 0.0);
        self.settled = true;
        self.scanner_on = false;
        self.happen("crashed", inputs);
        self.fail_everything(inputs);
    }

    /// Executes commands, scheduled events and timers that are due by the clock, then sends the packet.
    fn attend(&mut self, inputs: &mut Vec<Input>) {
        let due = self.now >= self.planned_stop;
        let extent = match (self.changed, due, self.now >= self.packet_due) {
            (true, ..) => Some(Extent::Full),
            (false, true, true) => Some(Extent::Fast),
            (false, true, false) => Some(Extent::Attitude),
            (false, false, _) => None,
        };
        while let Some(event) = self.scheduled.pop_front_if(|event| event.at <= self.now) {
            let kind = match event.what {
                Happening::Occurrence(form) => EventKind::Occurrence(form),
                Happening::Measurement(variable, value) => EventKind::Measurement(variable, value),
            };
            inputs.push(Input::new(event.at, kind));
        }
        self.suffer(inputs);
        self.ring_timers(inputs);
        let extent = if self.changed { Some(Extent::Full) } else { extent };
        if let Some(extent) = extent {
            self.report(extent, inputs);
        }
        self.changed = false;
        let mut obeyed = extent.is_none();
        while let Some((_, received)) = self.pending.pop_front_if(|(at, _)| *at <= self.now) {
            (self.settled, obeyed) = (false, true);
            match received {
                Received::Command(command, form) => self.obey(command, &form, inputs),
                Received::Withdrawal(command) => self.give_up(command),
            }
        }
        if obeyed && let Some(mut reporter) = self.reporter.take() {
            let first = inputs.len();
            reporter.changes(self.now, &self.snapshot(), &self.cameras, inputs);
            self.reporter = Some(reporter);
            self.disturb(inputs, first);
        }
        self.changed = false;
        self.plan(extent);
    }

    /// Queues a message for its time, but not before the present and not before earlier messages.
    pub(crate) fn receive(&mut self, at: Time, received: Received) {
        let last = self.pending.back().map_or(self.now, |(at, _)| *at);
        self.pending.push_back((instants::not_before(at).max(last).max(self.now), received));
    }

    /// Acknowledges a command.
    pub(crate) fn answer(&self, command: CommandId, result: Result<Value, String>, inputs: &mut Vec<Input>) {
        if self.suffers(FaultKind::Acknowledgements, "") {
            return;
        }
        inputs.push(Input::new(self.now, EventKind::CommandAcknowledged(command, result)));
    }
}

fn initial_state(start: &crate::config::Start, model: &VehicleModel, wind: Wind) -> State {
    let heading_rad = geodesy::wrap_360(start.heading_deg) * RAD_PER_DEG;
    let flying = start.airborne && model.airframe == Airframe::FixedWing;
    let true_airspeed = if flying { model.true_airspeed_m_s_cruise } else { 0.0 };
    let blown = |speed: f64, wind_mps: f64| if flying { speed + wind_mps } else { 0.0 };
    State {
        position: start.position,
        altitude_m: start.altitude_m,
        heading_rad,
        true_airspeed,
        bank_rad: 0.0,
        roll_rad: 0.0,
        pitch_rad: 0.0,
        roll_rate_rad_s: 0.0,
        yaw_rate_rad_s: 0.0,
        vertical_speed: 0.0,
        north: blown(true_airspeed * cos(heading_rad), wind.north_mps),
        east: blown(true_airspeed * sin(heading_rad), wind.east_mps),
        stored: start.fuel_share.unwrap_or(1.0) * model.stored_full(),
        drain_per_s: 0.0,
        engine_running: start.fuel_share != Some(0.0),
        on_ground: !start.airborne,
        flight_time_s: 0.0,
        distance_flown_m: 0.0,
    }
}
