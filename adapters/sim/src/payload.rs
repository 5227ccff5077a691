//! Commands to the payload: scanner and cameras.

use crate::arguments::Arguments;
use crate::camera::{Aim, Camera, CameraState, DOWN, FixedDirection, PictureRun};
use crate::instants;
use crate::living::FaultKind;
use crate::living::downlink::DataOrder;
use crate::names::unknown_name;
use crate::packet::Extent;
use crate::world::SimulatedWorld;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_model::effect::CommandId;
use apex_model::event::EventKind;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use apex_vehicle::Airframe;

impl SimulatedWorld {
    /// Executes `(scanner on)` and `(scanner off)`.
    pub(crate) fn switch_scanner(
        &mut self,
        id: CommandId,
        arguments: &Arguments,
        inputs: &mut Vec<Input>,
    ) -> Result<(), String> {
        if self.model.scanner.is_none() {
            return Err(arguments.wrong(&format!("{} carries no scanner", self.vehicle)));
        }
        let wanted = arguments.at(0).and_then(Value::as_symbol);
        let order = self.data_order(arguments)?;
        if wanted.is_some_and(|word| word.is("on")) {
            if self.suffers(FaultKind::PayloadPower, "") {
                return Err(arguments.wrong("the payload has no power"));
            }
            if self.suffers(FaultKind::Sensor, "scanner") {
                return Err(arguments.wrong("the scanner delivers no images"));
            }
        }
        self.scanner_on = match wanted.map(|symbol| symbol.folded()) {
            Some("on") => true,
            Some("off") => false,
            _ => return Err(arguments.wrong("the scanner is switched on or off")),
        };
        // The image of a line is stored when the scanner is switched off, as ordered when it was switched on.
        if let Some(downlink) =
            self.living.as_mut().and_then(|living| living.downlink.as_mut()).filter(|_| self.scanner_on)
        {
            downlink.scanner_order = order;
        }
        self.answer(id, Ok(Value::symbol(if self.scanner_on { "on" } else { "off" })), inputs);
        Ok(())
    }

    /// Executes `camera`, `point-camera`, `take-picture`, `take-pictures` and `stop-pictures`.
    pub(crate) fn use_camera(
        &mut self,
        id: CommandId,
        command: &str,
        arguments: &Arguments,
        inputs: &mut Vec<Input>,
    ) -> Result<(), String> {
        let name =
            arguments.at(0).and_then(Value::as_symbol).map(|symbol| symbol.folded().to_owned()).unwrap_or_default();
        let known: Vec<String> = self.cameras.iter().map(|camera| camera.model.name.clone()).collect();
        let index = self.cameras.iter().position(|camera| camera.model.name.to_lowercase() == name);
        let camera = index.and_then(|index| self.cameras.get(index)).cloned();
        let (Some(index), Some(mut camera)) = (index, camera) else {
            return Err(arguments.wrong(&unknown_name("camera", &name, known.iter().map(String::as_str))));
        };
        let ready = camera.is_ready();
        self.check_works(&camera, command, arguments)?;
        let switch = arguments.at(1).and_then(Value::as_symbol).map(|symbol| symbol.folded().to_owned());
        if command == "camera" && switch.as_deref() == Some("power-up") && ready {
            self.say_ready(id, &camera.model.name, inputs);
            return Ok(());
        }
        let old = camera.command.take();
        let mut answer = None;
        match (command, switch.as_deref()) {
            ("camera", Some("power-up")) => {
                let waiting = camera.timer.filter(|_| camera.state == CameraState::PoweringUp);
                camera.state = CameraState::PoweringUp;
                let fresh = self.now + instants::span(camera.model.power_up_s);
                camera.timer = Some(waiting.unwrap_or(fresh));
                camera.command = Some(id);
            }
            ("camera", Some(off @ ("power-off" | "rest"))) => {
                camera.stop(off == "power-off");
                answer = Some(Value::symbol(&camera.model.name));
            }
            ("camera", _) => return Err(arguments.wrong("the action of a camera is power-up, power-off or rest")),
            (_, _) if !ready => return Err(arguments.wrong(&format!("{name} is not powered up"))),
            ("point-camera", _) => {
                self.point(&mut camera, arguments)?;
                camera.command = Some(id);
            }
            ("stop-pictures", _) => {
                camera.run = None;
                answer = Some(Value::symbol(&camera.model.name));
            }
            _ if camera.state == CameraState::Slewing || camera.aim.is_none() => {
                return Err(arguments.wrong(&format!("{name} does not point at anything yet: use point-camera first")));
            }
            ("take-pictures", _) => {
                let step = arguments.picture_step()?;
                camera.data = self.data_order(arguments)?;
                camera.run = Some(PictureRun { step, flown_m: 0.0, waited_s: 0.0, last: None });
                answer = Some(Value::symbol(&camera.model.name));
                self.settled = false;
            }
            _ => self.expose(&mut camera, id, arguments, inputs)?,
        }
        if let Some(slot) = self.cameras.get_mut(index) {
            *slot = camera;
        }
        if let Some(old) = old {
            self.answer(old, Err(format!("superseded by another command to {name}")), inputs);
        }
        if let Some(answer) = answer {
            self.answer(id, Ok(answer), inputs);
        }
        Ok(())
    }

    /// Reads how a command wants its images handled. Without a downlink nothing can be sent.
    fn data_order(&self, arguments: &Arguments) -> Result<Option<DataOrder>, String> {
        let order = arguments.data_keyword()?;
        let has_link = self.living.as_ref().is_some_and(|living| living.downlink.is_some());
        match order {
            Some(DataOrder::Stream | DataOrder::Process { .. }) if !has_link => Err(arguments.wrong(
                "images cannot be sent, because the world file states no `downlink`; write `:data store` or add one",
            )),
            _ => Ok(order),
        }
    }

    /// Refuses a command that a failure of power or sensor makes impossible.
    fn check_works(&self, camera: &Camera, command: &str, arguments: &Arguments) -> Result<(), String> {
        let name = &camera.model.name;
        let is_up = arguments.at(1).and_then(Value::as_symbol).is_some_and(|word| word.is("power-up"));
        if command == "camera" && is_up && self.suffers(FaultKind::PayloadPower, "") {
            return Err(arguments.wrong(&format!("{name} has no power")));
        }
        if command == "take-picture" && camera.broken {
            return Err(arguments.wrong(&format!("{name} delivers no images")));
        }
        Ok(())
    }

    /// Begins to point at the aim of the command.
    fn point(&self, camera: &mut Camera, arguments: &Arguments) -> Result<(), String> {
        let aim = self.aim(arguments)?;
        if let Some(reason) = camera.refusal(&aim, &self.state) {
            return Err(arguments.wrong(&reason));
        }
        let rotorcraft = self.model.airframe == Airframe::Rotorcraft;
        let yaw_rate = rotorcraft.then_some(self.model.yaw_rate_deg_s_max * RAD_PER_DEG);
        let slew_s = camera.begin_slew(aim, &self.state, yaw_rate);
        camera.slew_until = Some(self.now + instants::span(slew_s));
        Ok(())
    }

    /// Begins the first exposure of a command.
    fn expose(
        &mut self,
        camera: &mut Camera,
        id: CommandId,
        arguments: &Arguments,
        inputs: &mut Vec<Input>,
    ) -> Result<(), String> {
        camera.pictures_left = arguments.count_keyword()?.saturating_sub(1);
        camera.data = self.data_order(arguments)?;
        camera.state = CameraState::Exposing;
        camera.timer = Some(self.now + instants::span(camera.model.picture_s));
        camera.command = Some(id);
        self.say_taken(camera, inputs);
        Ok(())
    }

    fn aim(&self, arguments: &Arguments) -> Result<Aim, String> {
        if arguments.at(1).and_then(Value::as_symbol).is_some_and(|symbol| symbol.is(DOWN)) {
            return Ok(Aim::Down);
        }
        if let (Some((azimuth_rad, tilt_rad)), Some(given)) = (arguments.direction(1)?, arguments.at(1)) {
            return Ok(Aim::Along(FixedDirection { azimuth_rad, tilt_rad, given: given.clone() }));
        }
        let spot = arguments.spot(1, "target")?;
        let ground_m = self.ground.elevation_m_at(spot.position);
        let altitude_m = spot.thing_altitude_m.unwrap_or(ground_m);
        Ok(Aim::At(spot, altitude_m))
    }

    /// Reports the beginning of an exposure with position, attitude and angles of the mount at its instant, which belong to the image.
    pub(crate) fn say_taken(&mut self, camera: &Camera, inputs: &mut Vec<Input>) {
        self.report(Extent::Attitude, inputs);
        let target = camera.aim.as_ref().map_or_else(Value::nil, Aim::given);
        let clear = self.is_picture_clear(camera);
        let head = match (camera.broken, clear) {
            (true, _) => "image-blank",
            (false, true) => "image-taken",
            (false, false) => "image-obscured",
        };
        let form = [Value::symbol(head), Value::symbol(&camera.model.name), target];
        inputs.push(Input::new(self.now, EventKind::Occurrence(Value::list(form))));
        if clear {
            self.keep_picture(camera, inputs);
        }
    }

    /// Reports that a camera is powered, even if it already was, because the command waits for the event.
    fn say_ready(&self, id: CommandId, camera: &str, inputs: &mut Vec<Input>) {
        let name = Value::symbol(camera);
        let form = Value::list([Value::symbol("ready"), name.clone()]);
        inputs.push(Input::new(self.now, EventKind::Occurrence(form)));
        self.answer(id, Ok(name), inputs);
    }
}
