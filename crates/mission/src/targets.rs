//! Targets of a mission: fires, structures, places to observe and to start from (docs/reference/mission-data.md).

mod costs;
mod looks;
mod order;
mod outline;

pub(crate) use looks::{LOOK_PROPERTIES, Terms};

use super::features::{self, NamedFeature};
use crate::error::MissionResult;
use crate::ground::MissionGround;
use crate::sources::DataFile;
use apex_geo::geodesy;
use apex_geo::terrain::Terrain;
use apex_metrics::tabulate::POINTS_MAX;
use apex_model::problem::{CostFunction, EventRate, Position};
use apex_observation::grid::{GridSettings, PLANNING_CELLS, TargetGrid};
use apex_observation::target::{ObservedTarget, Polygon, TargetArea, WantedLook};
use std::sync::Arc;

const SQUARE_METRES_PER_ACRE: f64 = 4_046.856_422_4;

/// Something to observe, or a place with a name.
#[derive(Debug, Clone)]
pub struct Target {
    /// Its name in PDL.
    pub id: String,
    /// Its name for operators.
    pub name: String,
    /// Its middle.
    pub position: Position,
    /// Ground above mean sea level.
    pub elevation_m: f64,
    /// Height of the structure above the ground.
    pub height_m: f64,
    /// Perimeters, largest first; empty for a point.
    pub polygons: Vec<Vec<Position>>,
    /// Not known before an event `(new-target ID)`.
    pub announced_late: bool,
    /// GeoJSON of its geometry.
    pub geometry: String,
    /// Kind.
    pub kind: TargetKind,
}

/// Kinds of targets.
#[derive(Debug, Clone)]
pub enum TargetKind {
    /// Observed once.
    Fire(Fire),
    /// Watched again and again.
    Site(Site),
    /// An object for a camera.
    Plain,
    /// A place to start from and land at.
    Base,
}

/// Wanted observation of a fire, or of a point, a line or an area for a camera.
#[derive(Debug, Clone)]
pub struct Fire {
    /// Radius of the circle that represents it if it has no perimeter.
    pub radius_m: f64,
    /// Its ground, and its wanted looks.
    pub wanted: ObservedTarget,
    /// Its ground divided into cells, which predictions count.
    pub(crate) grid: Arc<TargetGrid>,
    /// Terms of its pictures.
    pub(crate) pictures: PictureTerms,
}

/// Terms of a target's pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureTerms {
    /// The camera to use; `None` for the vehicle's default.
    pub camera: Option<String>,
    /// Share of a picture that the next picture of the line overlaps.
    pub overlap: f64,
    /// Share of a line's width that the next line sees, too.
    pub sidelap: f64,
    /// Number of pictures of a point; `None`: as many as required by the turbulence.
    pub count: Option<u32>,
}

impl Fire {
    /// Returns the value of perfect looks.
    pub fn value(&self) -> f64 {
        self.wanted.looks.iter().map(|look| look.value).sum()
    }

    /// Returns the wanted looks with their names in plans: the target's name if it has only one look, otherwise `TARGET/LOOK`.
    pub fn looks(&self) -> impl Iterator<Item = (String, &WantedLook)> {
        let alone = self.wanted.looks.len() == 1;
        let name = move |look: &WantedLook| match alone {
            true => self.wanted.name.clone(),
            false => format!("{}/{}", self.wanted.name, look.name),
        };
        self.wanted.looks.iter().map(move |look| (name(look), look))
    }

    /// Returns true if only the perimeter must be seen.
    pub fn perimeter_only(&self) -> bool {
        matches!(self.wanted.area, TargetArea::Perimeter { .. })
    }
}

/// A structure to observe.
#[derive(Debug, Clone)]
pub struct Site {
    /// Cost of an event that is never found, in points: it scales the cost families; a table states its costs itself.
    pub importance: f64,
    /// Duration of one look.
    pub dwell_s: f64,
    /// Likelihood of the event.
    pub rate: EventRate,
    /// Cost of not knowing.
    pub cost: CostFunction,
    /// Time since the last look when the mission starts.
    pub initial_age_s: f64,
    /// Wanted pixel size on the ground, m; a picture of twice that size has no value.
    pub resolution_m: f64,
}

impl Target {
    /// Returns the worth of a perfect observation, or the greatest cost of an event (of a linear cost, that after an hour), for display.
    pub fn worth(&self) -> f64 {
        match &self.kind {
            TargetKind::Fire(fire) => fire.value(),
            TargetKind::Site(site) => costs::maximum(&site.cost),
            TargetKind::Plain | TargetKind::Base => 0.0,
        }
    }

    /// Returns its name in plans, its name in reports, and its value: once, or for each of several wanted looks.
    pub fn plan_names(&self) -> Vec<(String, String, f64)> {
        match &self.kind {
            TargetKind::Fire(fire) if fire.wanted.looks.len() > 1 => {
                fire.looks().map(|(id, look)| (id, format!("{} {}", self.name, look.name), look.value)).collect()
            }
            _ => vec![(self.id.clone(), self.name.clone(), self.worth())],
        }
    }

    /// Returns true if this is its name or that of one of its wanted looks.
    pub fn goes_by(&self, name: &str) -> bool {
        let of_look = || match &self.kind {
            TargetKind::Fire(fire) => fire.looks().any(|(look, _)| look == name),
            TargetKind::Site(_) | TargetKind::Plain | TargetKind::Base => false,
        };
        self.id == name || of_look()
    }

    /// Returns true for a target that can be observed.
    pub fn is_observable(&self) -> bool {
        !matches!(self.kind, TargetKind::Base)
    }
}

/// Reads the targets' file of a mission on these terms.
///
/// # Errors
/// Errors as listed in docs/reference/mission-data.md, each with file, feature and property.
pub(crate) fn read(file: &DataFile, terms: Terms<'_>) -> MissionResult<Vec<Target>> {
    let features = features::read(file)?;
    let targets = features.iter().map(|feature| target(feature, terms)).collect::<MissionResult<Vec<_>>>()?;
    for (feature, target) in features.iter().zip(&targets) {
        let TargetKind::Fire(fire) = &target.kind else { continue };
        let unknown = fire.wanted.after.iter().find(|need| !targets.iter().any(|other| other.id == need.target));
        if let Some(unknown) = unknown {
            return Err(feature
                .trouble(format!("`after` names `{}`, which is not a target", unknown.target))
                .help("name the `id` of another feature of this file"));
        }
        let after = |id: &str| match targets.iter().find(|target| target.id == id).map(|target| &target.kind) {
            Some(TargetKind::Fire(fire)) => fire.wanted.after.iter().map(|need| need.target.clone()).collect(),
            _ => Vec::new(),
        };
        if let Some(circle) = order::circle(&feature.id, after) {
            let what = format!("`after` is a circle: {}", circle.join(" after "));
            return Err(feature
                .trouble(what)
                .help("remove one of these names: none of the targets could be the first"));
        }
    }
    Ok(targets)
}

fn target(feature: &NamedFeature, terms: Terms<'_>) -> MissionResult<Target> {
    let polygons = feature.polygons()?;
    let kind = feature.word("kind", &["fire", "inspection", "structure", "target", "base"])?;
    let is_line = !feature.line()?.is_empty();
    let usual = match (polygons.is_empty(), is_line) {
        (_, true) => "inspection",
        (true, false) => "target",
        (false, false) => "fire",
    };
    let kind = match kind.unwrap_or(usual) {
        "fire" if is_line => {
            return Err(feature
                .trouble("a fire cannot be a LineString")
                .help("draw its perimeter as a Polygon, or write `\"kind\": \"inspection\"`"));
        }
        "fire" => TargetKind::Fire(fire(feature, &polygons, terms)?),
        "inspection" => TargetKind::Fire(inspection(feature, &polygons, terms)?),
        "structure" => TargetKind::Site(site(feature)?),
        "base" => TargetKind::Base,
        _ => TargetKind::Plain,
    };
    Ok(Target {
        id: feature.id.clone(),
        name: feature.name.clone(),
        position: feature.position()?,
        elevation_m: feature.elevation_m(terms.terrain.map(Arc::as_ref))?,
        announced_late: feature.word("announced", &["at-start", "by-event"])? == Some("by-event"),
        height_m: feature.number("height_m", 0.0, 9_000.0)?.unwrap_or(0.0),
        polygons,
        geometry: feature.geometry_text(),
        kind,
    })
}

/// Width of the band along a perimeter where the mission states none.
const PERIMETER_WIDTH_M: f64 = 500.0;
/// Corners of the polygon that represents a circle.
const CIRCLE_CORNERS: u32 = 64;

fn fire(feature: &NamedFeature, polygons: &[Vec<Position>], terms: Terms<'_>) -> MissionResult<Fire> {
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
    let position = feature.position()?;
    let radius_m = libm::sqrt(area_m2 / std::f64::consts::PI);
    let wanted = ObservedTarget {
        name: feature.id.clone(),
        area: area(feature, polygons, position, radius_m)?,
        elevation_m: feature.elevation_m(terms.terrain.map(Arc::as_ref))?,
        is_water: feature.flag("water")?.unwrap_or(false),
        looks: looks::read(feature, position, terms)?,
        after: looks::after(feature)?,
    };
    if polygons.is_empty() {
        feature.covered(terms.terrain.map(Arc::as_ref), circle(position, radius_m))?;
    }
    Ok(Fire { radius_m, grid: grid(feature, &wanted, terms.terrain)?, wanted, pictures: picture_terms(feature)? })
}

fn grid(
    feature: &NamedFeature,
    wanted: &ObservedTarget,
    terrain: Option<&Arc<Terrain>>,
) -> MissionResult<Arc<TargetGrid>> {
    let settings = GridSettings { cells: PLANNING_CELLS, ..GridSettings::default() };
    let on_ground = |grid: TargetGrid| match terrain {
        None => grid,
        Some(terrain) => grid.with_elevations(&MissionGround::new(Some(Arc::clone(terrain)), wanted.elevation_m)),
    };
    TargetGrid::new(wanted, settings).map(on_ground).map(Arc::new).map_err(|error| {
        feature
            .trouble("its ground cannot be cut into cells")
            .because(error)
            .help("give the corners of each outline in order, each once; outlines do not overlap")
    })
}

/// Returns a point, a line or an area that a camera observes. A point is at the height of the structure.
fn inspection(feature: &NamedFeature, polygons: &[Vec<Position>], terms: Terms<'_>) -> MissionResult<Fire> {
    let position = feature.position()?;
    let line = feature.line()?;
    let (area, reach) = match (polygons.is_empty(), line.is_empty()) {
        (false, _) => {
            let reach: Vec<Position> = polygons.iter().flatten().copied().collect();
            (area(feature, polygons, position, 0.0)?, reach)
        }
        (true, false) => (TargetArea::Line(line.clone()), line),
        (true, true) => (TargetArea::Point(position), Vec::new()),
    };
    let height_m = feature.number("height_m", 0.0, 9_000.0)?.unwrap_or(0.0);
    let wanted = ObservedTarget {
        name: feature.id.clone(),
        area,
        elevation_m: feature.elevation_m(terms.terrain.map(Arc::as_ref))? + height_m,
        is_water: feature.flag("water")?.unwrap_or(false),
        looks: looks::read(feature, position, terms)?,
        after: looks::after(feature)?,
    };
    let radius_m = reach.iter().map(|place| geodesy::distance_m(position, *place)).fold(0.0, f64::max);
    Ok(Fire { radius_m, grid: grid(feature, &wanted, terms.terrain)?, wanted, pictures: picture_terms(feature)? })
}

/// Overlap of the pictures of a line, and of neighbouring lines, where the mission states none: enough to join the pictures.
const OVERLAP: f64 = 0.6;
const SIDELAP: f64 = 0.3;
/// Greatest overlap.
const OVERLAP_MAX: f64 = 0.95;

fn picture_terms(feature: &NamedFeature) -> MissionResult<PictureTerms> {
    Ok(PictureTerms {
        camera: feature.text("camera")?,
        overlap: feature.number("overlap", 0.0, OVERLAP_MAX)?.unwrap_or(OVERLAP),
        sidelap: feature.number("sidelap", 0.0, OVERLAP_MAX)?.unwrap_or(SIDELAP),
        count: feature.number("pictures", 1.0, 100.0)?.map(|count| libm::round(count) as u32),
    })
}

/// Returns the area of a fire to observe.
fn area(
    feature: &NamedFeature,
    polygons: &[Vec<Position>],
    centre: Position,
    radius_m: f64,
) -> MissionResult<TargetArea> {
    let width_m = feature.number("perimeter_width_m", f64::MIN_POSITIVE, 1e6)?;
    let interior_weight = feature.number("interior_weight", 0.0, 1.0)?;
    let outlines = |rings: &[Vec<Position>]| -> Vec<Polygon> {
        rings.iter().map(|ring| Polygon { outer: ring.clone(), holes: Vec::new() }).collect()
    };
    if feature.word("coverage", &["perimeter", "interior"])? == Some("perimeter") {
        let polygons = if polygons.is_empty() { vec![circle(centre, radius_m)] } else { polygons.to_vec() };
        return Ok(TargetArea::Perimeter {
            polygons: outlines(&polygons),
            half_width_m: 0.5 * width_m.unwrap_or(PERIMETER_WIDTH_M),
            interior_weight: interior_weight.unwrap_or(0.0),
        });
    }
    if let Some(idle) = ["perimeter_width_m", "interior_weight"].into_iter().find(|key| feature.has(key)) {
        return Err(feature
            .trouble(format!("`{idle}` has no meaning where `coverage` is interior"))
            .help("write `\"coverage\": \"perimeter\"`, or leave it out"));
    }
    Ok(match polygons.is_empty() {
        true => TargetArea::Circle { centre, radius_m },
        false => TargetArea::Polygons(outlines(polygons)),
    })
}

/// Returns the corners of the polygon that represents a circle.
fn circle(centre: Position, radius_m: f64) -> Vec<Position> {
    let corner = |number| geodesy::destination(centre, 360.0 * f64::from(number) / f64::from(CIRCLE_CORNERS), radius_m);
    (0..CIRCLE_CORNERS).map(corner).collect()
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
        resolution_m: feature.number("resolution_m", f64::MIN_POSITIVE, 1e6)?.unwrap_or(f64::INFINITY),
    })
}

/// Reads `rate_per_h`, or `rates_per_h` if the rate changes.
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
        return Err(wrong("`rate_per_h` and `rates_per_h` both state the rate".to_string()));
    }
    if let Some((from_h, rate)) = steps.iter().find(|(from_h, rate)| !from_h.is_finite() || !(0.0..=1e6).contains(rate))
    {
        return Err(wrong(format!("`rates_per_h` has [{from_h}, {rate}]; rates are between 0 and 1e6 per hour")));
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
            .because("`cost_points` state the cost of an event at every age")
            .help(format!("leave `{idle}` out")));
    }
    let points = feature.pairs("cost_points")?;
    if points.is_empty() || points.len() > POINTS_MAX {
        let many = format!("`cost` is table and `cost_points` has {} points; expected 1 to {POINTS_MAX}", points.len());
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
