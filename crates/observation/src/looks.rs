//! Looks that a target receives: passes, each with its seen cells and their geometry.
//!
//! Only measured properties are kept: geometry, time and weights of clarity. The value of a look for a wanted look is computed later
//! (`assess`), so that the same passes serve every wanted look. Bound: one entry per cell and pass, plus one for each look of the same
//! pass that is better in one respect and worse in another than the cell's last look, and one a minute where a sensor stares.

use crate::clarity::ClarityWeights;
use crate::footprint::{self, Ground};
use crate::grid::TargetGrid;
use crate::look_needs::LookNeeds;
use crate::plane::Point;
use crate::result::Remark;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Index of "no earlier look".
const NONE: u32 = u32::MAX;

/// One strip between two instants, or one picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StripFacts {
    /// Middle instant.
    pub time_s: f64,
    /// Weights of clarity.
    pub weights: ClarityWeights,
    /// True as flown: the weights are measured. False as predicted: roll and cloud are probabilities.
    pub is_flown: bool,
    /// Instant at which the image of the strip is on the ground, if the strip itself determines it.
    pub on_ground_s: Option<f64>,
}

/// One look's view of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellLook {
    /// Cell of the grid.
    pub cell: u32,
    /// Strip of the pass.
    pub strip: u32,
    /// Cosine of the look angle.
    pub look_cosine: f32,
    /// Size of a pixel on the ground across the plane of view (along the track of a scanner).
    pub pixel_along_m: f32,
    /// Size of a pixel on the ground in the plane of view (across the track of a scanner).
    pub pixel_across_m: f32,
    /// Weight of glint.
    pub glint: f32,
}

/// One pass: a span of time in which the sensor saw the target.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetPass {
    /// Its strips in order of time.
    pub strips: Vec<StripFacts>,
    /// Its looks.
    pub looks: Vec<CellLook>,
}

impl TargetPass {
    /// Returns the strip of a look.
    pub fn strip(&self, look: &CellLook) -> Option<&StripFacts> {
        self.strips.get(look.strip as usize)
    }

    /// Returns the first instant; `None` without strips.
    pub fn from_s(&self) -> Option<f64> {
        self.strips.first().map(|strip| strip.time_s)
    }
}

/// A polygon of ground that is seen in one strip or picture, with the vehicle's position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenGround<'a> {
    /// Corners on the plane of the target.
    pub polygon: &'a [Point],
    /// Ground point of the vehicle at the beginning and at the end.
    pub foot: [Point; 2],
    /// Altitude of the vehicle at the beginning and at the end.
    pub altitude_m: [f64; 2],
    /// Left and right end of the first scan line; `None` for a picture.
    pub first_line: Option<[Point; 2]>,
    /// Left end of the last scan line.
    pub last_left: Point,
    /// Angle of one pixel.
    pub pixel_rad: f64,
    /// Azimuth and zenith angle of the sun in degrees, where glint counts.
    pub sun: Option<(f64, f64)>,
}

impl SeenGround<'_> {
    /// Returns a function from a point to the share of the look, 0..1, that has passed when the point is seen.
    fn fraction(&self) -> impl Fn(Point) -> f64 {
        let (start, along, scale) = match self.first_line {
            None => (Point::default(), Point::default(), 0.0),
            Some([left, right]) => {
                let (line, advance) = (right.minus(left), self.last_left.minus(left));
                let squared = line.cross(advance);
                (left, line, if squared == 0.0 { 0.0 } else { 1.0 / squared })
            }
        };
        move |point: Point| (along.cross(point.minus(start)) * scale).clamp(0.0, 1.0)
    }
}

/// The looks that one target receives.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetLooks {
    /// Passes in order of time.
    pub passes: Vec<TargetPass>,
    /// Assumptions on which the looks rest.
    pub remarks: BTreeSet<Remark>,
    /// Number of cells of the grid that the looks belong to; 0 without passes.
    cells: usize,
    /// The last look of each cell in the last pass.
    last: Vec<u32>,
    /// Each strip or picture with a look whose clarity is above 0: its instant, and of such looks the one with the finest pixels.
    sightings: Vec<(f64, CellLook)>,
}

impl TargetLooks {
    /// Begins a pass; the preceding one is complete.
    pub fn begin_pass(&mut self, grid: &TargetGrid) {
        self.cells = grid.len();
        self.last.clear();
        self.last.resize(grid.len(), NONE);
        self.passes.push(TargetPass::default());
    }

    /// Drops data that only the recording of a pass needs. Further strips need [`TargetLooks::begin_pass`] first.
    pub fn end_pass(&mut self) {
        self.last = Vec::new();
    }

    /// Returns the number of looks that cells have received until now. Bound: O(passes).
    pub fn count(&self) -> usize {
        self.passes.iter().map(|pass| pass.looks.len()).sum()
    }

    /// Returns true if a pass is being recorded.
    pub fn is_recording(&self) -> bool {
        !self.last.is_empty()
    }

    /// Adds the ground of a strip or a picture to the last pass. Returns true if any cell was seen. `terrain` is checked for higher
    /// ground that hides cells; `None`: no ground hides cells.
    pub fn add(
        &mut self,
        grid: &TargetGrid,
        seen: &SeenGround<'_>,
        facts: StripFacts,
        terrain: Option<&dyn Ground>,
    ) -> bool {
        self.add_needed(grid, seen, facts, (terrain, None))
    }

    /// Like [`TargetLooks::add`]. A look replaces an earlier one of the same cell only if it serves the `needs` of the target as well.
    pub fn add_needed(
        &mut self,
        grid: &TargetGrid,
        seen: &SeenGround<'_>,
        facts: StripFacts,
        (terrain, needs): (Option<&dyn Ground>, Option<&LookNeeds<'_>>),
    ) -> bool {
        let Some(pass) = self.passes.last_mut() else { return false };
        let (fraction, strip) = (seen.fraction(), pass.strips.len() as u32);
        let [from, to] = seen.foot;
        let advance = to.minus(from);
        let [from_m, to_m] = seen.altitude_m;
        let plane = grid.plane();
        let last = &mut self.last;
        let looks = &mut pass.looks;
        let (mut is_seen, mut finest): (bool, Option<CellLook>) = (false, None);
        let new = NewStrip { facts: &facts, worth: worth(&facts.weights), needs };
        grid.rasterise(seen.polygon, |cell, middle| {
            let share = fraction(middle);
            let offset = middle.minus(from.plus(share, advance));
            let height_m = from_m + share * (to_m - from_m) - grid.elevation_m(cell);
            if height_m <= 0.0 {
                return;
            }
            let altitude_m = from_m + share * (to_m - from_m);
            if terrain.is_some_and(|ground| hides(grid, cell, middle, offset, altitude_m, ground)) {
                return;
            }
            let slant_m = libm::sqrt(offset.dot(offset) + height_m * height_m);
            let look = CellLook {
                cell: cell as u32,
                strip,
                look_cosine: (height_m / slant_m) as f32,
                pixel_along_m: (seen.pixel_rad * slant_m) as f32,
                pixel_across_m: (seen.pixel_rad * slant_m * slant_m / height_m) as f32,
                glint: seen.sun.map_or(1.0, |sun| glint(plane.east_north(offset), height_m, sun) as f32),
            };
            is_seen = true;
            let is_valid = new.worth * f64::from(look.glint) > 0.0;
            if is_valid && finest.is_none_or(|finest| look.pixel_across_m < finest.pixel_across_m) {
                finest = Some(look);
            }
            new.keep(&pass.strips, (looks, last), look);
        });
        self.sightings.extend(finest.map(|look| (facts.time_s, look)));
        if is_seen {
            pass.strips.push(facts);
        }
        is_seen
    }

    /// Returns true if the looks belong to a grid with as many cells as `grid`, or if there are no looks.
    pub fn fits(&self, grid: &TargetGrid) -> bool {
        self.cells == 0 || self.cells == grid.len()
    }

    /// Returns the same looks on another grid of the target: each of its cells was seen as the nearest cell of `from` was.
    pub fn on_grid(&self, from: &TargetGrid, to: &TargetGrid) -> TargetLooks {
        let nearest: Vec<Option<usize>> = to.centres().map(|(x, y)| from.nearest_cell(Point { x, y })).collect();
        let mut by_cell: Vec<Vec<u32>> = vec![Vec::new(); from.len()];
        let passes = self.passes.iter().map(|pass| {
            by_cell.iter_mut().for_each(Vec::clear);
            for (index, look) in pass.looks.iter().enumerate() {
                if let Some(all) = by_cell.get_mut(look.cell as usize) {
                    all.push(index as u32);
                }
            }
            let of_cell = |(cell, nearest): (usize, &Option<usize>)| {
                let all = nearest.and_then(|nearest| by_cell.get(nearest)).map_or(&[][..], Vec::as_slice);
                let looks: Vec<CellLook> = all
                    .iter()
                    .filter_map(|index| pass.looks.get(*index as usize))
                    .map(|look| CellLook { cell: cell as u32, ..*look })
                    .collect();
                looks
            };
            let looks = nearest.iter().enumerate().flat_map(of_cell).collect();
            TargetPass { strips: pass.strips.clone(), looks }
        });
        let passes = passes.collect();
        let (remarks, sightings) = (self.remarks.clone(), self.sightings.clone());
        TargetLooks { passes, remarks, cells: to.len(), last: Vec::new(), sightings }
    }

    /// Returns the first instant of a look with a clarity above 0 (a valid look); `None` without such a look.
    pub fn first_valid_s(&self) -> Option<f64> {
        self.sightings.iter().map(|(time_s, _)| *time_s).reduce(f64::min)
    }

    /// Returns a look with a clarity above 0 of each strip or picture that has one, with its instant in seconds.
    pub(crate) fn valid(&self) -> impl Iterator<Item = (&CellLook, f64)> {
        self.sightings.iter().map(|(time_s, look)| (look, *time_s))
    }
}

/// Returns the clarity of a strip without glint.
fn worth(weights: &ClarityWeights) -> f64 {
    weights.roll * weights.steady() * weights.clear_share
}

/// The strip or picture whose looks are added: it follows the strips of its pass.
struct NewStrip<'a> {
    facts: &'a StripFacts,
    /// Its clarity without glint.
    worth: f64,
    needs: Option<&'a LookNeeds<'a>>,
}

impl NewStrip<'_> {
    /// Adds a look of the strip, unless the last look of the same cell is at least as good in every respect; replaces that look if the
    /// new one is at least as good. Of predicted looks, the better one by the needs is kept alone: they succeed or fail together.
    fn keep(&self, strips: &[StripFacts], (looks, last): (&mut Vec<CellLook>, &mut [u32]), look: CellLook) {
        let Some(latest) = last.get_mut(look.cell as usize) else { return };
        let Some(earlier) = looks.get_mut(*latest as usize) else {
            *latest = looks.len() as u32;
            looks.push(look);
            return;
        };
        // An earlier look may be of the same strip, which is added after its looks.
        let earlier_facts = strips.get(earlier.strip as usize).unwrap_or(self.facts);
        let (new, old) = (self.worth * f64::from(look.glint), worth(&earlier_facts.weights) * f64::from(earlier.glint));
        let finer = look.pixel_across_m <= earlier.pixel_across_m && look.pixel_along_m <= earlier.pixel_along_m;
        let coarser = look.pixel_across_m >= earlier.pixel_across_m && look.pixel_along_m >= earlier.pixel_along_m;
        let (is_beaten, is_better) = (new <= old && coarser, new >= old && finer);
        let is_flown = self.facts.is_flown;
        let (this, that) = ((look.look_cosine, self.facts.time_s), (earlier.look_cosine, earlier_facts.time_s));
        let covers = |kept, other| self.needs.is_none_or(|needs| needs.covers(kept, other, is_flown));
        if is_beaten && covers(that, this) {
            return;
        }
        let replaces = is_better && covers(this, that);
        if replaces || (!is_flown && (is_beaten || is_better)) {
            if replaces || is_beaten {
                *earlier = look;
            }
            return;
        }
        *latest = looks.len() as u32;
        looks.push(look);
    }
}

fn hides(grid: &TargetGrid, cell: usize, middle: Point, offset: Point, altitude_m: f64, ground: &dyn Ground) -> bool {
    let position = grid.plane().position(middle);
    let (east_m, north_m) = grid.plane().east_north(offset);
    footprint::is_occluded(position, grid.elevation_m(cell), -north_m, -east_m, altitude_m, ground)
}

/// Returns the glint weight of a cell at this offset east and north of the vehicle.
fn glint((east_m, north_m): (f64, f64), height_m: f64, (azimuth_deg, zenith_deg): (f64, f64)) -> f64 {
    use crate::timing::sun::{glint_angle_deg, glint_weight};
    use apex_geo::geodesy::RAD_PER_DEG;
    let view_zenith_deg = libm::atan2(libm::hypot(east_m, north_m), height_m) / RAD_PER_DEG;
    // Azimuth of the vehicle as seen from the cell.
    let vehicle_deg = libm::atan2(-east_m, -north_m) / RAD_PER_DEG;
    glint_weight(glint_angle_deg(zenith_deg, view_zenith_deg, vehicle_deg - azimuth_deg))
}
