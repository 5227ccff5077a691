//! Growth of fires after they were seen: ground that is a separate target, for planners and for the score.
//!
//! A fire is judged by the outline that was known when the first of its ground was seen. When it is reported larger afterwards, the ground
//! outside of that outline becomes the target `FIRE/growth-1`, with the share of the fire's value that this ground has in the reported
//! area. Until it is seen it follows the reports; what is reported after that becomes `FIRE/growth-2`.

use crate::features::area_m2;
use crate::{Mission, Target, TargetKind};
use apex_model::problem::Position;
use apex_observation::footprint::Ground;
use apex_observation::grid::{GridSettings, PLANNING_CELLS, TargetGrid};
use apex_observation::growth::grown;
use apex_observation::target::ObservedTarget;
use std::sync::Arc;

/// Growth by a smaller share of the area than this is within the accuracy of outlines.
const SHARE_MIN: f64 = 0.01;

/// Ground by which a fire has grown.
#[derive(Clone, Debug)]
struct GrownPart {
    /// Id of the fire.
    fire: String,
    /// The ground as a target, with the values of the mission's data.
    target: Target,
    /// The outline outside of which the ground lies, and the one inside of which it lies.
    before: Vec<Position>,
    outline: Vec<Position>,
    /// Share of the ground in the area of the fire.
    share: f64,
}

/// Growth of all fires so far.
#[derive(Clone, Debug, Default)]
pub(super) struct GrowthLog {
    parts: Vec<GrownPart>,
}

impl GrowthLog {
    /// Takes the outline of a fire of which ground has been seen by its outline `first`. Returns the target that is new or has changed, as
    /// scored; `None` for an outline that cannot be divided into cells, and for less growth than outlines show.
    pub(super) fn take(
        &mut self,
        fire: &Target,
        (first, outline): (Vec<Position>, Vec<Position>),
        is_seen: impl Fn(&str) -> bool,
        ground: &dyn Ground,
    ) -> Option<ScoredGround> {
        let last = self.parts.iter().rposition(|part| part.fire == fire.id);
        let latest = last.and_then(|number| self.parts.get(number));
        let is_seen = latest.is_some_and(|part| is_seen(&part.target.id));
        let before = match latest {
            Some(part) if is_seen => part.outline.clone(),
            Some(part) => part.before.clone(),
            None => first,
        };
        let share = 1.0 - area_m2(&before) / area_m2(&outline);
        if share.is_nan() || share < SHARE_MIN {
            return None;
        }
        let count = self.parts.iter().filter(|part| part.fire == fire.id).count();
        let number = if latest.is_none() || is_seen { count + 1 } else { count };
        let (target, scored) = part_of(fire, number, (&before, &outline), (share, ground))?;
        let part = GrownPart { fire: fire.id.clone(), target, before, outline, share };
        match last.filter(|_| !is_seen).and_then(|number| self.parts.get_mut(number)) {
            Some(slot) => *slot = part,
            None => self.parts.push(part),
        }
        Some(scored)
    }

    /// Returns the mission with the growth of its fires as further targets, with their present values. The fires have the outlines by which
    /// they were seen.
    pub(super) fn with_growth(&self, mut mission: Mission) -> Mission {
        let terrain = mission.terrain.clone();
        for part in &self.parts {
            let is_first = self
                .parts
                .iter()
                .find(|other| other.fire == part.fire)
                .is_some_and(|first| first.target.id == part.target.id);
            let Some(fire) = mission.targets.iter_mut().find(|target| target.id == part.fire) else { continue };
            // The situation knows visits only: of a fire that was seen in passing it has taken the outline of the last report.
            if is_first && fire.outline().is_some_and(|outline| outline != part.before) {
                fire.grow(&part.before, terrain.as_ref());
            }
            let TargetKind::Fire(present) = &fire.kind else { continue };
            let mut target = part.target.clone();
            if let TargetKind::Fire(grown) = &mut target.kind {
                for (look, of_fire) in grown.wanted.looks.iter_mut().zip(&present.wanted.looks) {
                    look.value = part.share * of_fire.value;
                }
            }
            if mission.weak_reason(&part.fire).is_none() {
                mission.targets.push(target);
            }
        }
        mission
    }
}

/// A target with the grid on which it is scored.
pub(super) type ScoredGround = (ObservedTarget, TargetGrid);

/// Returns the ground between two outlines of a fire as its `number`th growth: as planned, and as scored. `None` if it cannot be divided
/// into cells.
fn part_of(
    fire: &Target,
    number: usize,
    (before, outline): (&[Position], &[Position]),
    (share, ground): (f64, &dyn Ground),
) -> Option<(Target, ScoredGround)> {
    let TargetKind::Fire(kind) = &fire.kind else { return None };
    let id = format!("{}/growth-{number}", fire.id);
    let part = |settings: GridSettings| {
        let area = fire.area_within(outline)?;
        grown(&kind.wanted, &id, (before, area), share, (settings, ground))
    };
    let scored = part(GridSettings::default())?;
    let (wanted, planned) = part(GridSettings { cells: PLANNING_CELLS, ..GridSettings::default() })?;
    let mut target = fire.clone();
    // The report of the larger outline announces it.
    target.announced_late = false;
    (target.id, target.name, target.polygons) =
        (id.clone(), format!("{} growth {number}", fire.name), vec![outline.to_vec()]);
    if let TargetKind::Fire(grown) = &mut target.kind {
        grown.radius_m = libm::sqrt(area_m2(outline) / std::f64::consts::PI);
        (grown.wanted, grown.grid) = (wanted, Arc::new(planned));
    }
    Some((target, scored))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::MissionGround;
    use std::path::Path;

    /// Returns the outline with all corners at a multiple of their distance from a middle.
    fn scaled(outline: &[Position], middle: Position, factor: f64) -> Vec<Position> {
        let moved = |at: f64, from: f64| from + factor * (at - from);
        let corner = |corner: &Position| {
            let latitude_deg = moved(corner.latitude_deg, middle.latitude_deg);
            Position { latitude_deg, longitude_deg: moved(corner.longitude_deg, middle.longitude_deg) }
        };
        outline.iter().map(corner).collect()
    }

    #[test]
    fn growth_follows_the_reports_until_it_is_seen() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states/living.pdl");
        let mission = Mission::load(&path).unwrap();
        let fire = mission.targets.iter().find(|target| target.id == "gw").unwrap();
        let first = fire.outline().unwrap();
        let wider = |factor: f64| scaled(&first, fire.position, factor);
        let (ground, mut log) = (MissionGround::new(None, 0.0), GrowthLog::default());
        let mut take = |factor: f64, is_seen: bool| {
            log.take(fire, (first.clone(), wider(factor)), |_| is_seen, &ground)
                .map(|(target, grid)| (target.name, grid.total()))
        };
        assert_eq!(take(1.001, false), None, "within the accuracy of outlines");
        let (name, area_m2) = take(1.1, false).unwrap();
        let (again, wider_m2) = take(1.2, false).unwrap();
        assert_eq!((name.as_str(), again.as_str()), ("gw/growth-1", "gw/growth-1"));
        let whole_m2 = area_m2 / (1.1 * 1.1 - 1.0);
        assert!((wider_m2 / whole_m2 - 0.44).abs() < 0.01, "{area_m2} {wider_m2}");
        let (later, later_m2) = take(1.3, true).unwrap();
        let late = Target { announced_late: true, ..fire.clone() };
        let ends = (first.as_slice(), wider(1.1));
        let (part, _) = part_of(&late, 1, (ends.0, &ends.1), (0.17, &ground)).unwrap();
        assert!(!part.announced_late, "the report of its fire's outline has announced it");
        assert!(later == "gw/growth-2" && (later_m2 / whole_m2 - 0.25).abs() < 0.01, "{later} {later_m2}");
        // The situation has taken a report about a fire that was seen in passing.
        let mut updated = mission.clone();
        let value =
            |mission: &Mission, id: &str| mission.targets.iter().find(|target| target.id == id).unwrap().worth();
        updated.targets.iter_mut().find(|target| target.id == "gw").unwrap().grow(&wider(1.2), None);
        let grown = log.with_growth(updated);
        assert_eq!(grown.targets.iter().find(|target| target.id == "gw").unwrap().outline(), Some(first.clone()));
        let share = value(&grown, "gw/growth-2") / value(&mission, "gw");
        assert!((share - 0.25 / 1.69).abs() < 1e-3, "{share}");
    }
}
