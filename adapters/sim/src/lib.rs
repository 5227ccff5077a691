//! The simulated world and vehicle behind [`apex_runtime::ports::Vehicle`].
//!
//! A point-mass fixed wing and helicopter in wind and turbulence, with a line scanner, cameras and radios. The simulation is
//! deterministic: the same configuration and the same commands at the same times give the same inputs. `docs/reference/simulator.md`
//! lists commands, events and state variables.

mod arguments;
mod atmosphere;
mod camera;
mod commands;
pub mod config;
mod fixed_wing;
mod flight;
mod follow;
mod following;
mod fork;
mod geodesic;
mod gliding;
mod gusts;
mod instants;
mod joining;
mod left_lines;
mod levelling;
mod line_start;
pub mod living;
mod motion;
mod names;
mod packet;
mod path;
mod payload;
mod phase;
mod port;
mod radio;
mod random;
mod reporting;
mod rotorcraft;
mod situation;
mod stages;
mod terrain;
mod turbulence;
mod way;
mod world;

pub use commands::command_forms;
pub use config::{Ground, GroundPatch, Happening, Modem, NamedPlace, ScheduledEvent, Start, WorldConfig};
pub use living::{BurnableSite, BurningTarget, FaultKind, FaultSpec, LivingWorld, WORLD_FORMAT};
pub use packet::{Pace, PublishedVariable, VARIABLES};
pub use world::SimulatedWorld;
