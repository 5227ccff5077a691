//! Beginning of a line: the step of flight that ends there, the answer of a join, and the airspeed that the vehicle has there.

use crate::flight::{ActiveOrder, Order, Progress, Stage};
use crate::path::{Line, bearing};
use crate::situation::Situation;
use crate::world::STEP_S;
use libm::{cos, sin};

/// Shortest step towards the beginning of a line.
const STEP_S_MIN: f64 = 0.02;

impl ActiveOrder {
    /// Returns the shortest step. The last one before a line ends at its beginning, so that sensors which are then switched on see all of
    /// the line.
    pub(crate) fn step_s_min(&self) -> f64 {
        let leads_in = matches!(self.stage, Stage::LeadIn) && self.ends().is_some();
        if leads_in { STEP_S_MIN } else { STEP_S }
    }

    /// Flies along the extension of the line. At the beginning, a join is answered, and the line is flown on.
    pub(crate) fn lead_in(&mut self, here: &Situation) -> Progress {
        let next = self.led_in(here);
        let is_join = self.command.is_some() && matches!(self.order, Order::JoinLine { .. });
        let is_joined = is_join && matches!(next, Some(Stage::OnLine));
        let progress = self.change(next, here);
        if is_joined { self.done(here) } else { progress }
    }

    /// Returns the airspeed of the line if its change must begin now to end at the beginning of the line.
    pub(crate) fn due_line_speed(&self, here: &Situation) -> Option<f64> {
        self.line_speed.filter(|_| self.line_speed_due_s(here) <= 0.0)
    }

    /// Returns the time until the vehicle must begin to change to the airspeed of its line; infinite if it need not, or waits or circles.
    pub(crate) fn line_speed_due_s(&self, here: &Situation) -> f64 {
        self.room_m(here).map_or(f64::INFINITY, |room_m| room_m / here.state.ground_speed().max(1.0))
    }

    /// Returns the distance before the place at which the change of airspeed must begin.
    fn room_m(&self, here: &Situation) -> Option<f64> {
        // A rotorcraft stops at the beginning, and could not come there against a wind that is stronger than the speed of its line.
        let speed = self.line_speed.filter(|_| here.fixed())?;
        let line = self.ends()?;
        let left_m = match &self.stage {
            Stage::OnLine => 0.0,
            Stage::LeadIn => self.stage_m,
            Stage::Direct(_) | Stage::Tangent(_) | Stage::Turn(_) => self.to_go_m,
            Stage::Way => self.to_go_m + self.way.as_ref()?.end().map_or(0.0, |end| bearing(end, line.from).1),
            _ => return None,
        };
        let (seconds, air_m) = here.model.speed_change(here.state.true_airspeed, speed);
        let tail = here.wind.north_mps * cos(line.azimuth_rad) + here.wind.east_mps * sin(line.azimuth_rad);
        Some(left_m - air_m - tail * seconds)
    }

    /// Returns the commanded line; `None` for other flights.
    fn ends(&self) -> Option<Line> {
        match &self.order {
            Order::FlyLine { from, to } | Order::JoinLine { from, to } => Some(Line::new(from.position, to.position)),
            _ => None,
        }
    }
}
