//! Commands of the simulated vehicle: conversion of forms to orders, rejections with messages, supersession and withdrawal.

use crate::arguments::{Arguments, Spot};
use crate::camera::CameraState;
use crate::fixed_wing::true_airspeed_min;
use crate::flight::{ActiveOrder, Order};
use crate::instants;
use crate::names::unknown_name;
use crate::way::{Way, with_goal};
use crate::world::{Setpoint, SimulatedWorld};
use apex_model::effect::CommandId;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use apex_vehicle::Airframe;

/// A command: name, usage, fewest and most positional arguments, keywords.
struct CommandForm {
    name: &'static str,
    usage: &'static str,
    arguments: (usize, usize),
    keywords: &'static [&'static str],
}

const fn command(
    name: &'static str,
    usage: &'static str,
    arguments: (usize, usize),
    keywords: &'static [&'static str],
) -> CommandForm {
    CommandForm { name, usage, arguments, keywords }
}

/// Every command with its usage.
const COMMANDS: &[CommandForm] = &[
    command("take-off", "(take-off ALTITUDE [:centre LOCATION])", (1, 1), &["centre"]),
    command(
        "fly-to",
        "(fly-to LOCATION [:speed S] [:altitude A] [:hold D [:hold-around CENTRE]] [:via WAY])",
        (1, 1),
        &["speed", "altitude", "hold", "hold-around", "via"],
    ),
    command(
        "fly-line",
        "(fly-line FROM TO [:speed S] [:altitude A] [:hold D [:hold-around CENTRE]] [:via WAY])",
        (2, 2),
        &["speed", "altitude", "hold", "hold-around", "via"],
    ),
    command(
        "join-line",
        "(join-line FROM TO [:speed S] [:line-speed S] [:altitude A] [:hold D [:hold-around CENTRE]] [:via WAY])",
        (2, 2),
        &["speed", "line-speed", "altitude", "hold", "hold-around", "via"],
    ),
    command(
        "loiter",
        "(loiter LOCATION [:radius R] [:duration D] [:altitude A] [:speed S] [:centre LOCATION] [:hold D [:hold-around CENTRE]] [:via WAY])",
        (1, 1),
        &["radius", "duration", "altitude", "speed", "centre", "hold", "hold-around", "via"],
    ),
    command(
        "hover",
        "(hover [LOCATION] [:duration D] [:altitude A] [:hold D [:hold-around CENTRE]] [:via WAY])",
        (0, 1),
        &["duration", "altitude", "hold", "hold-around", "via"],
    ),
    command(
        "land",
        "(land LOCATION [:course C] [:hold D [:hold-around CENTRE]] [:via WAY]) or (land here)",
        (1, 1),
        &["course", "hold", "hold-around", "via"],
    ),
    command(
        "follow-path",
        "(follow-path POINTS [:speeds SPEEDS] [:speed S] [:nose N])",
        (1, 1),
        &["speeds", "speed", "nose"],
    ),
    command("set-altitude", "(set-altitude ALTITUDE)", (1, 1), &[]),
    command("set-speed", "(set-speed SPEED)", (1, 1), &[]),
    command("set-heading", "(set-heading HEADING)", (1, 1), &[]),
    command("scanner", "(scanner on [:data D]) or (scanner off)", (1, 1), &["data"]),
    command("camera", "(camera NAME power-up), (camera NAME power-off) or (camera NAME rest)", (2, 2), &[]),
    command("point-camera", "(point-camera NAME LOCATION), or down or (along AZIMUTH TILT) as LOCATION", (2, 2), &[]),
    command("take-picture", "(take-picture NAME [:count N] [:data D])", (1, 1), &["count", "data"]),
    command(
        "take-pictures",
        "(take-pictures NAME :every DISTANCE|:interval TIME [:data D])",
        (1, 1),
        &["every", "interval", "data"],
    ),
    command("stop-pictures", "(stop-pictures NAME)", (1, 1), &[]),
    command("wait", "(wait DURATION)", (1, 1), &[]),
];

/// Returns name, least and greatest number of positional arguments, and keywords of each command, as `library/interface.pdl` declares them.
pub fn command_forms() -> impl Iterator<Item = (&'static str, (usize, usize), &'static [&'static str])> {
    COMMANDS.iter().map(|command| (command.name, command.arguments, command.keywords))
}

impl SimulatedWorld {
    /// Executes a command or rejects it.
    pub(crate) fn obey(&mut self, id: CommandId, form: &Value, inputs: &mut Vec<Input>) {
        if let Err(reason) = self.try_obey(id, form, inputs) {
            self.answer(id, Err(reason), inputs);
        }
    }

    fn try_obey(&mut self, id: CommandId, form: &Value, inputs: &mut Vec<Input>) -> Result<(), String> {
        let known = || COMMANDS.iter().map(|command| command.name);
        let (name, items) = match form.as_list() {
            Some([Value::Symbol(name), items @ ..]) => (name.folded().to_owned(), items),
            _ => return Err(format!("{form} is not a command; a command is a list like (fly-to (34.7 -119.8 7010))")),
        };
        let command = COMMANDS.iter().find(|command| command.name == name);
        let command = command.ok_or_else(|| unknown_name("command", &name, known()))?;
        if self.is_crashed() {
            return Err(format!("{name}: {} has crashed and carries out no commands", self.vehicle));
        }
        let places = self.places.clone();
        let arguments =
            Arguments::split(command.name, command.usage, items, command.arguments, command.keywords, &places)?;
        match command.name {
            "take-off" | "fly-to" | "fly-line" | "join-line" | "loiter" | "hover" | "land" | "follow-path" => {
                self.fly_order(id, form, command.name, &arguments, inputs)
            }
            "set-altitude" => {
                let altitude_m = arguments.altitude(0)?;
                self.check_altitude(&arguments, altitude_m, self.state.position)?;
                let answer = Value::measured(altitude_m, Dimension::LENGTH);
                self.claim_altitude(altitude_m, Some(Setpoint { command: id, text: form.to_string(), answer }), inputs);
                self.flight.level();
                Ok(())
            }
            "set-speed" => {
                let speed = arguments.speed(0)?;
                self.check_speed(&arguments, speed, self.state.altitude_m)?;
                let answer = Value::measured(speed, Dimension::SPEED);
                self.claim_speed(speed, Some(Setpoint { command: id, text: form.to_string(), answer }), inputs);
                Ok(())
            }
            "set-heading" => self.turn_in_place(id, form, &arguments, inputs),
            "scanner" => self.switch_scanner(id, &arguments, inputs),
            "wait" => {
                let duration = arguments.duration(0)?;
                self.waits.push((instants::not_before(self.now + duration), id, Value::Duration(duration)));
                Ok(())
            }
            _ => self.use_camera(id, command.name, &arguments, inputs),
        }
    }

    fn fly_order(
        &mut self,
        id: CommandId,
        form: &Value,
        name: &str,
        arguments: &Arguments,
        inputs: &mut Vec<Input>,
    ) -> Result<(), String> {
        let grounded = self.state.on_ground;
        if grounded && name != "take-off" {
            return Err(arguments.wrong(&format!("{} is on the ground: take off first", self.vehicle)));
        }
        let altitude_keyword = arguments.altitude_keyword()?;
        let speed = arguments.speed_keyword()?;
        let (order, spot_altitude_m) = self.read_order(name, arguments, altitude_keyword.is_some())?;
        let altitude_m = altitude_keyword.or(spot_altitude_m);
        let points = arguments.way_keyword()?;
        let arrives = points.last().map_or(self.state.position, |point| point.position);
        let points = match &order {
            Order::FlyTo { to, .. } if self.situation().fixed() => with_goal(points, to.position),
            _ => points,
        };
        let way = Way::new(points, &self.situation());
        let hold = arguments.hold_keyword()?;
        // The final approach of a small aircraft begins below the lowest altitude of other flights.
        if let Some(altitude_m) = altitude_m.filter(|_| !matches!(order, Order::Land { .. })) {
            self.check_altitude(arguments, altitude_m, arrives)?;
        }
        let line_speed = arguments.line_speed_keyword()?;
        let here_m = self.state.altitude_m;
        for (speed, at_m) in [(speed, here_m), (line_speed, altitude_m.unwrap_or(here_m))] {
            speed.map_or(Ok(()), |speed| self.check_speed(arguments, speed, at_m))?;
        }
        if let Some(altitude_m) = altitude_m {
            self.claim_altitude(altitude_m, None, inputs);
        }
        // The speed of a path applies to the path only, because later flight may meet wind for which it is too slow.
        if let Some(speed) = speed.filter(|_| !matches!(order, Order::FollowPath(_))) {
            self.claim_speed(speed, None, inputs);
        }
        if let Some(old) = self.flight.command.take() {
            self.answer(old, Err(format!("superseded by {form}")), inputs);
        }
        self.break_off();
        let begin_m = match &order {
            Order::FlyLine { from, to } => self.left_lines.take(from.position, to.position),
            _ => 0.0,
        };
        self.flight = ActiveOrder::begin_at(Some(id), order, begin_m, (way, hold), &self.situation());
        self.flight.line_speed = line_speed;
        Ok(())
    }

    /// Stores the flown distance of a line that is interrupted, so that it can be resumed there.
    fn break_off(&mut self) {
        if let Some((from, to, along_m)) = self.flight.unfinished() {
            self.left_lines.remember(from, to, along_m);
        }
    }

    /// Returns the order of a command, and the altitude that the command states.
    fn read_order(&self, name: &str, arguments: &Arguments, at_altitude: bool) -> Result<(Order, Option<f64>), String> {
        let refuse = |what: String| Err(arguments.wrong(&what));
        Ok(match name {
            "take-off" => {
                let altitude_m = arguments.altitude(0)?;
                if !self.state.on_ground {
                    return refuse(format!("{} is already in the air", self.vehicle));
                }
                if !self.state.engine_running {
                    return refuse("there is no energy left".to_owned());
                }
                (Order::TakeOff { altitude_m, centre: arguments.centre_keyword()? }, Some(altitude_m))
            }
            "fly-to" => {
                let to = arguments.spot(0, "location")?;
                let altitude_m = to.altitude_m;
                (Order::FlyTo { at_altitude: at_altitude || altitude_m.is_some(), to }, altitude_m)
            }
            "fly-line" | "join-line" => {
                let (from, to) = (arguments.spot(0, "beginning")?, arguments.spot(1, "end")?);
                let length_m = crate::path::bearing(from.position, to.position).1;
                if length_m < 1.0 {
                    return refuse("the line has no length".to_owned());
                }
                let altitude_m = from.altitude_m.or(to.altitude_m);
                let join = name == "join-line";
                (if join { Order::JoinLine { from, to } } else { Order::FlyLine { from, to } }, altitude_m)
            }
            "follow-path" => {
                let path = self.path_to_follow(arguments)?;
                let last_m = path.last_altitude_m();
                (Order::FollowPath(Box::new(path)), last_m)
            }
            "loiter" => {
                let around = arguments.spot(0, "location")?;
                let altitude_m = around.altitude_m;
                let position = arguments.centre_keyword()?.unwrap_or(around.position);
                let around = Spot { position, ..around };
                (self.loiter_order(around, arguments)?, altitude_m)
            }
            "hover" => {
                if self.model.airframe == Airframe::FixedWing {
                    return refuse(format!("{} is a fixed wing and cannot hover: use loiter", self.vehicle));
                }
                let at = arguments.optional_spot(0, "location")?;
                let altitude_m = at.as_ref().and_then(|at| at.altitude_m);
                (Order::Hover { at, duration: arguments.duration_keyword()? }, altitude_m)
            }
            _ => {
                let here = arguments.at(0).and_then(Value::as_symbol).is_some_and(|name| name.is("here"));
                let at = if here { self.spot_here() } else { arguments.spot(0, "location")? };
                let field_m = self.ground.elevation_m_at(at.position);
                let fixed = self.model.airframe == Airframe::FixedWing;
                let course_rad = arguments.course_keyword()?;
                (Order::Land { at, course_rad, field_m }, fixed.then_some(field_m + self.model.final_approach_height_m))
            }
        })
    }

    /// Returns the position of the vehicle; for a rotorcraft the nearest place at which it can stop.
    fn spot_here(&self) -> Spot {
        let position = if self.situation().fixed() { self.state.position } else { self.situation().stopping_place() };
        Spot { position, altitude_m: None, thing_altitude_m: None, given: Value::symbol("here") }
    }

    fn loiter_order(&self, around: Spot, arguments: &Arguments) -> Result<Order, String> {
        let duration = arguments.duration_keyword()?;
        let here = self.situation();
        let tightest_m = here.turn_radius_m();
        let radius_m = arguments.radius_keyword()?.unwrap_or_else(|| here.loiter_radius_m());
        let fixed = self.model.airframe == Airframe::FixedWing;
        if radius_m <= 0.0 || (fixed && radius_m < tightest_m) {
            let (name, speed) = (&self.vehicle, self.true_airspeed);
            return Err(arguments.wrong(&format!(
                "a radius of {radius_m:.0} m is too tight: {name} turns within {tightest_m:.0} m at {speed:.0} m/s in this wind"
            )));
        }
        Ok(Order::Loiter { around, radius_m, duration })
    }

    pub(crate) fn check_altitude(&self, arguments: &Arguments, altitude_m: f64, place: Position) -> Result<(), String> {
        let lowest_m = self.ground.elevation_m_at(place) + self.situation().height_m_min();
        let ceiling_m = self.model.ceiling_m;
        if altitude_m > ceiling_m {
            return Err(arguments.wrong(&format!("{altitude_m:.0} m is above the ceiling of {ceiling_m:.0} m")));
        }
        if altitude_m < lowest_m {
            return Err(arguments.wrong(&format!(
                "{altitude_m:.0} m is below {lowest_m:.0} m, the lowest safe altitude over the ground here (altitudes are above sea level)"
            )));
        }
        Ok(())
    }

    fn check_speed(&self, arguments: &Arguments, speed: f64, altitude_m: f64) -> Result<(), String> {
        let (slowest, fastest) = (true_airspeed_min(&self.model, altitude_m), self.model.true_airspeed_m_s_max);
        let too_slow = speed < slowest || speed <= 0.0;
        if too_slow || speed > fastest {
            let (slowest, fastest) = (libm::ceil(10.0 * slowest) / 10.0, libm::floor(10.0 * fastest) / 10.0);
            return Err(arguments.wrong(&format!(
                "{speed:.2} m/s true airspeed is outside of {slowest:.1} to {fastest:.1} m/s, which {} can fly here",
                self.vehicle
            )));
        }
        Ok(())
    }

    /// Sets the commanded altitude; supersedes the command that set it before.
    fn claim_altitude(&mut self, altitude_m: f64, by: Option<Setpoint>, inputs: &mut Vec<Input>) {
        self.altitude_m = altitude_m;
        if let Some(old) = std::mem::replace(&mut self.altitude_command, by) {
            self.answer(old.command, Err(format!("{} was superseded by another altitude", old.text)), inputs);
        }
    }

    fn claim_speed(&mut self, speed: f64, by: Option<Setpoint>, inputs: &mut Vec<Input>) {
        self.true_airspeed = speed;
        if let Some(old) = std::mem::replace(&mut self.speed_command, by) {
            self.answer(old.command, Err(format!("{} was superseded by another speed", old.text)), inputs);
        }
    }

    /// Answers the finished flight order; the vehicle circles, hovers or parks until the next one.
    pub(crate) fn flight_done(&mut self, value: Value, inputs: &mut Vec<Input>) {
        if let Some(speed) = self.flight.line_speed.take() {
            self.claim_speed(speed, None, inputs);
        }
        if let Some(command) = self.flight.command.take() {
            self.answer(command, Ok(value), inputs);
        }
        if let Some((from, to)) = self.flight.ends_of_line() {
            self.left_lines.flown(from, to);
        }
        if self.flight.goes_on() {
            self.changed = true;
            return;
        }
        self.idle();
    }

    /// Answers a flight order that cannot be carried out; the vehicle circles or hovers until the next one.
    pub(crate) fn flight_failed(&mut self, reason: &str, inputs: &mut Vec<Input>) {
        if let Some(command) = self.flight.command.take() {
            self.answer(command, Err(reason.to_owned()), inputs);
        }
        self.idle();
    }

    fn idle(&mut self) {
        let order = if self.state.on_ground { Order::Parked } else { Order::Hold };
        self.flight = ActiveOrder::begin(None, order, &self.situation());
        self.changed = true;
    }

    /// Answers the setpoint commands whose value is reached.
    pub(crate) fn meet_setpoints(&mut self, inputs: &mut Vec<Input>) {
        if let Some(speed) = self.flight.due_line_speed(&self.situation()) {
            self.flight.line_speed = None;
            self.claim_speed(speed, None, inputs);
        }
        let altitude = (self.altitude_m - self.state.altitude_m).abs() <= 10.0;
        let speed = (self.true_airspeed - self.state.true_airspeed).abs() <= 1.0;
        let hovering = self.model.airframe == Airframe::Rotorcraft && self.state.ground_speed() < 0.5;
        let error_rad = self.nose_rad.map_or(0.0, |nose| crate::motion::wrap_pi(nose - self.state.heading_rad));
        let heading = error_rad.abs() < 0.0175;
        let met = [
            if altitude { self.altitude_command.take() } else { None },
            // A hovering aircraft takes up its speed when it next moves.
            if speed || hovering { self.speed_command.take() } else { None },
            if heading { self.heading_command.take() } else { None },
        ];
        for setpoint in met.into_iter().flatten() {
            self.answer(setpoint.command, Ok(setpoint.answer), inputs);
            self.changed = true;
        }
    }

    /// Stops carrying out a command; no task waits for its answer any longer.
    pub(crate) fn give_up(&mut self, command: CommandId) {
        let is = |setpoint: &mut Setpoint| setpoint.command == command;
        if self.flight.command == Some(command) {
            self.flight.command = None;
            self.break_off();
            if !self.is_crashed() {
                self.idle();
            }
        }
        if self.altitude_command.take_if(is).is_some() {
            self.altitude_m = self.state.altitude_m;
        }
        if self.speed_command.take_if(is).is_some() && self.state.true_airspeed > 0.0 {
            self.true_airspeed = self.state.true_airspeed;
        }
        if self.heading_command.take_if(is).is_some() {
            self.nose_rad = Some(self.state.heading_rad);
        }
        self.waits.retain(|(_, waiting, _)| *waiting != command);
        for camera in self.cameras.iter_mut().filter(|camera| camera.command == Some(command)) {
            (camera.command, camera.timer, camera.slew_until) = (None, None, None);
            let powering = camera.state == CameraState::PoweringUp;
            let exposing = camera.state == CameraState::Exposing;
            (camera.state, camera.aim) = match (powering, exposing) {
                (true, _) => (CameraState::Off, None),
                (_, true) => (CameraState::Pointing, camera.aim.take()),
                _ => (CameraState::Ready, None),
            };
        }
    }

    /// Answers all commands with a failure after a crash.
    pub(crate) fn fail_everything(&mut self, inputs: &mut Vec<Input>) {
        let vehicle = self.vehicle.clone();
        let reason = || Err(format!("{vehicle} has crashed"));
        let setpoints = [self.altitude_command.take(), self.speed_command.take(), self.heading_command.take()];
        let mut open: Vec<CommandId> = setpoints.into_iter().flatten().map(|setpoint| setpoint.command).collect();
        open.extend(self.flight.command.take());
        open.extend(self.cameras.iter_mut().filter_map(|camera| camera.command.take()));
        open.extend(self.waits.drain(..).map(|(_, command, _)| command));
        open.sort_unstable();
        for command in open {
            inputs.push(Input::new(self.now, apex_model::event::EventKind::CommandAcknowledged(command, reason())));
        }
        self.flight = ActiveOrder::begin(None, Order::Parked, &self.situation());
    }
}
