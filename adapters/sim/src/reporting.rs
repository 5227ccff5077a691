//! Reports of the world: packets of state, radio links, cameras and timers.

use crate::atmosphere::Air;
use crate::camera::{Aim, Camera, CameraState, Pointing};
use crate::instants;
use crate::living::FaultKind;
use crate::packet::{ATTITUDE_S, Extent, Snapshot};
use crate::phase::Phase;
use crate::radio::LinkChange;
use crate::world::{STEP_S, SimulatedWorld};
use apex_geo::geodesy::RAD_PER_DEG;
use apex_model::event::EventKind;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use libm::tan;

impl SimulatedWorld {
    /// Adds a packet, after an update of the radios if the packet reports them.
    pub(crate) fn report(&mut self, extent: Extent, inputs: &mut Vec<Input>) {
        if extent != Extent::Attitude {
            self.listen(inputs);
        }
        if let Some(mut reporter) = self.reporter.take() {
            let first = inputs.len();
            self.report_true_location(inputs);
            reporter.packet(self.now, extent, &self.snapshot(), &self.cameras, &self.radios, inputs);
            self.reporter = Some(reporter);
            if extent != Extent::Attitude {
                self.report_subsystems(inputs);
            }
            self.disturb(inputs, first);
        }
    }

    /// Samples the radios, and reports which link was lost or regained.
    fn listen(&mut self, inputs: &mut Vec<Input>) {
        let elapsed_s = (self.now - self.heard_at).seconds();
        self.heard_at = self.now;
        let (here, altitude_m, now_s) = (self.position(), self.state.altitude_m, self.now.seconds());
        let living = self.living.as_deref();
        for radio in &mut self.radios {
            let name = &radio.modem.name;
            radio.silenced = living.is_some_and(|it| it.faults.find(FaultKind::Modem, name, self.now).is_some());
            if let Some(change) = radio.listen(here, altitude_m, now_s, elapsed_s) {
                let name = if change == LinkChange::Lost { "link-lost" } else { "link-regained" };
                let form = Value::list([Value::symbol(name), Value::symbol(&radio.modem.name)]);
                inputs.push(Input::new(self.now, EventKind::Occurrence(form)));
            }
        }
    }

    /// Decides when to report next: densely on lines and while scanning, sparsely in cruise, and when a stage ends.
    pub(crate) fn plan(&mut self, sent: Option<Extent>) {
        let report = &self.model.report;
        let scanning = self.scanner_on || self.flight.is_on_line();
        let usual = if self.settled { report.cruise_s } else { report.manoeuvring_s };
        let mut interval_s = if scanning { report.scanning_s } else { usual };
        let left_s = self.flight.stage_m / self.state.ground_speed().max(1.0);
        if left_s < interval_s {
            interval_s = left_s.max(STEP_S);
        }
        let next = self.now + instants::span(interval_s);
        let more = matches!(sent, Some(Extent::Fast | Extent::Full));
        self.packet_due = if more { next } else { self.packet_due.min(next) };
        if sent.is_some() {
            self.attitude_due = self.now + instants::span(ATTITUDE_S);
        }
        self.planned_stop = if self.is_sensing() { self.packet_due.min(self.attitude_due) } else { self.packet_due };
    }

    /// Returns true in flight while a sensor is in use.
    fn is_sensing(&self) -> bool {
        !self.state.on_ground && (self.scanner_on || self.cameras.iter().any(Camera::is_looking))
    }

    pub(crate) fn snapshot(&self) -> Snapshot<'_> {
        let height_m = (self.state.altitude_m - self.ground_m).max(0.0);
        let scanner = self.model.scanner.as_ref();
        let footprint_m = scanner.map_or(0.0, |scanner| {
            footprint_m(height_m, self.state.roll_rad, 0.5 * scanner.field_of_view_deg * RAD_PER_DEG)
        });
        let level = self.state.roll_rad.abs() <= self.model.level_roll_deg_max * RAD_PER_DEG;
        let hidden = self.scanner_on && self.is_ground_hidden();
        let gliding = !self.state.engine_running && !self.state.on_ground;
        let phase = if self.crashed {
            Phase::Crashed
        } else if gliding {
            Phase::Gliding
        } else {
            self.flight.phase()
        };
        Snapshot {
            state: &self.state,
            model: &self.model,
            wind: self.wind,
            air: Air::at(self.state.altitude_m),
            ground_m: self.ground_m,
            phase,
            distance_to_go_m: self.flight.to_go_m,
            altitude_m_commanded: self.altitude_m,
            true_airspeed_commanded: self.true_airspeed,
            home: self.home,
            scanner_on: scanner.map(|_| self.scanner_on),
            scan_valid: self.scanner_on && level && !self.state.on_ground && !hidden,
            footprint_m,
            hidden,
            gusts: &self.turbulence.gusts,
        }
    }

    /// Slews the cameras for `dt` seconds.
    pub(crate) fn move_cameras(&mut self, dt: f64, inputs: &mut Vec<Input>) {
        let mut cameras = std::mem::take(&mut self.cameras);
        let mut taken = Vec::new();
        for camera in &mut cameras {
            if camera.is_picture_due(self.state.ground_speed(), dt, self.now) {
                taken.push(camera.clone());
            }
            match camera.follow(&self.state, dt) {
                Pointing::Same => {}
                Pointing::Aligned => {
                    self.changed = true;
                    let target = camera.aim.as_ref().map_or_else(Value::nil, Aim::given);
                    if let Some(command) = camera.command.take() {
                        self.answer(command, Ok(target), inputs);
                    }
                }
                Pointing::OutOfView => {
                    let target = camera.aim.as_ref().map_or_else(Value::nil, Aim::given);
                    let name = Value::symbol(&camera.model.name);
                    let form = Value::list([Value::symbol("out-of-view"), name, target]);
                    inputs.push(Input::new(self.now, EventKind::Occurrence(form)));
                    self.changed = true;
                }
            }
        }
        self.cameras = cameras;
        for camera in &taken {
            self.changed = true;
            self.say_taken(camera, inputs);
        }
        let slewing = self.cameras.iter().any(|camera| camera.aim.is_some());
        self.settled = self.settled && !slewing;
    }

    /// Ends waits, power-ups and exposures that are due.
    pub(crate) fn ring_timers(&mut self, inputs: &mut Vec<Input>) {
        let (due, left): (Vec<_>, Vec<_>) = self.waits.drain(..).partition(|(at, ..)| *at <= self.now);
        self.waits = left;
        for (_, command, answer) in due {
            self.answer(command, Ok(answer), inputs);
        }
        let mut next = Vec::new();
        let mut cameras = std::mem::take(&mut self.cameras);
        for camera in cameras.iter_mut().filter(|camera| camera.slew_until.is_some_and(|at| at <= self.now)) {
            let reason = camera.fail_slew(&self.state);
            if let Some(command) = camera.command.take() {
                self.answer(command, Err(format!("point-camera: {reason}")), inputs);
            }
        }
        for camera in cameras.iter_mut().filter(|camera| camera.timer.is_some_and(|at| at <= self.now)) {
            camera.timer = None;
            if camera.state == CameraState::Exposing && camera.pictures_left > 0 {
                camera.pictures_left -= 1;
                camera.timer = Some(self.now + instants::span(camera.model.picture_s.max(camera.model.interval_s_min)));
                next.push(camera.clone());
                continue;
            }
            let name = Value::symbol(&camera.model.name);
            let target = camera.aim.as_ref().map_or_else(Value::nil, Aim::given);
            let powered = camera.state == CameraState::PoweringUp;
            let (event, object, answer) =
                if powered { ("ready", name.clone(), name) } else { ("image-in-memory", target.clone(), target) };
            camera.state = if powered { CameraState::Ready } else { CameraState::Pointing };
            inputs.push(Input::new(self.now, EventKind::Occurrence(Value::list([Value::symbol(event), object]))));
            if let Some(command) = camera.command.take() {
                self.answer(command, Ok(answer), inputs);
            }
        }
        self.cameras = cameras;
        next.iter().for_each(|camera| self.say_taken(camera, inputs));
    }
}

/// Returns the width on the ground of a scanner that looks `half_view_rad` to both sides from `height_m`, rolled by `roll_rad`.
fn footprint_m(height_m: f64, roll_rad: f64, half_view_rad: f64) -> f64 {
    // Beyond 80 degrees from straight down a line is horizon, not ground.
    let edge = |angle: f64| tan(angle.clamp(-1.396, 1.396));
    height_m * (edge(half_view_rad + roll_rad) + edge(half_view_rad - roll_rad))
}
