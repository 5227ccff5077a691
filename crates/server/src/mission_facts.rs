//! Facts of a mission that the page needs next to its record.

use apex_mission::vehicle::Airframe;
use apex_mission::{Mission, Target, TargetKind};
use apex_model::time::Time;
use serde::Serialize;

/// Facts of the mission that the page needs in addition to its record, all from the mission's files.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct MissionFacts {
    /// `fixed-wing` or `rotorcraft`.
    #[cfg_attr(test, ts(type = "'fixed-wing' | 'rotorcraft'"))]
    kind: &'static str,
    /// Length of the mission as planned, nanoseconds.
    duration_ns: i64,
    /// Greatest distance from a landing place that the mission allows, metres; none if it states none.
    landing_distance_m_max: Option<f64>,
    /// Windows of the wanted looks of targets. The page shows those of known targets.
    windows: Vec<WantedWindow>,
}

/// A window in which an image of a target has its full worth.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct WantedWindow {
    target: String,
    look: String,
    from_ns: i64,
    to_ns: i64,
}

impl MissionFacts {
    /// Returns the facts of `mission`.
    pub(crate) fn of(mission: &Mission) -> MissionFacts {
        MissionFacts {
            kind: match mission.model.airframe {
                Airframe::FixedWing => "fixed-wing",
                Airframe::Rotorcraft => "rotorcraft",
            },
            duration_ns: mission.settings.duration.0,
            landing_distance_m_max: mission.requirements.landing_distance_m_max(),
            windows: mission.targets.iter().flat_map(windows_of).collect(),
        }
    }
}

fn windows_of(target: &Target) -> Vec<WantedWindow> {
    let TargetKind::Fire(fire) = &target.kind else { return Vec::new() };
    let looks = fire.wanted.looks.iter();
    let windows = looks.flat_map(|look| look.windows.iter().map(|window| (look.name.clone(), window)));
    let wanted = windows.map(|(look, window)| WantedWindow {
        target: target.id.clone(),
        look,
        from_ns: Time::from_seconds(window.from_s).0,
        to_ns: Time::from_seconds(window.until_s).0,
    });
    wanted.collect()
}
