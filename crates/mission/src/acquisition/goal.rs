//! Data-acquisition goals: `(acquire TARGET :product video :resolution 10cm :coverage 0.9 ..)`.

use super::data_mode::DataMode;
use super::form::keywords;
use super::vehicle::{elevation_m, target_of};
use crate::error::{MissionError, MissionResult};
use crate::{Mission, TargetKind};
use apex_geo::location::Location;
use apex_model::expression::Template;
use apex_model::problem::Position;
use apex_model::procedure::Activity;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_observation::grid::{GridSettings, PLANNING_CELLS, TargetGrid};
use apex_observation::manoeuvres::DataHandling;
use apex_observation::target::{LookAngles, ObservedTarget, TargetArea, WantedLook};
use apex_observation::timing::LightNeed;
use serde::Serialize;
use std::sync::Arc;

/// Keywords of a goal.
pub(crate) const KEYWORDS: [&str; 10] =
    ["product", "resolution", "coverage", "clarity", "look-angle", "light", "latency", "by", "with", "data"];
/// Points of a perfect look: factors are compared as percentages.
pub(super) const PERFECT_POINTS: f64 = 100.0;

/// Kind of recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ProductKind {
    /// Any suitable kind.
    Any,
    /// Single pictures.
    Stills,
    /// Video.
    Video,
    /// Lines of a scanner.
    Lines,
}

/// Goal of an acquisition.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AcquisitionGoal {
    /// The target as named in the goal: an id, or a location.
    pub(crate) named: Value,
    /// The target's geometry, with one wanted look.
    pub(crate) target: ObservedTarget,
    /// The target's ground in cells.
    pub(crate) grid: Arc<TargetGrid>,
    /// The middle of the target.
    pub(crate) position: Position,
    /// Greatest distance of the ground from the middle; 0 for a point.
    pub(crate) radius_m: f64,
    /// Kind of recording.
    pub(crate) product: ProductKind,
    /// Wanted metres per pixel; infinite if any resolution suffices.
    pub(crate) resolution_m: f64,
    /// Least share of the ground that must be covered, 0 to 1.
    pub(crate) coverage_min: f64,
    /// Least clarity, 0 to 1.
    pub(crate) clarity_min: f64,
    /// Wanted angles off the vertical.
    pub(crate) look_angle_deg: Option<(f64, f64)>,
    /// Wanted light.
    pub(crate) light: LightNeed,
    /// Greatest time in seconds from the end of the observation until the data are on the ground.
    pub(crate) latency_s: Option<f64>,
    /// Latest end, in seconds since the mission's start.
    pub(crate) by_s: Option<f64>,
    /// The sensor; `None` for any suitable one.
    pub(crate) sensor: Option<String>,
    /// Handling of the data; `None`: that of the mission.
    pub(crate) data: Option<DataMode>,
    /// The handling over the mission's downlink.
    pub(crate) handling: DataHandling,
}

/// Returns true for a goal of this kind.
pub(crate) fn is_goal(goal: &Value) -> bool {
    let head = goal.as_list().and_then(|items| items.first()).and_then(Value::as_symbol);
    head.is_some_and(|head| head.is("acquire"))
}

/// The value of a keyword, with a description of the expected type.
struct Field<'a> {
    key: &'static str,
    value: Option<&'a Value>,
}

impl Field<'_> {
    fn wrong<T>(&self, expected: &str) -> Result<T, String> {
        let value = self.value.map_or_else(|| "nothing".to_string(), Value::to_string);
        Err(format!("`:{}` of the goal is {value}; write {expected}", self.key))
    }

    fn number(&self, dimension: Dimension, expected: &str) -> Result<Option<f64>, String> {
        let Some(value) = self.value else { return Ok(None) };
        match value.as_number() {
            Some((number, found)) if found == dimension && number.is_finite() && number >= 0.0 => Ok(Some(number)),
            _ => self.wrong(expected),
        }
    }

    fn share(&self) -> Result<f64, String> {
        match self.number(Dimension::NONE, "a share from 0 to 1, such as 0.9")? {
            None => Ok(0.0),
            Some(share) if share <= 1.0 => Ok(share),
            Some(_) => self.wrong("a share from 0 to 1, such as 0.9"),
        }
    }

    fn word(&self) -> Option<String> {
        self.value.map(|value| value.to_string().to_lowercase())
    }

    fn angles(&self) -> Result<Option<(f64, f64)>, String> {
        let Some(value) = self.value else { return Ok(None) };
        let expected = "two angles off the vertical, such as (30deg 60deg)";
        let degrees = |value: &Value| match value.as_number()? {
            (rad, Dimension::ANGLE) => Some(rad.to_degrees()),
            (degrees, Dimension::NONE) => Some(degrees),
            _ => None,
        };
        match value.as_list() {
            Some([low, high]) => match (degrees(low), degrees(high)) {
                (Some(low), Some(high)) if 0.0 <= low && low <= high && high < 90.0 => Ok(Some((low, high))),
                _ => self.wrong(expected),
            },
            _ => self.wrong(expected),
        }
    }
}

impl AcquisitionGoal {
    /// Reads a goal.
    ///
    /// # Errors
    /// The unknown or wrongly typed keyword with the correct form, or the unknown target.
    pub(crate) fn read(mission: &Mission, goal: &Value) -> Result<AcquisitionGoal, String> {
        let items = goal.as_list().unwrap_or_default();
        let [_, named, rest @ ..] = items else {
            return Err("the goal names no target: write (acquire TARGET ..)".to_string());
        };
        let fields = keywords(rest, "the goal `acquire`")?;
        if let Some((stray, _)) = fields.iter().find(|(key, _)| !KEYWORDS.contains(&key.as_str())) {
            let shared = |key: &str| key.chars().zip(stray.chars()).take_while(|(a, b)| a == b).count();
            let near = KEYWORDS.iter().max_by_key(|key| shared(key)).filter(|key| shared(key) > 0);
            let near = near.map_or_else(String::new, |key| format!("did you mean `:{key}`? "));
            let known: Vec<String> = KEYWORDS.iter().map(|key| format!(":{key}")).collect();
            return Err(format!("the goal `acquire` has no keyword `:{stray}`; {near}it has {}", known.join(" ")));
        }
        let field = |key: &'static str| Field {
            key,
            value: fields.iter().find(|(name, _)| name == key).map(|(_, value)| *value),
        };
        let product = match field("product").word().as_deref() {
            None | Some("any") => ProductKind::Any,
            Some("stills") => ProductKind::Stills,
            Some("video") => ProductKind::Video,
            Some("lines") => ProductKind::Lines,
            Some(_) => return field("product").wrong("stills, video, lines or any"),
        };
        let data = field("data").value.map(|value| DataMode::read(value, "acquire")).transpose()?;
        let handling = data.map_or(Ok(DataHandling::Store), |data| data.over(mission.settings.downlink.as_ref()))?;
        let light = match field("light").word().as_deref() {
            None | Some("any") => LightNeed::Any,
            Some("day") => LightNeed::DAY,
            Some("night") => LightNeed::NIGHT,
            Some(_) => return field("light").wrong("day, night or any"),
        };
        let resolution = field("resolution").number(Dimension::LENGTH, "a length for one pixel, such as 10cm")?;
        if resolution == Some(0.0) {
            return field("resolution").wrong("a length greater than 0, such as 10cm");
        }
        let resolution_m = resolution.unwrap_or(f64::INFINITY);
        let look_angle_deg = field("look-angle").angles()?;
        let look = WantedLook {
            look_angles: look_angle_deg.map(|(min_deg, max_deg)| LookAngles { min_deg, max_deg, ramp_deg: 5.0 }),
            light,
            ..WantedLook::new("acquire", PERFECT_POINTS, resolution_m)
        };
        let (target, position) = observed(mission, named, look)?;
        let grid = grid_of(&target)?;
        let radius_m = match &target.area {
            TargetArea::Point(_) => 0.0,
            _ => grid.positions().map(|cell| apex_geo::geodesy::distance_m(position, cell)).fold(0.0, f64::max),
        };
        Ok(AcquisitionGoal {
            named: named.clone(),
            position,
            radius_m,
            target,
            grid: Arc::new(grid),
            product,
            resolution_m,
            coverage_min: field("coverage").share()?,
            clarity_min: field("clarity").share()?,
            look_angle_deg,
            light,
            latency_s: field("latency").number(Dimension::TIME, "a duration, such as 10min")?,
            by_s: field("by").number(Dimension::TIME, "a time since the mission's start, such as 30min")?,
            sensor: field("with").word(),
            data,
            handling,
        })
    }
}

impl AcquisitionGoal {
    /// Returns the same goal with other pixels; `None` if the ground cannot be divided into cells for them.
    pub(super) fn at_resolution(&self, resolution_m: f64) -> Option<AcquisitionGoal> {
        let pixels = WantedLook::new("acquire", PERFECT_POINTS, resolution_m).resolution;
        let mut target = self.target.clone();
        target.looks.iter_mut().for_each(|look| look.resolution = pixels);
        let grid = Arc::new(grid_of(&target).ok()?);
        Some(AcquisitionGoal { target, grid, resolution_m, ..self.clone() })
    }
}

/// Checks all goals `(acquire ..)` of the program that contain no variables.
///
/// # Errors
/// The first goal that cannot be read, with its place.
pub fn check_goals(mission: &Mission) -> MissionResult {
    for step in mission.library.procedures.iter().flat_map(|procedure| &procedure.steps) {
        let Activity::Goal(Template::Constant(goal)) = &step.activity else { continue };
        if is_goal(goal)
            && let Err(reason) = AcquisitionGoal::read(mission, goal)
        {
            return Err(MissionError::setting(format!("the goal {goal} cannot be pursued"))
                .at(mission.library.describe_place(step.place))
                .because(reason)
                .help("docs/reference/manoeuvres.md has the keywords of `acquire`"));
        }
    }
    Ok(())
}

/// Returns the cells of a target's ground.
fn grid_of(target: &ObservedTarget) -> Result<TargetGrid, String> {
    let settings = GridSettings { cells: PLANNING_CELLS / 4, ..GridSettings::default() };
    TargetGrid::new(target, settings).map_err(|error| error.to_string())
}

/// Returns the ground of a target: that of the mission's data, or a point.
fn observed(mission: &Mission, named: &Value, look: WantedLook) -> Result<(ObservedTarget, Position), String> {
    let point = |name: &str, position: Position, elevation_m: f64| ObservedTarget {
        name: name.to_string(),
        area: TargetArea::Point(position),
        elevation_m,
        is_water: false,
        looks: vec![look.clone()],
        after: Vec::new(),
    };
    let name = match named {
        Value::Symbol(symbol) => symbol.folded().to_string(),
        Value::Text(text) => text.to_lowercase(),
        _ => {
            let place = Location::of(named).map_err(|reason| format!("the target is {named}: {reason}"))?;
            let near = mission
                .targets
                .iter()
                .map(|target| (apex_geo::geodesy::distance_m(target.position, place.position), target.elevation_m));
            let ground_m =
                near.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(mission.start_altitude_m, |(_, ground_m)| ground_m);
            let elevation_m = place.altitude_m.unwrap_or(ground_m);
            return Ok((point(&named.to_string(), place.position, elevation_m), place.position));
        }
    };
    let target = target_of(mission, &name)?;
    let level_m = elevation_m(target);
    Ok(match &target.kind {
        TargetKind::Fire(fire) => {
            (ObservedTarget { looks: vec![look], after: Vec::new(), ..fire.wanted.clone() }, target.position)
        }
        _ => (point(&target.id, target.position, level_m), target.position),
    })
}
