//! Scores a `look` block: ground, wanted looks, lines of a scanner, costs. A `score` block is compared with the result.
//!
//! The lines of a scanner with pixels of 1.25 mrad and 43 degrees to either side are laid on the plane of the target. Attitude, terrain
//! and flying are ignored, so that a page shows the score alone. Lines of a `look` block:
//!
//! | line | is |
//! |---|---|
//! | `ground 10000 x 8000`, `ground ellipse 10000 x 8000` | west to east by south to north, in metres |
//! | `perimeter 500` | the band of this width along its edge is wanted, not the inside |
//! | `want NAME value 100 pixel 10`, `light night`, `window -4h..6h`, `ramp 1h`, `overpass 5h`, `latency 10min..60min` | a look |
//! | `line y 4000 height 6000`, `x 0..3000`, `clarity 0.98`, `at 5h`, `landed 14min` | a line from west to east; `y` from south |
//! | `line .. hidden yes`, `line .. cover 0.4` | clouds hid the line as flown; a line that is planned below this cover of clouds |
//! | `grown 12500 x 8000` | the ground grows to this size around its middle; lines below it have coordinates of the grown ground |
//! | `work 20h at 95`, `risk 0.002 share 0.9 cost 9000000`, `value-unit 100` | costs in money, and the money of a point |
//!
//! `at` is the instant at which a line is seen, and `landed` the time after it at which its image is on the ground. Times count from
//! midnight UTC of 8 September 2007 (17:00 PDT) near Zaca.

use apex_geo::geodesy::{Position, destination};
use apex_observation::assess::{AssessContext, assess};
use apex_observation::clarity::ClarityWeights;
use apex_observation::footprint::FlatGround;
use apex_observation::grid::{GridSettings, TargetGrid};
use apex_observation::growth::grown;
use apex_observation::looks::{SeenGround, StripFacts, TargetLooks};
use apex_observation::result::LookResult;
use apex_observation::score::{CostRow, CostTerm, mission_score};
use apex_observation::target::{ObservedTarget, Polygon, TargetArea, WantedLook};
use apex_observation::timing::{LatencyNeed, LightNeed, OverpassNeed, WindowNeed};
use std::collections::BTreeMap;
use std::fmt::Write;

const CENTRE: Position = Position::new(34.716, -119.783);
/// 2007-09-08T00:00:00Z.
const ZERO_UNIX_S: f64 = 1_189_209_600.0;
const HALF_FIELD_DEG: f64 = 43.0;
const PIXEL_RAD: f64 = 1.25e-3;
const ELLIPSE_CORNERS: u32 = 256;
/// A look counts in full up to the first time from a satellite's pass, and not at all from the second time on.
const OVERPASS_S: (f64, f64) = (1_800.0, 3_600.0);

/// A line of a scanner.
struct ScannedLine {
    y_m: f64,
    height_m: f64,
    x_m: Option<(f64, f64)>,
    clarity: f64,
    is_hidden: bool,
    /// Forecast cover of a line that is only planned.
    cover: Option<f64>,
    at_s: f64,
    landed_s: Option<f64>,
}

/// A `look` block as read.
#[derive(Default)]
struct Described {
    size_m: (f64, f64),
    is_ellipse: bool,
    perimeter_m: Option<f64>,
    looks: Vec<WantedLook>,
    lines: Vec<ScannedLine>,
    /// Size of the ground that has grown, and the number of lines before.
    grown: Option<((f64, f64), usize)>,
    costs: Vec<CostRow>,
    money_per_point: Option<f64>,
}

/// Returns the score of a `look` block: a line for each wanted look with its factors and points, then the costs.
///
/// # Errors
/// A line that cannot be read.
pub fn score(text: &str) -> Result<String, String> {
    let mut described = Described::default();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        described.take(&words).map_err(|reason| format!("`{line}`: {reason}"))?;
    }
    let mut told = String::new();
    let mut points = Vec::new();
    if !described.looks.is_empty() {
        for (name, look) in described.assessed()? {
            let factors = look.factors;
            let _ = writeln!(
                told,
                "{name}: coverage {:.4}, clarity {:.4}, resolution {:.4}, timing {:.4}: {:.1} points",
                factors.coverage, factors.clarity, factors.resolution, factors.timing, look.points
            );
            points.push(look.points);
        }
    }
    if !described.costs.is_empty() {
        let total = mission_score(&[], &described.costs, described.money_per_point.unwrap_or(1.0)).total;
        let _ = writeln!(told, "costs: {:.1} points", -total);
        let _ = writeln!(told, "score: {:.1} points", points.iter().sum::<f64>() + total);
    }
    Ok(told)
}

impl Described {
    fn take(&mut self, words: &[&str]) -> Result<(), String> {
        match words {
            ["ground", "ellipse", width, "x", depth] => {
                (self.size_m, self.is_ellipse) = ((number(width)?, number(depth)?), true);
            }
            ["ground", width, "x", depth] => self.size_m = (number(width)?, number(depth)?),
            ["grown", width, "x", depth] => {
                self.grown = Some(((number(width)?, number(depth)?), self.lines.len()));
            }
            ["perimeter", width] => self.perimeter_m = Some(number(width)?),
            ["want", name, rest @ ..] => self.looks.push(wanted(name, rest)?),
            ["line", rest @ ..] => self.lines.push(scanned(rest)?),
            ["work", hours, "at", wage] => {
                let term = CostTerm::Work { hours: seconds(hours)? / 3_600.0, wage_per_hour: number(wage)? };
                self.costs.push(CostRow { name: "work".to_string(), term });
            }
            ["risk", probability, "share", share, "cost", cost] => {
                let (probability, share, cost) = (number(probability)?, number(share)?, number(cost)?);
                let term = CostTerm::Risk { probability, share, cost };
                self.costs.push(CostRow { name: "risk".to_string(), term });
            }
            ["value-unit", money] => self.money_per_point = Some(number(money)?),
            _ => return Err("not a line of a `look` block; spec/src/observed.rs lists them".to_string()),
        }
        Ok(())
    }

    /// Returns the results of the looks by their names: first those of the original ground, then those of the added ground.
    fn assessed(&self) -> Result<Vec<(String, LookResult)>, String> {
        let target = self.target();
        let grid = TargetGrid::new(&target, GridSettings::default()).map_err(|error| error.to_string())?;
        // Lines above the growth have the coordinates of the ground as it was.
        let lines = |from: usize, offset_m: (f64, f64)| {
            self.lines.iter().enumerate().skip(from).map(move |(number, line)| {
                let is_later = self.grown.is_some_and(|(_, before)| number >= before);
                (line, if is_later { offset_m } else { (0.0, 0.0) })
            })
        };
        let Some((size_m, before)) = self.grown else {
            return Ok(named("", assessed(&target, &grid, self.size_m, lines(0, (0.0, 0.0)))));
        };
        let wider_m = (0.5 * (size_m.0 - self.size_m.0), 0.5 * (size_m.1 - self.size_m.1));
        let mut results = named("", assessed(&target, &grid, self.size_m, lines(0, wider_m)));
        let share = 1.0 - self.size_m.0 * self.size_m.1 / (size_m.0 * size_m.1);
        let outline = outline(self.size_m, self.is_ellipse);
        let area =
            Described { size_m, is_ellipse: self.is_ellipse, perimeter_m: self.perimeter_m, ..Described::default() }
                .area();
        let ground = FlatGround::default();
        let settings = (GridSettings::default(), &ground as &dyn apex_observation::footprint::Ground);
        if let Some((target, grid)) = grown(&target, "growth", (&outline, area), share, settings) {
            results.extend(named(" growth", assessed(&target, &grid, size_m, lines(before, (0.0, 0.0)))));
        }
        Ok(results)
    }

    fn target(&self) -> ObservedTarget {
        ObservedTarget {
            name: "target".to_string(),
            area: self.area(),
            elevation_m: 0.0,
            is_water: false,
            looks: self.looks.clone(),
            after: Vec::new(),
        }
    }

    fn area(&self) -> TargetArea {
        let polygons = vec![Polygon { outer: outline(self.size_m, self.is_ellipse), holes: Vec::new() }];
        match self.perimeter_m {
            Some(width_m) => TargetArea::Perimeter { polygons, half_width_m: 0.5 * width_m, interior_weight: 0.0 },
            None => TargetArea::Polygons(polygons),
        }
    }
}

/// Returns the corners of ground of this size around the middle.
fn outline((width_m, depth_m): (f64, f64), is_ellipse: bool) -> Vec<Position> {
    let (x_m, y_m) = (0.5 * width_m, 0.5 * depth_m);
    let corners: Vec<(f64, f64)> = if is_ellipse {
        let angle_rad = |number: u32| std::f64::consts::TAU * f64::from(number) / f64::from(ELLIPSE_CORNERS);
        (0..ELLIPSE_CORNERS)
            .map(|number| (x_m * libm::cos(angle_rad(number)), y_m * libm::sin(angle_rad(number))))
            .collect()
    } else {
        vec![(-x_m, -y_m), (x_m, -y_m), (x_m, y_m), (-x_m, y_m)]
    };
    let position = |(east_m, north_m): (f64, f64)| {
        let azimuth_deg = libm::atan2(east_m, north_m).to_degrees();
        destination(CENTRE, azimuth_deg, libm::hypot(east_m, north_m))
    };
    corners.into_iter().map(position).collect()
}

/// Returns the results with the names of their looks, each followed by `suffix`.
fn named(suffix: &str, results: Vec<LookResult>) -> Vec<(String, LookResult)> {
    results.into_iter().map(|result| (format!("{}{suffix}", result.name), result)).collect()
}

/// Returns the results of a target of this size after the lines, each moved east and north by an offset.
fn assessed<'a>(
    target: &ObservedTarget,
    grid: &TargetGrid,
    size_m: (f64, f64),
    lines: impl Iterator<Item = (&'a ScannedLine, (f64, f64))>,
) -> Vec<LookResult> {
    let mut looks = TargetLooks::default();
    for (line, offset_m) in lines {
        looks.begin_pass(grid);
        lay(grid, (size_m, offset_m), &mut looks, line);
    }
    looks.end_pass();
    let first_valid_s = BTreeMap::new();
    let context =
        AssessContext { zero_unix_s: ZERO_UNIX_S, products: &[], first_valid_s: &first_valid_s, is_explained: false };
    assess(target, grid, &[&looks], &context).looks
}

/// Lays the strip that a line sees on the grid of ground of this size; the line's coordinates begin this far west and south of it.
fn lay(
    grid: &TargetGrid,
    (size_m, (east_m, north_m)): ((f64, f64), (f64, f64)),
    looks: &mut TargetLooks,
    line: &ScannedLine,
) {
    let half_m = line.height_m * libm::tan(HALF_FIELD_DEG.to_radians());
    let (from_m, until_m) = line.x_m.unwrap_or((0.0, size_m.0 + 2.0 * east_m));
    // The plane's origin is the middle of the target.
    let at = |x_m: f64, y_m: f64| grid.plane().point(x_m - east_m - 0.5 * size_m.0, y_m - north_m - 0.5 * size_m.1);
    let (north_m, south_m) = (line.y_m + half_m, line.y_m - half_m);
    let polygon = [at(from_m, north_m), at(from_m, south_m), at(until_m, south_m), at(until_m, north_m)];
    let [first_left, first_right, _, last_left] = polygon;
    let seen = SeenGround {
        polygon: &polygon,
        foot: [at(from_m, line.y_m), at(until_m, line.y_m)],
        altitude_m: [line.height_m; 2],
        first_line: Some([first_left, first_right]),
        last_left,
        pixel_rad: PIXEL_RAD,
        sun: None,
    };
    let clear_share = if line.is_hidden { 0.0 } else { 1.0 - line.cover.unwrap_or(0.0) };
    let weights = ClarityWeights { rates: line.clarity, clear_share, ..ClarityWeights::CLEAR };
    let is_flown = line.cover.is_none();
    let on_ground_s = line.landed_s.map(|after_s| line.at_s + after_s);
    looks.add(grid, &seen, StripFacts { time_s: line.at_s, weights, is_flown, on_ground_s }, None);
}

fn wanted(name: &str, words: &[&str]) -> Result<WantedLook, String> {
    let mut look = WantedLook::new(name, 1.0, f64::INFINITY);
    let mut ramp_s = 0.0;
    for pair in words.chunks(2) {
        match pair {
            ["value", points] => look.value = number(points)?,
            ["pixel", metres] => look.resolution.wanted_m = number(metres)?,
            ["light", "night"] => look.light = LightNeed::NIGHT,
            ["light", "day"] => look.light = LightNeed::DAY,
            ["window", span] => {
                let (from_s, until_s) = spanned(span, seconds)?;
                look.windows.push(WindowNeed { from_s, until_s, ramp_s: 0.0 });
            }
            ["ramp", time] => ramp_s = seconds(time)?,
            ["overpass", time] => {
                let (full_s, zero_s) = OVERPASS_S;
                look.overpass = Some(OverpassNeed { passes_s: vec![seconds(time)?], full_s, zero_s });
            }
            ["latency", span] => {
                let (full_s, zero_s) = spanned(span, seconds)?;
                look.latency = Some(LatencyNeed { full_s, zero_s });
            }
            _ => return Err(format!("`{}` is not a property of a wanted look", pair.join(" "))),
        }
    }
    look.windows.iter_mut().for_each(|window| window.ramp_s = ramp_s);
    Ok(look)
}

fn scanned(words: &[&str]) -> Result<ScannedLine, String> {
    let mut line = ScannedLine {
        y_m: 0.0,
        height_m: 0.0,
        x_m: None,
        clarity: 1.0,
        is_hidden: false,
        cover: None,
        at_s: 0.0,
        landed_s: None,
    };
    for pair in words.chunks(2) {
        match pair {
            ["y", metres] => line.y_m = number(metres)?,
            ["height", metres] => line.height_m = number(metres)?,
            ["x", span] => line.x_m = Some(spanned(span, number)?),
            ["clarity", share] => line.clarity = number(share)?,
            ["hidden", "yes"] => line.is_hidden = true,
            ["cover", share] => line.cover = Some(number(share)?),
            ["at", time] => line.at_s = seconds(time)?,
            ["landed", time] => line.landed_s = Some(seconds(time)?),
            _ => return Err(format!("`{}` is not a property of a line", pair.join(" "))),
        }
    }
    Ok(line)
}

fn number(word: &str) -> Result<f64, String> {
    word.parse().map_err(|_| format!("`{word}` is not a number"))
}

/// Reads a duration such as `5h`, `25min` or `30s`.
fn seconds(word: &str) -> Result<f64, String> {
    let units = [("min", 60.0), ("h", 3_600.0), ("s", 1.0)];
    let found =
        units.into_iter().find_map(|(unit, factor)| Some(number(word.strip_suffix(unit)?).map(|count| count * factor)));
    found.unwrap_or_else(|| Err(format!("`{word}` is not a time such as 5h, 25min or 30s")))
}

/// Reads a span `FROM..UNTIL`.
fn spanned(word: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<(f64, f64), String> {
    let (from, until) = word.split_once("..").ok_or_else(|| format!("`{word}` is not a span such as 0..3000"))?;
    Ok((read(from)?, read(until)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_cannot_be_read_is_named() {
        assert!(score("ground ten x 5").unwrap_err().contains("`ten` is not a number"));
        assert!(score("want a colour red").unwrap_err().contains("`colour red`"));
        assert!(score("line y 0 at 5").unwrap_err().contains("`5` is not a time"));
        assert!(score("line x 4").unwrap_err().contains("not a span"));
        assert!(score("fly").unwrap_err().contains("`look` block"));
    }

    #[test]
    fn costs_alone_are_a_negative_score() {
        assert_eq!(score("work 2h at 10\n"), Ok("costs: 20.0 points\nscore: -20.0 points\n".to_string()));
    }
}
