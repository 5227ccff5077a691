//! Avoidance of weak links: leaves out targets whose link is known or predicted to be weak, and makes weak areas restricted zones.
//!
//! Bound: O(cells + targets x losses); at most [`ZONES_MAX`] zones for each link.

use super::belief::{Belief, Beliefs};
use super::learned::{BAND_M, Learned, LinkCell};
use crate::vehicle::turn_radius_m;
use crate::visit_altitude::visit_altitude_m;
use crate::{Mission, Target, TargetKind};
use apex_geo::geodesy;
use apex_model::problem::{AirspaceZone, Position, TimeWindow, ZoneKind};
use apex_model::time::Time;
use std::collections::BTreeSet;

/// Maximum number of zones for one link; the largest are kept.
const ZONES_MAX: usize = 40;
/// Steps of the grid on which stated shadows are looked for, across the area of the mission.
const GRID_STEPS: i32 = 40;
/// Height above a weak cell up to which the air is avoided, too, m.
const ABOVE_M: f64 = 50.0;
/// Distance from the vehicle and the base, in circle radii, within which weak cells are ignored, so that the vehicle can leave both.
const CIRCLES: f64 = 2.5;
const ROOM_M: f64 = 20.0;

/// A rectangle of cells: first and last step north, first and last step east, band.
type Block = (i32, i32, i32, i32, i32);

/// Learned properties of a link, by its name.
pub(super) type Lookup<'a> = &'a dyn Fn(&str) -> Option<&'a Learned>;

/// Returns the mission adapted to the weak links that are known when the vehicle is `here`: zones are added, targets are left out.
pub(super) fn without_weak_links(mut mission: Mission, learned: Lookup<'_>, here: Position) -> Mission {
    let (mut zones, mut weak) = (Vec::new(), Vec::new());
    for link in &mission.link_map {
        let beliefs = Beliefs::new(&mission, link, learned(&link.name));
        for target in mission.targets.iter().filter(|target| target.is_observable()) {
            if weak.iter().all(|(known, _)| *known != target.id)
                && let Some(reason) = reason(&mission, &beliefs, target)
            {
                weak.push((target.id.clone(), reason));
            }
        }
        zones.extend(areas(&mission, &beliefs, &[here, mission.start]));
    }
    mission.zones.extend(zones);
    mission.weak_targets = weak;
    mission
}

/// Returns the reason for which a target is left out; `None` if its link is not known to be weak for longer than permitted.
fn reason(mission: &Mission, beliefs: &Beliefs<'_>, target: &Target) -> Option<String> {
    let (name, nominal) = (beliefs.name, beliefs.lost.nominal);
    let altitude_m = altitude_m(mission, target);
    let radius_m = match &target.kind {
        TargetKind::Fire(fire) => fire.radius_m,
        _ => 0.0,
    };
    if let Some(belief) = beliefs.weak_at(target.position, altitude_m)
        && exposure_s(mission, beliefs, target) > beliefs.lost.weak_for_s
    {
        return Some(match belief {
            Belief::Measured(level) => format!("the link over {name} is below {nominal} there: measured {level:.2}"),
            Belief::Shadow(level) => {
                format!(
                    "the link over {name} is assumed below {nominal} there: measured {level:.2} next to it, or above"
                )
            }
            Belief::Predicted(level, distance_m) => format!(
                "the link over {name} is below {nominal} there: predicted {level:.2}, {:.1} km from the station",
                distance_m / 1e3
            ),
        });
    }
    // A flight that led to a loss is not repeated, unless the link has been good there since.
    let is_good = matches!(beliefs.at(target.position, altitude_m), Some(Belief::Measured(level)) if level >= nominal);
    let losses = beliefs.learned.map_or(&[][..], |learned| &learned.losses);
    let on_the_way = |goal: Position| geodesy::distance_m(goal, target.position) <= radius_m + beliefs.cells.side_m;
    let loss = losses.iter().rev().find(|loss| loss.goal.is_some_and(on_the_way)).filter(|_| !is_good)?;
    let Position { latitude_deg, longitude_deg } = loss.here.position;
    Some(format!(
        "the link over {name} was lost on the way there at {}: measured {:.2} at ({latitude_deg:.5} {longitude_deg:.5})",
        Time::from_seconds(loss.at_s.round()),
        loss.level
    ))
}

/// Returns the time for which the vehicle is at the target: the observation, and the path across a cell.
fn exposure_s(mission: &Mission, beliefs: &Beliefs<'_>, target: &Target) -> f64 {
    let across_s = beliefs.cells.side_m / mission.model.true_airspeed_m_s_cruise;
    match &target.kind {
        TargetKind::Site(site) => site.dwell_s + across_s,
        _ => f64::INFINITY,
    }
}

fn altitude_m(mission: &Mission, target: &Target) -> f64 {
    match target.kind {
        TargetKind::Site(_) => visit_altitude_m(mission, target),
        _ => mission.cruise_altitude_m(),
    }
}

/// Returns the areas of weak links according to the mission's data and the flight, which flown paths avoid.
pub(super) fn weak_areas(mission: &Mission, learned: Lookup<'_>) -> Vec<AirspaceZone> {
    let beliefs = mission.link_map.iter().map(|link| Beliefs::new(mission, link, learned(&link.name)));
    beliefs.flat_map(|beliefs| areas(mission, &beliefs, &[])).collect()
}

/// Returns the areas where the link is weak, except around these places.
fn areas(mission: &Mission, beliefs: &Beliefs<'_>, places: &[Position]) -> Vec<AirspaceZone> {
    let mut weak: BTreeSet<LinkCell> = BTreeSet::new();
    let cells = beliefs.cells;
    for cell in beliefs.learned.iter().flat_map(|learned| learned.cells().keys()) {
        let (middle, altitude_m) = cells.middle(*cell);
        if beliefs.weak_at(middle, altitude_m).is_some() {
            weak.insert(*cell);
        }
    }
    weak.extend(beliefs.shaded());
    // The place to which the vehicle was flying when the link was lost counts as weak, unless the link was measured there.
    for loss in beliefs.learned.iter().flat_map(|learned| &learned.losses) {
        if let Some(goal) = loss.goal {
            let cell = cells.of(goal, loss.here.altitude_m);
            let (middle, altitude_m) = cells.middle(cell);
            if !matches!(beliefs.at(middle, altitude_m), Some(Belief::Measured(_))) {
                weak.insert(cell);
            }
        }
    }
    weak.extend(stated(mission, beliefs));
    let kept_m = CIRCLES * mission.model.turns.circle_width * turn_radius_m(&mission.model)
        + mission.requirements.zone_margin_m.min(mission.requirements.obstacle_margin_m)
        + ROOM_M;
    weak.retain(|(north, east, band)| {
        let block = (*north, *north, *east, *east, *band);
        places.iter().all(|place| away_m(&cells, &block, *place) > kept_m)
    });
    let mut zones: Vec<AirspaceZone> = blocks(&weak)
        .into_iter()
        .map(|(south, north, west, east, band)| AirspaceZone {
            name: format!("weak link over {}", beliefs.name),
            kind: ZoneKind::Restricted,
            corners: [(south, west), (south, east + 1), (north + 1, east + 1), (north + 1, west)]
                .map(|(north, east)| cells.corner(north, east))
                .to_vec(),
            altitude_m_min: 0.0,
            altitude_m_max: f64::from(band + 1) * BAND_M + ABOVE_M,
            active: TimeWindow::ALWAYS,
        })
        .collect();
    zones.truncate(ZONES_MAX);
    zones
}

/// Returns the cells in which the stated shadows make the link weak, on a grid over the mission's targets.
fn stated(mission: &Mission, beliefs: &Beliefs<'_>) -> BTreeSet<LinkCell> {
    let mut weak = BTreeSet::new();
    if beliefs.stated.is_none_or(|model| model.shadows.is_empty()) {
        return weak;
    }
    let observable = || mission.targets.iter().filter(|target| target.is_observable());
    let flown_m = observable().map(|target| altitude_m(mission, target)).fold(f64::NEG_INFINITY, f64::max);
    let found =
        observable().map(|target| target.position).chain([mission.start]).map(|place| beliefs.cells.of(place, flown_m));
    let Some((low, high)) = found.fold(None, |span: Option<(LinkCell, LinkCell)>, cell| {
        let (low, high) = span.unwrap_or((cell, cell));
        Some(((low.0.min(cell.0), low.1.min(cell.1), cell.2), (high.0.max(cell.0), high.1.max(cell.1), cell.2)))
    }) else {
        return weak;
    };
    // Large areas are inspected more coarsely: a step represents the cells up to the next.
    let step = ((high.0 - low.0).max(high.1 - low.1) / GRID_STEPS).max(1);
    let mut north = low.0 - step;
    while north <= high.0 + step {
        let mut east = low.1 - step;
        while east <= high.1 + step {
            let (middle, _) = beliefs.cells.middle((north, east, low.2));
            if beliefs.weak_at(middle, flown_m).is_some() {
                weak.extend((0..step).flat_map(|up| (0..step).map(move |right| (north + up, east + right, low.2))));
            }
            east += step;
        }
        north += step;
    }
    weak
}

/// Merges cells to rectangles, the largest first.
fn blocks(cells: &BTreeSet<LinkCell>) -> Vec<Block> {
    let mut runs: Vec<Block> = Vec::new();
    let mut ordered: Vec<LinkCell> = cells.iter().copied().collect();
    ordered.sort_by_key(|(north, east, band)| (*band, *north, *east));
    for (north, east, band) in ordered {
        match runs.last_mut() {
            Some((south, _, _, last, of)) if (*south, *last + 1, *of) == (north, east, band) => *last = east,
            _ => runs.push((north, north, east, east, band)),
        }
    }
    let mut merged: Vec<Block> = Vec::new();
    for (south, north, west, east, band) in runs {
        let below =
            merged.iter_mut().find(|block| (block.1 + 1, block.2, block.3, block.4) == (south, west, east, band));
        match below {
            Some(block) => block.1 = north,
            None => merged.push((south, north, west, east, band)),
        }
    }
    let area = |block: &Block| (block.1 - block.0 + 1) * (block.3 - block.2 + 1);
    merged.sort_by_key(|block| (-area(block), *block));
    merged
}

/// Returns the distance of a place from a rectangle, m; 0 inside.
fn away_m(cells: &super::learned::Cells, block: &Block, place: Position) -> f64 {
    let (north, east) = cells.steps(place);
    let off = |at: f64, low: i32, high: i32| (f64::from(low) - at).max(at - f64::from(high + 1)).max(0.0);
    cells.side_m * libm::hypot(off(north, block.0, block.1), off(east, block.2, block.3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_become_few_rectangles() {
        let square = (0..3).flat_map(|north| (0..4).map(move |east| (north, east, 0)));
        let cells: BTreeSet<LinkCell> = square.chain([(9, 9, 0), (0, 0, 1)]).collect();
        assert_eq!(blocks(&cells), [(0, 2, 0, 3, 0), (0, 0, 0, 0, 1), (9, 9, 9, 9, 0)]);
    }
}
