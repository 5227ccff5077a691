//! Flights that the server itself runs: missions of one folder in the built-in simulator.
//!
//! `catalogue` lists the missions, `plans` plans one without flying it, `flight` is one flight on its own thread, `tower`
//! starts and stops flights, `routes` is the table of addresses. Records are written into one folder and never replaced.

mod catalogue;
mod flight;
mod plans;
mod request;
pub(crate) mod routes;
mod tower;

pub(crate) use catalogue::Failure;
pub(crate) use tower::Tower;

use crate::operation::ReadDatum;
use apex_mission::deliberation::PlanningResources;
use std::path::PathBuf;

/// Lets the server fly missions.
pub struct FlightOptions {
    /// Folder of the missions: each sub-folder with a `mission.pdl` is a mission with the name of the sub-folder.
    pub missions: PathBuf,
    /// Folder of the records that the flights write.
    pub records: PathBuf,
    /// Reads forms of PDL in messages and answers.
    pub read: ReadDatum,
    /// The planners, and the limits of their time and memory.
    pub means: PlanningResources,
}
