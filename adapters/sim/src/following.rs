//! The commands `follow-path` and `set-heading`, and the headings that they demand.

use crate::arguments::Arguments;
use crate::fixed_wing::true_airspeed_min;
use crate::flight::{ActiveOrder, Stage};
use crate::follow::FollowedPath;
use crate::world::{Setpoint, SimulatedWorld};
use apex_model::effect::CommandId;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use apex_vehicle::Airframe;

/// Airspeeds outside of the vehicle's range by less than this, m/s, are rounded figures of the limits.
const ROUNDED_MPS: f64 = 0.05;

impl SimulatedWorld {
    /// Reads the path of a command `follow-path`, and checks its altitudes, airspeeds and heading.
    pub(crate) fn path_to_follow(&self, arguments: &Arguments) -> Result<FollowedPath, String> {
        let points = arguments.points(0)?;
        let speeds = arguments.speeds_keyword(points.len())?;
        for altitude_m in points.iter().filter_map(|point| point.altitude_m) {
            self.check_altitude(arguments, altitude_m, self.state.position)?;
        }
        let is_fixed_wing = self.model.airframe == Airframe::FixedWing;
        let (least, most) = (true_airspeed_min(&self.model, self.state.altitude_m), self.model.true_airspeed_m_s_max);
        let inside = |speed: &f64| (least - ROUNDED_MPS..=most + ROUNDED_MPS).contains(speed);
        if let Some(wrong) = speeds.iter().find(|speed| is_fixed_wing && !inside(speed)) {
            let name = &self.vehicle;
            return Err(arguments.wrong(&format!("{name} flies {least:.1} to {most:.1} m/s here, not {wrong:.1} m/s")));
        }
        let path = FollowedPath::new(points, &speeds, &self.situation());
        let mut path = path.ok_or_else(|| arguments.wrong("the path has no length"))?;
        path.true_airspeed = arguments.speed_keyword()?;
        path.nose = arguments.nose_keyword()?;
        if path.nose.is_some() && is_fixed_wing {
            let why = format!("{} is a fixed wing, whose nose follows its course: omit `:nose`", self.vehicle);
            return Err(arguments.wrong(&why));
        }
        Ok(path)
    }

    /// Turns a rotorcraft on the spot.
    pub(crate) fn turn_in_place(
        &mut self,
        id: CommandId,
        form: &Value,
        arguments: &Arguments,
        inputs: &mut Vec<Input>,
    ) -> Result<(), String> {
        let heading_rad = crate::motion::wrap_tau(arguments.heading(0)?);
        if self.model.airframe == Airframe::FixedWing {
            return Err(arguments.wrong(&format!("{} is a fixed wing and turns by flying: use fly-to", self.vehicle)));
        }
        self.nose_rad = Some(heading_rad);
        let answer = Value::measured(heading_rad, Dimension::ANGLE);
        let setpoint = Setpoint { command: id, text: form.to_string(), answer };
        if let Some(old) = self.heading_command.replace(setpoint) {
            self.answer(old.command, Err(format!("{} was superseded by {form}", old.text)), inputs);
        }
        Ok(())
    }
}

impl ActiveOrder {
    /// Returns the heading that the flight command demands of a rotorcraft; `None` if it demands none.
    pub(crate) fn nose_rad(&self, position: Position) -> Option<f64> {
        match &self.stage {
            Stage::Follow(path) => path.nose_rad(position),
            _ => None,
        }
    }
}
