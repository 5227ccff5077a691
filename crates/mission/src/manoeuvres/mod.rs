//! Ways to observe a wanted look, each with its predicted result: the planner chooses among them.

mod air_limits;
mod altitudes;
mod camera;
mod drafts;
mod flying;
mod growth;
mod open_spans;
mod partial;
mod picture_heights;
mod picture_runs;
mod scanner;
mod synthesised;
mod vantage;
mod wish;

pub(crate) use wish::Wish;

use crate::observing::carries_scanner;
use apex_model::problem::Manoeuvre;

/// Reasons for which no manoeuvre of library "manoeuvres" is a way to observe a look.
const SCANNER_ONLY: &str =
    "manoeuvres take pictures, and this look is made by the line scanner; `camera` names a camera";
const GROWTH_ONLY: &str = "the ground by which a fire has grown has no name in the program, which a manoeuvre needs";
/// Maximum number of manoeuvres of one look that planners get.
const MANOEUVRES_MAX: usize = 8;

/// Returns the ways to observe the look for which no other way is both faster and of higher value, the highest value first.
///
/// # Errors
/// If there is none: the reason, with the nearest possibility.
pub(crate) fn of(wish: &Wish<'_>) -> Result<Vec<Manoeuvre>, String> {
    let model = &wish.mission.model;
    match &wish.fire.pictures.camera {
        None if carries_scanner(model) => {
            let sweeps = scanner::sweeps(wish).map_err(|why| without_manoeuvres(wish, why, SCANNER_ONLY))?;
            let sweeps = best(sweeps, |sweep| &sweep.manoeuvre);
            Ok(sweeps.into_iter().map(|sweep| sweep.explained(wish)).collect())
        }
        _ => Ok(best(with_camera(wish)?, |manoeuvre| manoeuvre)),
    }
}

/// Returns the error of [`of`], or `None`: sooner than [`of`], because the ways are not compared.
pub(crate) fn trouble(wish: &Wish<'_>) -> Option<String> {
    match &wish.fire.pictures.camera {
        None if carries_scanner(&wish.mission.model) => {
            scanner::trouble(wish).map(|why| without_manoeuvres(wish, why, SCANNER_ONLY))
        }
        _ => with_camera(wish).err(),
    }
}

/// Returns pictures from vantage points and along lines and, if the program uses library "manoeuvres", its paths around and next to the
/// target.
fn with_camera(wish: &Wish<'_>) -> Result<Vec<Manoeuvre>, String> {
    let simple = camera::ways(wish);
    if wish.fire.grid.is_partial() {
        return simple.map_err(|why| without_manoeuvres(wish, why, GROWTH_ONLY));
    }
    if !synthesised::are_flown(wish.mission) {
        return simple;
    }
    let paths = camera::camera(wish).and_then(|camera| synthesised::alternatives(wish, &camera));
    match (simple, paths) {
        (Ok(simple), Ok(paths)) => Ok(simple.into_iter().chain(paths).collect()),
        (Ok(ways), Err(_)) | (Err(_), Ok(ways)) => Ok(ways),
        (Err(simple), Err(paths)) if simple == paths => Err(simple),
        (Err(simple), Err(paths)) => Err(format!("{simple}; by a manoeuvre: {paths}")),
    }
}

/// Returns the reason for which there is no other way, with the one for which no manoeuvre of library "manoeuvres" is a way, if the program
/// uses that library.
fn without_manoeuvres(wish: &Wish<'_>, why: String, more: &str) -> String {
    if synthesised::are_flown(wish.mission) { format!("{why}; by a manoeuvre: {more}") } else { why }
}

/// Returns the Pareto front of value and time, the highest value first; a long front is thinned evenly.
fn best<T>(mut made: Vec<T>, manoeuvre: impl Fn(&T) -> &Manoeuvre) -> Vec<T> {
    made.sort_by(|a, b| {
        let (a, b) = (manoeuvre(a), manoeuvre(b));
        let worth = b.quality.product().total_cmp(&a.quality.product());
        worth.then(a.duration_s.total_cmp(&b.duration_s))
    });
    let mut front: Vec<T> = Vec::new();
    for way in made {
        if front.last().is_none_or(|last| manoeuvre(&way).duration_s < manoeuvre(last).duration_s) {
            front.push(way);
        }
    }
    let count = front.len();
    if count <= MANOEUVRES_MAX {
        return front;
    }
    // The best and the fastest stay.
    let kept = |index: usize| (0..MANOEUVRES_MAX).any(|slot| slot * (count - 1) / (MANOEUVRES_MAX - 1) == index);
    front.into_iter().enumerate().filter(|(index, _)| kept(*index)).map(|(_, way)| way).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mission, Target, TargetKind};
    use apex_model::problem::{AirspaceZone, Position, TimeWindow, ZoneKind};

    /// Returns a zone that closes the air around a target for the whole mission.
    fn shut(target: &Target) -> AirspaceZone {
        let Position { latitude_deg, longitude_deg } = target.position;
        let corner =
            |(north_deg, east_deg): (f64, f64)| Position::new(latitude_deg + north_deg, longitude_deg + east_deg);
        AirspaceZone {
            name: "Z-1".to_string(),
            kind: ZoneKind::Restricted,
            corners: [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(corner).to_vec(),
            altitude_m_min: 0.0,
            altitude_m_max: 50_000.0,
            active: TimeWindow { from_s: 0.0, until_s: 1e9 },
        }
    }

    #[test]
    fn the_message_is_that_of_comparing_all_ways() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions");
        let (mut troubles, mut ways) = (Vec::new(), 0);
        for name in ["western-states", "stand-off"] {
            let mission = Mission::load(&folder.join(name)).unwrap();
            let every_sixth = || mission.targets.iter().step_by(6);
            for (target, change) in every_sixth().flat_map(|target| (0..3).map(move |change| (target, change))) {
                let TargetKind::Fire(fire) = &target.kind else { continue };
                let mut mission = mission.clone();
                let mut look = fire.wanted.looks[0].clone();
                match change {
                    0 => {}
                    1 => look.resolution.wanted_m *= 1e-3,
                    _ => mission.zones.push(shut(target)),
                }
                let (approach, is_explained) = (mission.start, false);
                let wish = Wish { mission: &mission, target, fire, look: &look, approach, from_s: 60.0, is_explained };
                let defined = of(&wish);
                ways += usize::from(defined.is_ok());
                assert_eq!(trouble(&wish), defined.err(), "{name}: {}, change {change}", target.id);
                troubles.extend(trouble(&wish));
            }
        }
        assert!(ways >= 3 && troubles.len() >= 3, "{ways} looks with a way, {troubles:?}");
    }
}
