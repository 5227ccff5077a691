//! Targets of a mission: fires, structures, places to look at and to start from (docs/reference/mission-data.md).

use super::features::{self, NamedFeature};
use crate::error::MissionResult;
use crate::sources::DataFile;
use apex_metrics::tabulate::POINTS_MAX;
use apex_model::problem::{CostFunction, EventRate, Light, Position, TimeWindow};

const SQUARE_METRES_PER_ACRE: f64 = 4_046.856_422_4;

/// Something to observe, or a place with a name.
#[derive(Debug, Clone)]
pub struct Target {
    /// Its name in PDL.
    pub id: String,
    /// Its name for people.
    pub name: String,
    /// Its middle.
    pub position: Position,
    /// Ground above mean sea level.
    pub elevation_m: f64,
    /// Height of the thing itself above the ground.
    pub height_m: f64,
    /// Perimeters, largest first; empty for a point.
    pub polygons: Vec<Vec<Position>>,
    /// Not known before an event `(new-target ID)`.
    pub announced_late: bool,
    /// GeoJSON of its geometry.
    pub geometry: String,
    /// What it is.
    pub kind: TargetKind,
}

/// Kinds of targets.
#[derive(Debug, Clone)]
pub enum TargetKind {
    /// Observed once.
    Fire(Fire),
    /// Watched again and again.
    Site(Site),
    /// Something a camera may look at.
    Plain,
    /// A place to start from and land at.
    Base,
}

/// Wishes for the observation of a fire.
#[derive(Debug, Clone)]
pub struct Fire {
    /// Worth of a perfect observation.
    pub value: f64,
    /// Radius of the circle that stands for it where there is no perimeter.
    pub radius_m: f64,
    /// Wanted metres per pixel.
    pub resolution_m: f64,
    /// Only the perimeter must be seen.
    pub perimeter_only: bool,
    /// Share that is enough.
    pub share: f64,
    /// The observation must begin in one of these; empty is any time.
    pub windows: Vec<TimeWindow>,
    /// Light wanted.
    pub light: Light,
    /// Targets to be observed before it.
    pub after: Vec<String>,
}

/// What makes a structure worth a look.
#[derive(Debug, Clone)]
pub struct Site {
    /// Cost of an event that is never found, before its family makes a number of it.
    pub importance: f64,
    /// How long one look takes.
    pub dwell_s: f64,
    /// Likelihood of the event.
    pub rate: EventRate,
    /// Cost of not knowing.
    pub cost: CostFunction,
    /// Time since the last look when the mission starts.
    pub initial_age_s: f64,
}

impl Target {
    /// Worth of a perfect observation, or importance, for display.
    pub fn worth(&self) -> f64 {
        match &self.kind {
            TargetKind::Fire(fire) => fire.value,
            TargetKind::Site(site) => maximum(&site.cost),
            TargetKind::Plain | TargetKind::Base => 0.0,
        }
    }

    /// True for what is to be observed.
    pub fn is_observable(&self) -> bool {
        !matches!(self.kind, TargetKind::Base)
    }
}

fn maximum(cost: &CostFunction) -> f64 {
    match cost {
        CostFunction::Linear { cost_per_s } => cost_per_s * 3600.0,
        CostFunction::Saturating { maximum, .. }
        | CostFunction::Step { maximum, .. }
        | CostFunction::Logistic { maximum, .. } => *maximum,
        CostFunction::Table { points } => points.last().map_or(0.0, |(_, cost)| *cost),
        CostFunction::Delayed { cost, .. } => maximum(cost),
    }
}

/// Reads the targets' file.
///
/// # Errors
/// As docs/reference/mission-data.md lists them, each with file, feature and property.
pub(crate) fn read(file: &DataFile) -> MissionResult<Vec<Target>> {
    let features = features::read(file)?;
    let targets = features.iter().map(target).collect::<MissionResult<Vec<_>>>()?;
    for (feature, target) in features.iter().zip(&targets) {
        let TargetKind::Fire(fire) = &target.kind else { continue };
        let known = |name: &String| targets.iter().any(|other| other.id == *name);
        if let Some(unknown) = fire.after.iter().find(|name| !known(name)) {
            return Err(feature
                .trouble(format!("`after` names `{unknown}`, which is no target"))
                .help("name the `id` of another feature of this file"));
        }
    }
    Ok(targets)
}

fn target(feature: &NamedFeature) -> MissionResult<Target> {
    let polygons = feature.polygons()?;
    let kind = feature.word("kind", &["fire", "structure", "target", "base"])?;
    let kind = match kind.unwrap_or(if polygons.is_empty() { "target" } else { "fire" }) {
        "fire" => TargetKind::Fire(fire(feature, &polygons)?),
        "structure" => TargetKind::Site(site(feature)?),
        "base" => TargetKind::Base,
        _ => TargetKind::Plain,
    };
    Ok(Target {
        id: feature.id.clone(),
        name: feature.name.clone(),
        position: feature.position()?,
        elevation_m: feature.number("elevation_m", -500.0, 9_000.0)?.unwrap_or(0.0),
        announced_late: feature.word("announced", &["at-start", "by-event"])? == Some("by-event"),
        height_m: feature.number("height_m", 0.0, 9_000.0)?.unwrap_or(0.0),
        polygons,
        geometry: feature.geometry_text(),
        kind,
    })
}

fn fire(feature: &NamedFeature, polygons: &[Vec<Position>]) -> MissionResult<Fire> {
    let acres = feature.number("acres", f64::MIN_POSITIVE, 1e9)?;
    let area_m2 = match (acres, polygons.is_empty()) {
        (_, false) => polygons.iter().map(|ring| features::area_m2(ring)).sum(),
        (Some(acres), true) => acres * SQUARE_METRES_PER_ACRE,
        (None, true) => {
            return Err(feature
                .trouble("a fire that is a Point needs `acres`")
                .help("add `acres`, or draw its perimeter"));
        }
    };
    let light = match feature.word("light", &["any", "day", "night"])? {
        Some("day") => Light::Day,
        Some("night") => Light::Night,
        _ => Light::Any,
    };
    Ok(Fire {
        value: feature.number("value", 0.0, 1e9)?.unwrap_or(1.0),
        radius_m: (area_m2 / std::f64::consts::PI).sqrt(),
        resolution_m: feature.number("resolution_m", f64::MIN_POSITIVE, 1e6)?.unwrap_or(1e6),
        perimeter_only: feature.word("coverage", &["perimeter", "interior"])? == Some("perimeter"),
        share: feature.number("share", f64::MIN_POSITIVE, 1.0)?.unwrap_or(1.0),
        windows: feature.spans_s("windows_h")?,
        light,
        after: feature.texts("after")?,
    })
}

fn site(feature: &NamedFeature) -> MissionResult<Site> {
    let cost = cost(feature)?;
    let response_s = feature.number("response_s", 0.0, 1e7)?.unwrap_or(0.0);
    let cost = if response_s > 0.0 { CostFunction::Delayed { response_s, cost: Box::new(cost) } } else { cost };
    Ok(Site {
        importance: feature.number("importance", f64::MIN_POSITIVE, 1e9)?.unwrap_or(100.0),
        dwell_s: feature.number("dwell_s", f64::MIN_POSITIVE, 1e6)?.unwrap_or(30.0),
        rate: rate(feature)?,
        cost,
        initial_age_s: feature.number("initial_age_s", 0.0, 1e9)?.unwrap_or(0.0),
    })
}

/// `rate_per_h`, or `rates_per_h` where it changes.
fn rate(feature: &NamedFeature) -> MissionResult<EventRate> {
    const SECONDS_PER_HOUR: f64 = 3600.0;
    let wrong = |what: String| {
        feature
            .trouble(what)
            .help("write hours with events per hour, for example `\"rates_per_h\": [[0, 0.1], [12, 0.5]]`")
    };
    let steps = feature.pairs("rates_per_h")?;
    if steps.is_empty() {
        if feature.has("rates_per_h") {
            return Err(wrong("`rates_per_h` is empty".to_string()));
        }
        let events_per_h = feature.number("rate_per_h", 0.0, 1e6)?.unwrap_or(0.1);
        return Ok(EventRate::constant(events_per_h / SECONDS_PER_HOUR));
    }
    if feature.has("rate_per_h") {
        return Err(wrong("`rate_per_h` and `rates_per_h` say two things of one rate".to_string()));
    }
    if let Some((from_h, rate)) = steps.iter().find(|(from_h, rate)| !from_h.is_finite() || !(0.0..=1e6).contains(rate))
    {
        return Err(wrong(format!("`rates_per_h` has [{from_h}, {rate}]; rates are between 0 and 1e6 an hour")));
    }
    if let Some(((before_h, _), (from_h, _))) = steps.iter().zip(steps.iter().skip(1)).find(|(a, b)| b.0 <= a.0) {
        return Err(wrong(format!("`rates_per_h` has {from_h} h after {before_h} h; hours rise")));
    }
    let in_seconds = |(from_h, events_per_h): (f64, f64)| (from_h * SECONDS_PER_HOUR, events_per_h / SECONDS_PER_HOUR);
    Ok(EventRate { steps: steps.into_iter().map(in_seconds).collect() })
}

fn cost(feature: &NamedFeature) -> MissionResult<CostFunction> {
    let family = feature.word("cost", &["linear", "saturating", "step", "logistic", "table"])?.unwrap_or("saturating");
    if family == "table" {
        return cost_table(feature);
    }
    if feature.has("cost_points") {
        return Err(feature
            .trouble(format!("`cost_points` have no meaning where `cost` is {family}"))
            .help("write `\"cost\": \"table\"`, or leave `cost_points` out"));
    }
    let importance = feature.number("importance", f64::MIN_POSITIVE, 1e9)?.unwrap_or(100.0);
    let growth_per_s = feature.number("cost_growth_per_h", f64::MIN_POSITIVE, 1e6)?.unwrap_or(2.0) / 3600.0;
    let delay_s = feature.number("cost_delay_s", 0.0, 1e7)?.unwrap_or(600.0);
    Ok(match family {
        "linear" => CostFunction::Linear { cost_per_s: importance * growth_per_s },
        "step" => CostFunction::Step { deadline_s: delay_s, maximum: importance },
        "logistic" => CostFunction::Logistic { maximum: importance, rate_per_s: growth_per_s, midpoint_s: delay_s },
        _ => CostFunction::Saturating { maximum: importance, rate_per_s: growth_per_s },
    })
}

fn cost_table(feature: &NamedFeature) -> MissionResult<CostFunction> {
    const EXAMPLE: &str =
        "write ages in seconds with their costs, for example `\"cost_points\": [[0, 0], [600, 80], [3600, 100]]`";
    let idle = ["importance", "cost_growth_per_h", "cost_delay_s"].into_iter().find(|key| feature.has(key));
    if let Some(idle) = idle {
        return Err(feature
            .trouble(format!("`{idle}` has no meaning where `cost` is table"))
            .because("`cost_points` say what an event costs at every age")
            .help(format!("leave `{idle}` out")));
    }
    let points = feature.pairs("cost_points")?;
    if points.is_empty() || points.len() > POINTS_MAX {
        let many = format!("`cost` is table and `cost_points` are {}; they may be 1 to {POINTS_MAX}", points.len());
        return Err(feature.trouble(many).help(EXAMPLE));
    }
    let no_number = |(age_s, cost): &&(f64, f64)| !(0.0..=1e9).contains(age_s) || !(0.0..=1e9).contains(cost);
    if let Some((age_s, cost)) = points.iter().find(no_number) {
        let outside = format!("`cost_points` has [{age_s}, {cost}]; ages and costs are between 0 and 1e9");
        return Err(feature.trouble(outside).help(EXAMPLE));
    }
    for ((age_s, cost), (later_s, later)) in points.iter().zip(points.iter().skip(1)) {
        let reason = match () {
            () if later_s < age_s => "ages rise; two points of one age are a jump",
            () if later < cost => "cost never falls with age",
            () => continue,
        };
        let falls = format!("`cost_points` has [{later_s}, {later}] after [{age_s}, {cost}]");
        return Err(feature.trouble(falls).because(reason).help(EXAMPLE));
    }
    Ok(CostFunction::Table { points })
}
