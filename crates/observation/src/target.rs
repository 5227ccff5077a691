//! Targets, their areas and their wanted looks.

use crate::timing::{LatencyNeed, LightNeed, OverpassNeed, ValueSlope, WindowNeed};
use apex_model::problem::Position;
use serde::{Deserialize, Serialize};

/// Maximum number of wanted looks of one target.
pub const WANTED_LOOKS_MAX: usize = 6;

/// The ground that belongs to a target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TargetArea {
    /// One point.
    Point(Position),
    /// Everything within `radius_m` of `centre`.
    Circle {
        /// Middle.
        centre: Position,
        /// Radius, positive.
        radius_m: f64,
    },
    /// The ground along a line through these points; at least two.
    Line(Vec<Position>),
    /// The ground inside the polygons, which must not overlap.
    Polygons(Vec<Polygon>),
    /// The band along the edges of the polygons.
    Perimeter {
        /// The polygons.
        polygons: Vec<Polygon>,
        /// Half the width of the band; 250 m is usual.
        half_width_m: f64,
        /// Weight of the ground inside the polygons beyond the band, 0 (not wanted) to 1 (as the band).
        interior_weight: f64,
    },
}

/// A polygon with holes. Rings are not closed; their direction does not matter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Polygon {
    /// Corners of the outer ring, at least three.
    pub outer: Vec<Position>,
    /// Rings of holes inside the outer ring.
    pub holes: Vec<Vec<Position>>,
}

/// A target with everything its score depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservedTarget {
    /// Name, unique in the mission.
    pub name: String,
    /// Ground.
    pub area: TargetArea,
    /// Elevation of the ground above mean sea level, used where the terrain is unknown.
    pub elevation_m: f64,
    /// True where glint of the sun on water degrades reflective products.
    pub is_water: bool,
    /// Wanted looks, each with its own value. Empty: the target is not wanted and adds nothing.
    pub looks: Vec<WantedLook>,
    /// Targets that must be seen before this one.
    pub after: Vec<OrderNeed>,
}

/// One look that is wanted of a target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WantedLook {
    /// Name, unique in the target, for example `night`.
    pub name: String,
    /// v: points for a perfect look.
    pub value: f64,
    /// Wanted resolution.
    pub resolution: ResolutionNeed,
    /// Wanted share of the area, above 0 to 1: the best cells up to this share count.
    pub coverage_share: f64,
    /// Wanted look angles off the vertical; `None` for any.
    pub look_angles: Option<LookAngles>,
    /// Wanted light.
    pub light: LightNeed,
    /// Windows of time; the best one counts. Empty: any time.
    pub windows: Vec<WindowNeed>,
    /// Value that falls with time.
    pub slope: Option<ValueSlope>,
    /// Wanted passes of satellites.
    pub overpass: Option<OverpassNeed>,
    /// Wanted time until the image is on the ground.
    pub latency: Option<LatencyNeed>,
    /// Wanted time since the previous look that counts, for any wanted look of this target.
    pub interval: Option<IntervalNeed>,
    /// Cost of missing this look; `None` if only its value is lost.
    pub must: Option<MustTerm>,
    /// True if a pass that serves another wanted look may serve this one, too.
    pub may_share: bool,
}

impl WantedLook {
    /// Returns a look of value `value` at `wanted_m` per pixel (factor 0 from twice that on), at any time and in any light.
    pub fn new(name: &str, value: f64, wanted_m: f64) -> WantedLook {
        WantedLook {
            name: name.to_string(),
            value,
            resolution: ResolutionNeed { wanted_m, ..ResolutionNeed::default() },
            coverage_share: 1.0,
            look_angles: None,
            light: LightNeed::Any,
            windows: Vec::new(),
            slope: None,
            overpass: None,
            latency: None,
            interval: None,
            must: None,
            may_share: false,
        }
    }
}

/// Wanted resolution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResolutionNeed {
    /// Pixel size on the ground that is good enough; infinite: any.
    pub wanted_m: f64,
    /// Multiple of the wanted size at which the factor reaches 0, falling linearly; 1: no pixel may be larger.
    pub zero_multiple: f64,
    /// Pixel size that counts.
    pub measure: PixelMeasure,
}

impl Default for ResolutionNeed {
    fn default() -> ResolutionNeed {
        ResolutionNeed { wanted_m: f64::INFINITY, zero_multiple: 2.0, measure: PixelMeasure::WorstDirection }
    }
}

/// Size of a pixel on the ground that counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PixelMeasure {
    /// The larger pixel size of the two directions on the ground.
    #[default]
    WorstDirection,
    /// The geometric mean of both directions.
    GeometricMean,
}

/// Wanted look angles off the vertical. Outside, the factor falls linearly to 0 over `ramp_deg`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookAngles {
    /// Least look angle.
    pub min_deg: f64,
    /// Greatest look angle.
    pub max_deg: f64,
    /// Width of the ramps; 10 is usual.
    pub ramp_deg: f64,
}

/// Wanted time between two successive looks of the same cell that count: the need of the later look applies or, if it has none, that of
/// the earlier one. The first look has no predecessor, and its factor is 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IntervalNeed {
    /// Least time.
    pub min_s: f64,
    /// Greatest time; infinite: any.
    pub max_s: f64,
    /// Outside, the factor falls linearly to 0 over this time; 0: at once.
    pub ramp_s: f64,
}

/// A target that must be seen first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderNeed {
    /// Name of the target that must be seen first.
    pub target: String,
    /// Factor of looks before the first valid look of that target, 0..1.
    pub discount: f64,
}

/// A look that must not be missed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MustTerm {
    /// The look is missed if its product of factors is not above this.
    pub factor_min: f64,
    /// Cost of missing it, in the unit of costs of the mission.
    pub cost: f64,
}
