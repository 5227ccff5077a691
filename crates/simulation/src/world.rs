//! The simulated world of a mission.

use apex_mission::error::{MissionError, MissionResult};
use apex_mission::{Mission, Target, TargetKind, WorldText};
use apex_runtime::input_lines::json_reason;
use apex_sim::{
    BurnableSite, BurningTarget, Ground, GroundPatch, LivingWorld, Modem, NamedPlace, SimulatedWorld, Start,
    WorldConfig,
};

/// Margin around every target's patch of ground, for the surroundings that aircraft see and turn over.
const PATCH_MARGIN_M: f64 = 10_000.0;
/// Radius of the ground at the elevation of the start, where no other ground is given.
const START_M: f64 = 1_000.0;
/// Levelled ground around an airfield on known terrain.
const FIELD_M: f64 = 300.0;

/// Makes the world that `mission` flies in, with `seed` or the mission's own.
///
/// # Errors
/// The error of the simulated world when something in the mission cannot be simulated, with the world's own message.
pub fn world(mission: &Mission, seed: Option<u64>) -> MissionResult<SimulatedWorld> {
    let start = Start::on_ground(
        mission.start.latitude_deg,
        mission.start.longitude_deg,
        mission.start_altitude_m,
        mission.settings.start_heading_deg,
    );
    let mut config = WorldConfig::new(mission.agent.name.printed(), mission.model.clone(), start);
    config.seed = seed.unwrap_or(mission.settings.seed);
    config.wind = mission.weather.clone();
    config.ground = ground(mission);
    config.modems = mission.modems.iter().map(modem).collect();
    config.places = places(mission);
    config.sites = sites(mission);
    config.burning = burning(mission);
    config.epoch_unix_s = mission.settings.epoch_unix_s;
    config.living = mission.world.as_ref().map(living).transpose()?;
    if let Some(world) = &mission.world {
        let late = || config.living.as_ref().map_or(Ok(()), |living| begins_in_time(living, mission));
        config.check_living().and_then(|()| late()).map_err(|reason| {
            MissionError::data(format!("{} is not a world of this mission", world.place))
                .because(reason)
                .help("docs/reference/world.md lists the fields with their units")
        })?;
    }
    SimulatedWorld::new(config)
        .map_err(|reason| MissionError::vehicle("the mission cannot be simulated").because(reason))
}

/// Checks that each stated failure begins before the mission ends: a later one has no effect.
fn begins_in_time(living: &LivingWorld, mission: &Mission) -> Result<(), String> {
    let end_s = mission.settings.duration.seconds();
    let late = living.faults.iter().enumerate().filter_map(|(index, fault)| Some((index, fault.at_s?)));
    match late.into_iter().find(|(_, at_s)| *at_s > end_s) {
        Some((index, at_s)) => Err(format!("faults[{index}]: at_s is {at_s}, and the mission ends at {end_s} s")),
        None => Ok(()),
    }
}

fn living(world: &WorldText) -> MissionResult<LivingWorld> {
    serde_json::from_str(&world.text).map_err(|error| {
        let (line, column) = (error.line(), error.column());
        let place = format!("{}:{line}:{column}", world.place);
        MissionError::data(format!("{} cannot be read as a world", world.place))
            .at(place)
            .because(json_reason(&error))
            .help("docs/reference/world.md lists the fields with their units")
    })
}

/// Returns the structures with the rates that the mission assumes at its start, which are the true rates in simulation.
fn sites(mission: &Mission) -> Vec<BurnableSite> {
    let site = |target: &Target| match &target.kind {
        TargetKind::Site(site) => Some(BurnableSite {
            name: target.id.clone(),
            position: target.position,
            rate: site.rate.clone(),
            initial_age_s: site.initial_age_s,
        }),
        TargetKind::Fire(_) | TargetKind::Plain | TargetKind::Base => None,
    };
    mission.targets.iter().filter_map(site).collect()
}

/// Returns the fires with the outline of their ground: that of the largest part, or the circle that represents a fire without outline.
fn burning(mission: &Mission) -> Vec<BurningTarget> {
    let fire = |target: &Target| {
        let outline = target.outline()?;
        Some(BurningTarget { name: target.id.clone(), middle: target.position, outline })
    };
    mission.targets.iter().filter_map(fire).collect()
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
    // Where the terrain is known, only airfields are levelled.
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
    // Later patches have precedence: below the start, the start's own patch must apply.
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
