//! Joining a line with a fixed wing: a straight leg to the turn, the turn onto the line, and a level lead-in before the line begins.

use crate::flight::{ActiveOrder, Order, Progress, Stage};
use crate::motion::wrap_pi;
use crate::path::{Join, Line, bearing, join};
use crate::situation::Situation;
use apex_model::problem::Position;
use libm::cos;

/// Lines begin this many seconds after the turn onto them, so that the wings are level.
const LEAD_IN_S: f64 = 16.0;
/// Accuracy with which a line must be joined: distance across it in seconds at cruise speed, course (5 degrees), and bank. After a miss it
/// is joined again, up to the maximum number of attempts. `way-to-line` (`apex-mission`) sends no way to a vehicle within these limits.
const JOIN_ACROSS_S: f64 = 0.75;
/// The same where an interrupted line is resumed: the flight along it corrects the rest.
const RESUMED_ACROSS_S: f64 = 1.26;
/// Distance across a line within which a turn onto it ends, and within which a final approach is flown: the flight along it corrects the
/// rest, and nothing is observed there.
const TURNED_ACROSS_M: f64 = 120.0;
const JOIN_COURSE_RAD: f64 = 0.0873;
const JOIN_BANK_RAD: f64 = 0.05;
/// Accuracy of the course with which an interrupted line is resumed at once, because it corrects itself along the line within seconds,
/// whereas another join takes minutes.
const RESUMED_COURSE_RAD: f64 = 0.15;
const JOINS_MAX: u32 = 2;
/// Accuracy with which a path must end on a line: seconds at cruise speed, and course.
const LINED_UP_ACROSS_S: f64 = 4.2;
/// The same for a final approach, which is long.
const LANDING_ACROSS_M: f64 = 400.0;
const LINED_UP_RAD: f64 = 0.35;
/// Distance to the turn below which the join is not planned again.
const REPLAN_M: f64 = 1_000.0;
/// A fixed wing has reached a place when it passes it no farther away than this.
const PLACE_M: f64 = 200.0;
/// Maximum number of misses of a place, after each of which a fixed wing turns back to it. One is enough in steady wind; a place
/// abeam of the start counts as missed before the first approach.
const MISSES_MAX: u32 = 4;
/// A vehicle already on a line may be so many seconds at cruise speed past its beginning: what it flies until the command reaches it.
/// Past the place at which an interrupted line was left, it may be farther: another join takes minutes.
const BEGUN_S: f64 = 1.0;
const RESUMED_S: f64 = 3.15;
/// A vehicle on the extension of a line continues along it from so many seconds before its beginning: the longest lead-in of plans.
const EXTENSION_S: f64 = 30.0;

/// Returns the distance that the vehicle flies in `seconds` at cruise speed in still air: tolerances grow with the size of a vehicle.
fn cruise_m(seconds: f64, here: &Situation) -> f64 {
    seconds * here.model.true_airspeed_m_s_cruise
}

/// Progress of an approach to a place.
#[derive(Clone, Debug, PartialEq)]
enum Approach {
    Coming,
    Reached,
    /// The limit of misses is reached; holds the reason.
    Missed(String),
}

impl ActiveOrder {
    /// Returns the first stage of a line: the line itself if the vehicle is already on it, otherwise a join.
    pub(crate) fn line_stage(&mut self, line: &Line, from: Position, here: &Situation) -> Stage {
        let (along_m, across_m, course_rad) = line.locate(here.state.position);
        let off_rad = wrap_pi(course_rad - here.state.track_rad()).abs();
        let lead_m = EXTENSION_S * here.ground_speed_max();
        let near = along_m > -lead_m
            && along_m <= self.begin_m + self.past_m(here).min(0.5 * line.length_m)
            && across_m.abs() <= self.across_m(here);
        // The path of the command has lined the vehicle up; joining again would leave the planned airspace.
        if here.fixed() && self.is_lined_up(line, here) {
            self.at_once = true;
            return Stage::LeadIn;
        }
        let is_resumed = self.begin_m > 0.0 && along_m > self.begin_m - lead_m;
        let accuracy_rad = if is_resumed { RESUMED_COURSE_RAD } else { JOIN_COURSE_RAD };
        if near && here.fixed() && off_rad <= accuracy_rad && here.at_altitude() {
            self.begin_m = self.begin_m.min(along_m.max(0.0));
            self.at_once = true;
            return Stage::LeadIn;
        }
        if here.fixed() {
            self.join_stage(line, here)
        } else {
            Stage::Direct(if self.begin_m > 0.0 { line.point(self.begin_m) } else { from })
        }
    }

    /// Returns true if the path of the command ended in the direction of the line, before the point at which it begins.
    pub(crate) fn is_lined_up(&self, line: &Line, here: &Situation) -> bool {
        let (along_m, across_m, course_rad) = line.locate(here.state.position);
        let off_rad = wrap_pi(course_rad - here.state.track_rad()).abs();
        self.way.is_some()
            && here.at_altitude()
            && along_m <= self.begin_m + self.past_m(here)
            && (across_m.abs() <= cruise_m(LINED_UP_ACROSS_S, here)
                || (self.is_landing() && across_m.abs() <= LANDING_ACROSS_M))
            && off_rad <= LINED_UP_RAD
    }

    /// Returns how far past the place at which its line begins the vehicle may be.
    fn past_m(&self, here: &Situation) -> f64 {
        cruise_m(if self.begin_m > 0.0 { RESUMED_S } else { BEGUN_S }, here)
    }

    /// Returns how far across its line the vehicle may be.
    fn across_m(&self, here: &Situation) -> f64 {
        if self.is_landing() {
            return TURNED_ACROSS_M;
        }
        cruise_m(if self.begin_m > 0.0 { RESUMED_ACROSS_S } else { JOIN_ACROSS_S }, here)
    }

    /// Plans another attempt to join the line.
    fn join_again(&mut self, line: &Line, here: &Situation) -> Stage {
        self.joins += 1;
        self.at_once = false;
        self.planned_straight = false;
        self.join_stage(line, here)
    }

    /// Plans the way onto the line from here.
    pub(crate) fn join_stage(&self, line: &Line, here: &Situation) -> Stage {
        let lead_m = LEAD_IN_S * here.ground_speed_max();
        Stage::Tangent(join(line, self.begin_m - lead_m, 1.1 * here.turn_radius_m(), here.state))
    }

    /// Returns true if a fixed wing is over a point, or abeam after a near miss.
    pub(crate) fn passed(&self, point: Position, distance_m: f64, here: &Situation) -> bool {
        let near_m = (0.6 * here.state.ground_speed()).max(40.0);
        let (azimuth_rad, _) = bearing(here.state.position, point);
        let behind = cos(azimuth_rad - here.state.track_rad()) < 0.0;
        distance_m < near_m || (behind && distance_m < 0.4 * here.turn_radius_m())
    }

    /// Flies straight to a point; once it is reached, returns the next stage or the answer of the order.
    pub(crate) fn direct(&mut self, point: Position, here: &Situation) -> Progress {
        let (_, distance_m) = bearing(here.state.position, point);
        let to_place = matches!(self.order, Order::FlyTo { .. });
        let arrived = match (here.fixed(), to_place) {
            (true, true) => match self.reach_place(point, distance_m, here) {
                Approach::Coming => false,
                Approach::Reached => true,
                Approach::Missed(reason) => return Progress::Failed(reason),
            },
            (true, false) => self.passed(point, distance_m, here),
            (false, _) => distance_m < 1.5 && here.state.ground_speed() < 0.6,
        };
        // A landing on the spot does not wait for a spot from which the wind carries the vehicle away.
        if !arrived && self.lands_here() && here.is_adrift() {
            return self.change(Some(Stage::Descend(here.state.position)), here);
        }
        if !arrived {
            return Progress::Going;
        }
        let next = match &self.order {
            Order::FlyTo { at_altitude, .. } if !at_altitude || here.at_altitude() => return self.done(here),
            Order::FlyTo { .. } if here.fixed() => Stage::Circle(here.circle(point, here.loiter_radius_m())),
            Order::FlyLine { .. } | Order::JoinLine { .. } if here.at_altitude() => Stage::OnLine,
            Order::Land { .. } => Stage::Descend(point),
            _ => Stage::Hover(point),
        };
        self.change(Some(next), here)
    }

    /// Returns the progress of a fixed wing towards a place. A place inside its turning circle cannot be reached by turning: the
    /// vehicle flies on and returns, at most [`MISSES_MAX`] times.
    fn reach_place(&mut self, place: Position, distance_m: f64, here: &Situation) -> Approach {
        let (azimuth_rad, _) = bearing(here.state.position, place);
        let behind = cos(azimuth_rad - here.state.track_rad()) < 0.0;
        if distance_m < (0.6 * here.state.ground_speed()).max(40.0) || (behind && distance_m <= PLACE_M) {
            return Approach::Reached;
        }
        let abeam = behind && distance_m < 2.0 * here.turn_radius_m();
        if !abeam {
            self.abeam = false;
            return Approach::Coming;
        }
        if std::mem::replace(&mut self.abeam, true) {
            return Approach::Coming;
        }
        self.misses += 1;
        if self.misses <= MISSES_MAX {
            return Approach::Coming;
        }
        let (misses, radius_m) = (self.misses, here.turn_radius_m());
        Approach::Missed(format!(
            "the place was passed {misses} times, last at {distance_m:.0} m, more than {PLACE_M:.0} m; \
             the turn radius is {radius_m:.0} m in this wind: fly slower, or circle it with loiter"
        ))
    }

    /// Flies straight towards the turn; returns the stage of the turn once it is reached.
    pub(crate) fn reach_turn(&mut self, join: Join, here: &Situation) -> Option<Stage> {
        let (azimuth_rad, distance_m) = bearing(here.state.position, join.tangent);
        if self.passed(join.tangent, distance_m, here) {
            return Some(Stage::Turn(join));
        }
        // The first turn moves the vehicle aside; once it flies straight, the join is planned again from there.
        let straight = wrap_pi(azimuth_rad - here.state.track_rad()).abs() < 0.05 && here.state.bank_rad.abs() < 0.05;
        if self.planned_straight || !straight || distance_m < REPLAN_M {
            return None;
        }
        self.planned_straight = true;
        Some(self.join_stage(&self.line.clone()?, here))
    }

    /// Flies the turn; returns the next stage once the course is close to that of the line.
    pub(crate) fn turned(&mut self, join: &Join, here: &Situation) -> Option<Stage> {
        let line = self.line.clone()?;
        let (along_m, across_m, course_rad) = line.locate(here.state.position);
        let sense = if join.turn.clockwise { 1.0 } else { -1.0 };
        let left_rad = wrap_pi(sense * (course_rad - here.state.track_rad()));
        let aside = across_m.abs() > 0.1 * join.turn.radius_m + TURNED_ACROSS_M;
        if left_rad.abs() > 0.12 || aside || !here.at_altitude() {
            return None;
        }
        // The vehicle is past the beginning of the line: join again, up to the maximum number of attempts.
        if along_m > self.begin_m && self.joins < JOINS_MAX {
            return Some(self.join_again(&line, here));
        }
        Some(Stage::LeadIn)
    }

    /// Flies along the extension of the line; returns the next stage at its beginning.
    pub(crate) fn led_in(&mut self, here: &Situation) -> Option<Stage> {
        let line = self.line.clone()?;
        let (along_m, across_m, course_rad) = line.locate(here.state.position);
        if along_m < self.begin_m {
            return None;
        }
        let off_rad = wrap_pi(course_rad - here.state.track_rad()).abs();
        let level = here.state.bank_rad.abs() <= JOIN_BANK_RAD;
        let good = level && across_m.abs() <= self.across_m(here) && off_rad <= JOIN_COURSE_RAD;
        // A line may be resumed at the beginning of a circle; levelling the wings on the line costs less than another join.
        if good || self.at_once || self.joins >= JOINS_MAX || !here.state.engine_running {
            return Some(Stage::OnLine);
        }
        Some(self.join_again(&line, here))
    }
}
