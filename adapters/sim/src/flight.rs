//! Execution of a flight command: its stages, the path, altitude and speed of each, and the event that ends it.

use crate::arguments::Spot;
use crate::fixed_wing::true_airspeed_min;
use crate::follow::FollowedPath;
use crate::gliding::Glide;
use crate::instants;
use crate::packet::location;
use crate::path::{Circle, Join, Line, Path, bearing};
use crate::phase::Phase;
use crate::situation::{Situation, final_approach};
use crate::way::Way;
use apex_model::effect::CommandId;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_vehicle::derived::LIFT_OFF_SPEED;

/// A command, or a behaviour that the vehicle starts on its own.
#[derive(Clone, Debug)]
pub(crate) enum Order {
    TakeOff {
        altitude_m: f64,
        /// Centre of the circle of the climb; `None`: where the vehicle is when it begins to turn.
        centre: Option<Position>,
    },
    FlyTo {
        to: Spot,
        at_altitude: bool,
    },
    FlyLine {
        from: Spot,
        to: Spot,
    },
    /// Like `FlyLine`, but answered at the beginning of the line.
    JoinLine {
        from: Spot,
        to: Spot,
    },
    Loiter {
        around: Spot,
        radius_m: f64,
        duration: Option<Duration>,
    },
    Hover {
        at: Option<Spot>,
        duration: Option<Duration>,
    },
    Land {
        at: Spot,
        /// Course of the final approach; `None`: into the wind.
        course_rad: Option<f64>,
        /// Elevation of the ground there.
        field_m: f64,
    },
    /// Follows a path of points; boxed because it is larger than the other variants.
    FollowPath(Box<FollowedPath>),
    /// No command: the vehicle circles or hovers at its position.
    Hold,
    /// The vehicle is parked on the ground.
    Parked,
}

/// Progress of an order.
#[derive(Clone, Debug)]
pub(crate) enum Stage {
    Parked,
    Run,
    ClimbOut,
    Climb(Circle),
    Rise(Position),
    /// Circles or hovers until the path of the command is open.
    Wait(Path),
    /// Flies along the path that the command contains.
    Way,
    Direct(Position),
    Tangent(Join),
    Turn(Join),
    LeadIn,
    OnLine,
    Follow(Box<FollowedPath>),
    Circle(Circle),
    Hover(Position),
    Descend(Position),
    /// Glides to a field without engine.
    Glide(Glide),
    RollOut,
}

/// The order that is being flown.
#[derive(Clone, Debug)]
pub(crate) struct ActiveOrder {
    pub(crate) command: Option<CommandId>,
    pub(crate) order: Order,
    pub(crate) stage: Stage,
    pub(crate) line: Option<Line>,
    pub(crate) way: Option<Way>,
    /// Distance along the line at which to begin; greater than zero for a line that is resumed.
    pub(crate) begin_m: f64,
    /// End of the time on station.
    pub(crate) until: Option<Time>,
    /// Distance to the end of the present stage.
    pub(crate) stage_m: f64,
    /// Distance to the order's goal.
    pub(crate) to_go_m: f64,
    pub(crate) joins: u32,
    /// True if the vehicle was already on the line when the line was commanded, so that no turn onto it was needed.
    pub(crate) at_once: bool,
    /// True if the join was planned again after the first turn.
    pub(crate) planned_straight: bool,
    /// Number of misses of the place of a fly-to, and whether the place has been behind the vehicle since.
    pub(crate) misses: u32,
    pub(crate) abeam: bool,
    /// Airspeed at the beginning of the line; `None` once it is commanded.
    pub(crate) line_speed: Option<f64>,
    line_s: f64,
    level_s: f64,
}

/// Result of one step of the flight.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Progress {
    Going,
    StageChanged,
    Done(Value),
    Failed(String),
}

impl ActiveOrder {
    /// Begins `order`.
    pub(crate) fn begin(command: Option<CommandId>, order: Order, here: &Situation) -> ActiveOrder {
        ActiveOrder::begin_at(command, order, 0.0, (None, None), here)
    }

    /// Begins `order`, along its path if it has one; a line is flown from `begin_m` after its beginning.
    pub(crate) fn begin_at(
        command: Option<CommandId>,
        order: Order,
        begin_m: f64,
        (way, hold): (Option<Way>, Option<(Duration, Option<Position>)>),
        here: &Situation,
    ) -> ActiveOrder {
        let mut flight = ActiveOrder {
            command,
            order,
            stage: Stage::Parked,
            line: None,
            way,
            begin_m,
            until: None,
            stage_m: f64::INFINITY,
            to_go_m: 0.0,
            joins: 0,
            at_once: false,
            planned_straight: false,
            misses: 0,
            abeam: false,
            line_speed: None,
            line_s: 0.0,
            level_s: 0.0,
        };
        flight.stage = match hold {
            Some((hold, around)) => {
                flight.until = Some(instants::not_before(here.now + hold));
                let circle = here.circle(around.unwrap_or(here.state.position), here.loiter_radius_m());
                Stage::Wait(if here.fixed() { Path::Circle(circle) } else { Path::Hover(here.stopping_place()) })
            }
            None => flight.leave(here),
        };
        flight.measure(here);
        flight
    }

    /// Returns the first stage of the path, or of the order itself if it has no path.
    fn leave(&mut self, here: &Situation) -> Stage {
        if self.way.is_some() { Stage::Way } else { self.first_stage(here) }
    }

    /// Waits at the position; returns the stage of the path once the path opens.
    fn wait(&mut self, here: &Situation) -> Option<Stage> {
        self.until.is_none_or(|until| here.now >= until).then(|| {
            self.until = None;
            self.way = self.way.take().and_then(|way| way.restarted(here));
            self.leave(here)
        })
    }

    /// Returns the stage with which the order itself begins.
    fn first_stage(&mut self, here: &Situation) -> Stage {
        match self.order.clone() {
            Order::TakeOff { .. } if here.fixed() => Stage::Run,
            Order::TakeOff { .. } => Stage::Rise(here.state.position),
            Order::FlyTo { to, .. } => Stage::Direct(to.position),
            Order::FlyLine { from, to } | Order::JoinLine { from, to } => {
                let line = Line::new(from.position, to.position);
                self.line = Some(line.clone());
                self.line_stage(&line, from.position, here)
            }
            Order::Loiter { around, radius_m, .. } => Stage::Circle(here.circle(around.position, radius_m)),
            Order::Hover { at, .. } => Stage::Hover(at.map_or_else(|| here.stopping_place(), |at| at.position)),
            Order::Land { at, course_rad, .. } if here.fixed() => {
                let line = final_approach(&at, course_rad, here);
                self.line = Some(line.clone());
                if self.is_lined_up(&line, here) { Stage::LeadIn } else { self.join_stage(&line, here) }
            }
            Order::Land { at, .. } => Stage::Direct(at.position),
            Order::FollowPath(path) => Stage::Follow(path),
            Order::Hold if here.fixed() => Stage::Circle(here.circle(here.state.position, here.loiter_radius_m())),
            Order::Hold => Stage::Hover(here.stopping_place()),
            Order::Parked => Stage::Parked,
        }
    }

    /// Flies along the path of the command; returns the first stage of the order at its end.
    fn on_way(&mut self, here: &Situation) -> Option<Stage> {
        if self.way.as_mut().is_some_and(|way| way.advance(here)) {
            self.measure(here);
            return None;
        }
        Some(self.first_stage(here))
    }

    /// Returns the path to follow now.
    pub(crate) fn path(&self, here: &Situation) -> Path {
        match &self.stage {
            Stage::Parked | Stage::Run | Stage::ClimbOut | Stage::RollOut => Path::Straight,
            Stage::Climb(circle) | Stage::Circle(circle) => Path::Circle(*circle),
            Stage::Rise(point) | Stage::Hover(point) | Stage::Descend(point) => Path::Hover(*point),
            Stage::Wait(path) => path.clone(),
            Stage::Way => self.way.as_ref().map_or(Path::Straight, Way::path),
            Stage::Direct(point) => Path::Point(*point),
            Stage::Tangent(join) => Path::Point(join.tangent),
            Stage::Turn(join) => Path::Circle(join.turn),
            Stage::LeadIn | Stage::OnLine => self.line.clone().map_or(Path::Straight, Path::Line),
            Stage::Follow(path) => path.path(here),
            Stage::Glide(glide) => glide.path(here),
        }
    }

    /// Returns altitude and speed: those of the stage, otherwise the commanded ones.
    pub(crate) fn profile(&self, here: &Situation) -> (f64, f64) {
        let slow = |share: f64| share * true_airspeed_min(here.model, here.state.altitude_m);
        let landing = matches!(self.order, Order::Land { .. });
        match &self.stage {
            Stage::ClimbOut => (here.altitude_m, slow(1.4)),
            // The path was planned through the airspace at its altitude, so a wait first climbs or descends to it.
            Stage::Wait(_) | Stage::Way => {
                let stated_m = self.way.as_ref().and_then(Way::altitude_m);
                (stated_m.unwrap_or(here.altitude_m), here.true_airspeed)
            }
            Stage::Follow(path) => {
                let airspeed = path.true_airspeed().unwrap_or(here.true_airspeed);
                (path.altitude_m(here).unwrap_or(here.altitude_m), airspeed)
            }
            Stage::Descend(_) => (here.ground_m - 5.0, here.true_airspeed),
            Stage::LeadIn | Stage::OnLine if landing => (self.glide_path_m(here), slow(1.3)),
            Stage::Turn(_) if landing => (here.altitude_m, slow(1.3)),
            Stage::Glide(glide) => (glide.altitude_m(here), here.true_airspeed),
            _ => (here.altitude_m, here.true_airspeed),
        }
    }

    /// Returns the speed to reach while the vehicle rolls on the ground; `None` in the air.
    pub(crate) fn ground_roll(&self) -> Option<f64> {
        match self.stage {
            Stage::Run => Some(f64::INFINITY),
            Stage::RollOut | Stage::Parked => Some(0.0),
            _ => None,
        }
    }

    /// Returns true if the vehicle may touch the ground now.
    pub(crate) fn is_touching_down(&self) -> bool {
        let landing = matches!(self.order, Order::Land { .. });
        landing && matches!(self.stage, Stage::OnLine | Stage::Descend(_) | Stage::Glide(_) | Stage::RollOut)
    }

    /// Returns true for a landing on the spot.
    pub(crate) fn lands_here(&self) -> bool {
        matches!(&self.order, Order::Land { at, .. } if at.given == Value::symbol("here"))
    }

    /// Returns true on a commanded line, whose answer states the share of level flight; false on a final approach.
    pub(crate) fn is_on_line(&self) -> bool {
        matches!((&self.stage, &self.order), (Stage::OnLine, Order::FlyLine { .. } | Order::JoinLine { .. }))
    }

    /// Returns true if the vehicle continues along its line after its answer.
    pub(crate) fn goes_on(&self) -> bool {
        matches!((&self.stage, &self.order), (Stage::OnLine, Order::JoinLine { .. })) && self.stage_m > 0.0
    }

    /// Returns the end of the time on station.
    pub(crate) fn deadline(&self) -> Option<Time> {
        self.until
    }

    /// Returns the value of `flight-phase`.
    pub(crate) fn phase(&self) -> Phase {
        let landing = matches!(self.order, Order::Land { .. });
        match &self.stage {
            Stage::Parked => Phase::Parked,
            Stage::Run => Phase::TakingOff,
            Stage::ClimbOut | Stage::Climb(_) | Stage::Rise(_) => Phase::Climbing,
            Stage::Way | Stage::Direct(_) | Stage::Tangent(_) | Stage::Turn(_) if landing => Phase::Approaching,
            Stage::Way | Stage::Direct(_) => Phase::EnRoute,
            Stage::LeadIn | Stage::OnLine if landing => Phase::Landing,
            Stage::Tangent(_) | Stage::Turn(_) | Stage::LeadIn => Phase::Joining,
            Stage::OnLine => Phase::Line,
            Stage::Follow(_) => Phase::Manoeuvring,
            Stage::Wait(Path::Hover(_)) => Phase::Hovering,
            Stage::Wait(_) | Stage::Circle(_) => Phase::Loitering,
            Stage::Hover(_) => Phase::Hovering,
            Stage::Descend(_) | Stage::Glide(_) | Stage::RollOut => Phase::Landing,
        }
    }

    /// Updates distances after a step of `dt` seconds, and begins the next stage if the present one is finished.
    pub(crate) fn progress(&mut self, here: &Situation, roll_rad_max: f64, dt: f64) -> Progress {
        self.measure(here);
        if let Some(glide) = self.glide(here) {
            return self.change(Some(glide), here);
        }
        // A rotorcraft in autorotation touches down short of the commanded place.
        if here.state.on_ground && !here.fixed() && self.is_landing() {
            return self.done(here);
        }
        let next = match self.stage.clone() {
            Stage::Parked => None,
            Stage::Glide(_) if here.state.on_ground => Some(Stage::RollOut),
            Stage::Glide(_) if here.state.engine_running => Some(self.first_stage(here)),
            Stage::Glide(glide) => glide.next(here).map(Stage::Glide),
            Stage::Run => {
                let fast =
                    here.state.true_airspeed >= LIFT_OFF_SPEED * true_airspeed_min(here.model, here.state.altitude_m);
                fast.then_some(Stage::ClimbOut)
            }
            Stage::ClimbOut | Stage::Climb(_) | Stage::Rise(_) => return self.climb(here),
            Stage::Wait(_) => self.wait(here),
            Stage::Way => self.on_way(here),
            Stage::Direct(point) => return self.direct(point, here),
            Stage::Tangent(join) => self.reach_turn(join, here),
            Stage::Turn(join) => self.turned(&join, here),
            Stage::LeadIn => return self.lead_in(here),
            Stage::OnLine => return self.on_line(here, roll_rad_max, dt),
            Stage::Follow(_) => return self.follow(here),
            Stage::Circle(_) | Stage::Hover(_) => return self.on_station(here),
            Stage::Descend(_) => return if here.state.on_ground { self.done(here) } else { Progress::Going },
            Stage::RollOut => return if here.state.true_airspeed < 0.3 { self.done(here) } else { Progress::Going },
        };
        self.change(next, here)
    }

    pub(crate) fn change(&mut self, next: Option<Stage>, here: &Situation) -> Progress {
        let Some(stage) = next else { return Progress::Going };
        self.stage = stage;
        self.measure(here);
        Progress::StageChanged
    }

    /// Returns the answer to the completed order.
    pub(crate) fn done(&self, here: &Situation) -> Progress {
        Progress::Done(match &self.order {
            Order::TakeOff { altitude_m, .. } => Value::measured(*altitude_m, Dimension::LENGTH),
            // The answer equals the location published at this instant, so that a condition can compare the two.
            Order::FlyTo { .. } => location(here.state),
            Order::JoinLine { from, .. } => from.given.clone(),
            Order::FlyLine { .. } => Value::Real(if self.line_s > 0.0 { self.level_s / self.line_s } else { 1.0 }),
            Order::Loiter { around, .. } => around.given.clone(),
            Order::FollowPath(_) => location(here.state),
            Order::Hover { at, .. } => at.as_ref().map_or_else(Value::nil, |at| at.given.clone()),
            Order::Land { at, .. } => at.given.clone(),
            Order::Hold | Order::Parked => Value::nil(),
        })
    }

    fn on_line(&mut self, here: &Situation, roll_rad_max: f64, dt: f64) -> Progress {
        self.line_s += dt;
        if here.state.roll_rad.abs() <= roll_rad_max {
            self.level_s += dt;
        }
        if matches!(self.order, Order::Land { .. }) {
            return self.change(here.state.on_ground.then_some(Stage::RollOut), here);
        }
        // Joining a line is answered at the line's beginning; then the vehicle follows the line until the next command.
        let joined = self.command.is_some() && matches!(self.order, Order::JoinLine { .. });
        if joined || self.stage_m <= 0.0 { self.done(here) } else { Progress::Going }
    }

    /// Computes the distances to the end of the stage and to the goal.
    fn measure(&mut self, here: &Situation) {
        let to = |point: Position| bearing(here.state.position, point).1;
        let along = || self.line.as_ref().map(|line| (line.locate(here.state.position).0, line.length_m, line.from));
        (self.stage_m, self.to_go_m) = match &self.stage {
            Stage::Way => self.way.as_ref().map_or((0.0, 0.0), |way| way.distances_m(here.state.position)),
            Stage::Direct(point) => (to(*point), to(*point)),
            Stage::Hover(point) => (f64::INFINITY, to(*point)),
            Stage::Tangent(join) => (to(join.tangent), along().map_or(0.0, |(_, _, from)| to(from))),
            Stage::Turn(_) => (f64::INFINITY, along().map_or(0.0, |(_, _, from)| to(from))),
            Stage::LeadIn => {
                along().map_or((0.0, 0.0), |(along_m, length_m, _)| (self.begin_m - along_m, length_m - along_m))
            }
            Stage::OnLine => {
                along().map_or((0.0, 0.0), |(along_m, length_m, _)| (length_m - along_m, length_m - along_m))
            }
            Stage::Follow(path) => path.distances_m(here.state.position),
            Stage::Circle(circle) => (f64::INFINITY, (to(circle.centre) - circle.radius_m).max(0.0)),
            Stage::Descend(_) | Stage::Glide(_) => (f64::INFINITY, here.state.altitude_m - here.ground_m),
            Stage::Parked
            | Stage::Run
            | Stage::ClimbOut
            | Stage::Climb(_)
            | Stage::Rise(_)
            | Stage::RollOut
            | Stage::Wait(_) => (f64::INFINITY, 0.0),
        };
    }
}
