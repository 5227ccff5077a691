//! The simulated world of a mission.

use apex_mission::error::{MissionError, MissionResult};
use apex_mission::{Mission, Target, TargetKind};
use apex_sim::{Ground, GroundPatch, Modem, NamedPlace, SimulatedWorld, Start, WorldConfig};

/// Added around every target for its patch of ground: aircraft see and turn next to it.
const PATCH_MARGIN_M: f64 = 10_000.0;
/// Ground at the elevation of the start where there is no other.
const START_M: f64 = 1_000.0;
/// Levelled ground around an airfield on known terrain.
const FIELD_M: f64 = 300.0;
/// Heading of the parked vehicle.
const START_HEADING_DEG: f64 = 0.0;

/// Makes the world that `mission` flies in, with `seed` or the mission's own.
///
/// # Errors
/// The world's own sentence when something in the mission cannot be simulated.
pub fn world(mission: &Mission, seed: Option<u64>) -> MissionResult<SimulatedWorld> {
    let start = Start::on_ground(
        mission.start.latitude_deg,
        mission.start.longitude_deg,
        mission.start_altitude_m,
        START_HEADING_DEG,
    );
    let mut config = WorldConfig::new(mission.agent.name.printed(), mission.model.clone(), start);
    config.seed = seed.unwrap_or(mission.settings.seed);
    config.wind = mission.weather.clone();
    config.ground = ground(mission);
    config.modems = mission.modems.iter().map(modem).collect();
    config.places = places(mission);
    SimulatedWorld::new(config)
        .map_err(|reason| MissionError::vehicle("the mission cannot be simulated").because(reason))
}

fn modem(modem: &apex_mission::Modem) -> Modem {
    Modem {
        name: modem.name.clone(),
        level: modem.level.clone(),
        fading_db: modem.fading_db,
        dropouts_s: modem.dropouts_s.clone(),
    }
}

fn ground(mission: &Mission) -> Ground {
    let target_patch = |target: &Target| GroundPatch {
        position: target.position,
        radius_m: radius_m(target) + PATCH_MARGIN_M,
        elevation_m: target.elevation_m,
    };
    // Where the terrain is known, fields alone are levelled.
    let is_known = mission.terrain.is_some();
    let field_m = if is_known { FIELD_M } else { PATCH_MARGIN_M };
    let airfields = mission.airfields.iter().map(|airfield| GroundPatch {
        position: airfield.position,
        radius_m: field_m,
        elevation_m: airfield.elevation_m,
    });
    let targets = mission.targets.iter().filter(|_| !is_known).map(target_patch);
    let mut patches: Vec<GroundPatch> = targets.chain(airfields).collect();
    let start_m = if is_known { FIELD_M } else { START_M };
    // Later patches win: the start's own ground must be the one it stands on.
    patches.push(GroundPatch { position: mission.start, radius_m: start_m, elevation_m: mission.start_altitude_m });
    let lowest_m = patches.iter().map(|patch| patch.elevation_m).fold(mission.start_altitude_m, f64::min);
    Ground { elevation_m: lowest_m, patches, terrain: mission.terrain.clone() }
}

fn radius_m(target: &Target) -> f64 {
    match &target.kind {
        TargetKind::Fire(fire) => fire.radius_m,
        TargetKind::Site(_) | TargetKind::Plain | TargetKind::Base => 0.0,
    }
}

fn places(mission: &Mission) -> Vec<NamedPlace> {
    let airfields = mission.airfields.iter().map(|airfield| NamedPlace {
        name: airfield.id.clone(),
        position: airfield.position,
        altitude_m: Some(airfield.elevation_m),
    });
    let targets = mission.targets.iter().map(|target| NamedPlace {
        name: target.id.clone(),
        position: target.position,
        altitude_m: Some(target.elevation_m + target.height_m),
    });
    airfields.chain(targets).collect()
}
