//! Sweeps by a line scanner: parallel lines over the ground, or lines along its perimeter, at candidate altitudes and spacings, each with
//! its predicted factors.

use super::altitudes::{self, closed_by};
use super::flying::{FlownLines, fly};
use super::growth::{LineGround, line_grounds, useful};
use super::partial::{ClosedGround, OpenLines};
use super::wish::Wish;
use crate::ground::MissionGround;
use crate::observing::{CLARITY, COVERAGE, ForecastAir, RESOLUTION, clarity, scanner_of};
use apex_geo::coverage::{CoverageArea, SweepSettings, sweep_lines};
use apex_geo::geodesy::{self, RAD_PER_DEG};
use apex_geo::perimeter::perimeter_lines;
use apex_geo::wind;
use apex_model::problem::{AirspaceZone, Manoeuvre, Position, QualityFactor, QualityFactors};
use apex_observation::assess::{AssessContext, assess_factors};
use apex_observation::looks::TargetLooks;
use apex_observation::predict::{
    AirConditions, Conditions, PlannedLine, PredictedScanner, PredictionContext, planned_looks,
};
use apex_observation::result::{LookResult, LossCause};
use apex_observation::target::{ObservedTarget, TargetArea};
use std::collections::BTreeMap;

/// Time from the beginning of a line until the scanner is on, s.
const START_S: f64 = 1.0;

/// A sweep before its factors are predicted.
struct SweepDraft {
    name: String,
    altitude_m: f64,
    lines: Vec<(Position, Position)>,
    flown: FlownLines,
    /// Upper bound of its value, by the swath and the pixels at the nadir: for a selection before predictions.
    promise: f64,
    /// Name of a zone that closes part of the ground.
    shut_by: Option<String>,
}

/// Drafts of a wish that may pay, with the reason that applies if none of them adds anything.
struct Drafts {
    promising: Vec<SweepDraft>,
    without_sweeps: String,
}

/// Returns the sweeps with the points that they are predicted to add.
///
/// # Errors
/// If there is none: the reason, with the nearest possibility.
pub(super) fn sweeps(wish: &Wish<'_>) -> Result<Vec<Sweep>, String> {
    let scanner = scanner_on(wish)?;
    let Drafts { promising, without_sweeps } = drafts(wish, &scanner)?;
    let made: Vec<Sweep> = promising.into_iter().filter_map(|draft| predicted(wish, &scanner, draft)).collect();
    if made.is_empty() { Err(without_sweeps) } else { Ok(made) }
}

/// Returns the error of [`sweeps`], or `None`: the first sweep that adds something ends the search.
pub(super) fn trouble(wish: &Wish<'_>) -> Option<String> {
    let search = || -> Result<Option<String>, String> {
        let scanner = scanner_on(wish)?;
        let Drafts { promising, without_sweeps } = drafts(wish, &scanner)?;
        let is_possible = promising.into_iter().any(|draft| predicted(wish, &scanner, draft).is_some());
        Ok((!is_possible).then_some(without_sweeps))
    };
    search().unwrap_or_else(Some)
}

/// Returns the scanner of the vehicle.
fn scanner_on(wish: &Wish<'_>) -> Result<PredictedScanner, String> {
    let model = &wish.mission.model;
    scanner_of(model).ok_or_else(|| format!("the vehicle `{}` carries no line scanner", model.name))
}

/// Returns the drafts at all altitudes and spacings.
fn drafts(wish: &Wish<'_>, scanner: &PredictedScanner) -> Result<Drafts, String> {
    let mut drafts = Vec::new();
    let mut closed: Option<(f64, &AirspaceZone)> = None;
    let mut trouble = None;
    let grounds = line_grounds(wish.fire);
    for altitude_m in altitudes::of(wish, &scanner.setting.mode)? {
        let height_m = altitude_m - wish.target.elevation_m;
        let spacings = spacings(wish, scanner, height_m);
        for (ground, spacing) in grounds.iter().flat_map(|ground| spacings.iter().map(move |spacing| (ground, spacing)))
        {
            match draft(wish, scanner, (ground, *spacing), altitude_m) {
                Err(why) => trouble = Some(why),
                Ok(draft) => match closed_by(wish, &draft.lines, altitude_m) {
                    None => drafts.push(draft),
                    Some(zone) => {
                        // Of the closed altitudes, the lowest is nearest to a lower face, the highest to an upper one.
                        closed = Some((altitude_m, zone));
                        drafts.extend(partly(wish, scanner, (&draft, spacing.1), zone));
                    }
                },
            }
        }
    }
    let by_zone = closed.map(|(altitude_m, zone)| {
        let (low_m, high_m) = (zone.altitude_m_min, zone.altitude_m_max);
        format!("it needs {altitude_m:.0} m at most, zone {} closes {low_m:.0} to {high_m:.0} m", zone.name)
    });
    let nothing = || "no sweep would add anything".to_string();
    Ok(Drafts { promising: promising(drafts), without_sweeps: by_zone.or(trouble).unwrap_or_else(nothing) })
}

/// Returns names and swaths by which lines are spaced: the useful swath, and the whole swath, which needs fewer lines.
fn spacings(wish: &Wish<'_>, scanner: &PredictedScanner, height_m: f64) -> Vec<(&'static str, f64)> {
    let whole_m = scanner.setting.mode.swath_m(height_m, 0.0);
    let useful_m = scanner.setting.mode.useful_swath_m(height_m, wish.look.resolution.wanted_m);
    match useful_m {
        useful_m if useful_m <= 0.0 => vec![("wide", whole_m)],
        useful_m if useful_m >= 0.99 * whole_m => vec![("fine", useful_m)],
        useful_m => vec![("fine", useful_m), ("wide", whole_m)],
    }
}

/// Returns the lines at one altitude with their flight.
fn draft(
    wish: &Wish<'_>,
    scanner: &PredictedScanner,
    (ground, (name, swath_m)): (&LineGround, (&str, f64)),
    altitude_m: f64,
) -> Result<SweepDraft, String> {
    let Wish { mission, target, fire, .. } = wish;
    let height_m = altitude_m - target.elevation_m;
    let wind = wind::at(&mission.forecast, target.position, altitude_m, wish.from_s);
    // The strip wanders by as much as the wings may roll on a valid line.
    let roll_rad = scanner.setting.roll.map_or(0.0, |roll| roll.valid_deg) * RAD_PER_DEG;
    let overlap = (2.0 * height_m * libm::tan(roll_rad) / swath_m).min(0.5);
    // Scan lines of a crabbing vehicle are skewed: they begin and end later by this distance on one side.
    let crab = (libm::hypot(wind.east_mps, wind.north_mps) / mission.model.true_airspeed_m_s_cruise).min(1.0);
    let settings = SweepSettings { swath_m, overlap, track_deg: None, run_in_m: 0.5 * swath_m * crab };
    let flown =
        |lines: &[(Position, Position)]| fly(lines, altitude_m, wish.from_s, None, &mission.model, &mission.forecast);
    let mut entry = wish.approach;
    let (mut lines, mut along) = (Vec::new(), false);
    for area in &ground.areas {
        // If only the outline is wanted, flying along it may be faster than sweeping its inside.
        let around = match (&fire.wanted.area, area) {
            (TargetArea::Perimeter { .. }, CoverageArea::Polygon(corners)) => {
                perimeter_lines(corners, swath_m, entry).ok()
            }
            (_, CoverageArea::Polygon(corners)) if ground.is_outline => perimeter_lines(corners, swath_m, entry).ok(),
            _ => None,
        };
        let (chosen, is_around) = match around {
            Some(around) if ground.is_outline => (around, true),
            around => faster(around, sweep_lines(area, &settings, entry)?, flown),
        };
        along |= is_around && !ground.is_outline;
        lines.extend(chosen);
        entry = lines.last().map_or(entry, |(_, exit)| *exit);
    }
    let (lines, share) = useful(fire, lines, swath_m);
    if lines.is_empty() {
        return Err("no scan line covers enough of the grown area".to_string());
    }
    let ahead_m = height_m * libm::tan(mission.model.cruise_pitch_rad(altitude_m).max(0.0));
    let start_m = START_S * (mission.model.true_airspeed_m_s_cruise + libm::hypot(wind.east_mps, wind.north_mps));
    let lines: Vec<(Position, Position)> = lines.into_iter().map(|line| earlier(line, (ahead_m, start_m))).collect();
    let name = format!("{}-{name}-{altitude_m:.0}m", if along { "perimeter" } else { ground.name });
    drafted(wish, scanner, (name, altitude_m), OpenLines { lines, share })
}

/// Returns lines with their flight and promise.
fn drafted(
    wish: &Wish<'_>,
    scanner: &PredictedScanner,
    (name, altitude_m): (String, f64),
    OpenLines { lines, share }: OpenLines,
) -> Result<SweepDraft, String> {
    let Wish { mission, target, look, .. } = wish;
    let flown = fly(&lines, altitude_m, wish.from_s, None, &mission.model, &mission.forecast)?;
    let air = ForecastAir::new(mission);
    let AirConditions { edr, clear_share } = air.at(target.position, altitude_m, wish.from_s + 0.5 * flown.duration_s);
    let height_m = altitude_m - target.elevation_m;
    let pixel_m = scanner.setting.mode.nadir_pixel_m(height_m);
    let clarity = clarity(scanner, edr, (height_m, mission.model.true_airspeed_m_s_cruise));
    let promise = share * clear_share * clarity * look.resolution.factor(pixel_m, pixel_m);
    Ok(SweepDraft { name, altitude_m, lines, flown, promise, shut_by: None })
}

/// Returns what remains open of a sweep that a zone closes: its open parts, and lines along an edge of the zone.
fn partly(
    wish: &Wish<'_>,
    scanner: &PredictedScanner,
    (draft, swath_m): (&SweepDraft, f64),
    zone: &AirspaceZone,
) -> Vec<SweepDraft> {
    let Some(ground) = ClosedGround::new(wish, draft.altitude_m) else { return Vec::new() };
    let found = [("open", ground.cut(&draft.lines, swath_m)), ("along", ground.along_edge(swath_m))];
    let drafts = found.into_iter().filter_map(|(word, lines)| {
        let name = format!("{word}-{}-{}", zone.name, draft.name);
        let open = drafted(wish, scanner, (name, draft.altitude_m), lines?).ok()?;
        Some(SweepDraft { shut_by: Some(zone.name.clone()), ..open })
    });
    drafts.collect()
}

/// Returns the lines along the outline and true if they take less time than the swept ones; the swept ones and false otherwise.
fn faster(
    around: Option<Vec<(Position, Position)>>,
    swept: Vec<(Position, Position)>,
    flown: impl Fn(&[(Position, Position)]) -> Result<FlownLines, String>,
) -> (Vec<(Position, Position)>, bool) {
    let Some(around) = around else { return (swept, false) };
    let time_s = |lines: &[(Position, Position)]| flown(lines).map_or(f64::INFINITY, |flown| flown.duration_s);
    if time_s(&around) < time_s(&swept) { (around, true) } else { (swept, false) }
}

/// Returns the line moved back by `ahead_m`, the distance that the scanner of an aircraft with its nose up looks ahead, and extended at
/// its beginning by `start_m`, which is flown until the scanner is on.
fn earlier((from, to): (Position, Position), (ahead_m, start_m): (f64, f64)) -> (Position, Position) {
    let (begin_deg, end_deg) = (geodesy::azimuth_deg(from, to) + 180.0, geodesy::azimuth_deg(to, from));
    (geodesy::destination(from, begin_deg, ahead_m + start_m), geodesy::destination(to, end_deg, ahead_m))
}

/// Returns the drafts for which a prediction may pay: no other draft with at least as many lines has more estimated value in no more time,
/// or as much in less time.
fn promising(drafts: Vec<SweepDraft>) -> Vec<SweepDraft> {
    let beaten = |draft: &SweepDraft| {
        drafts.iter().any(|other| {
            let same_lines = other.lines.len() >= draft.lines.len();
            same_lines
                && other.promise >= draft.promise
                && other.flown.duration_s <= draft.flown.duration_s
                && (other.promise > draft.promise || other.flown.duration_s < draft.flown.duration_s)
        })
    };
    let kept: Vec<bool> = drafts.iter().map(|draft| draft.promise > 0.0 && !beaten(draft)).collect();
    drafts.into_iter().zip(kept).filter(|(_, kept)| *kept).map(|(draft, _)| draft).collect()
}

/// A sweep with its predicted factors.
pub(super) struct Sweep {
    /// The sweep in the form of planners; [`Sweep::explained`] adds the causes of its losses.
    pub(super) manoeuvre: Manoeuvre,
    /// Looks of its lines.
    looks: TargetLooks,
    /// Name of a zone that closes part of the ground.
    shut_by: Option<String>,
}

impl Sweep {
    /// Returns the manoeuvre with the causes of its losses: most sweeps are sorted out before their causes are read.
    pub(super) fn explained(self, wish: &Wish<'_>) -> Manoeuvre {
        if !wish.is_explained {
            return self.manoeuvre;
        }
        let quality = factors(wish, &self.looks, true).unwrap_or(self.manoeuvre.quality);
        Manoeuvre { quality: shut(quality, self.shut_by.as_deref()), ..self.manoeuvre }
    }
}

/// Returns the sweep with its predicted factors; `None` if it adds nothing.
fn predicted(wish: &Wish<'_>, scanner: &PredictedScanner, draft: SweepDraft) -> Option<Sweep> {
    let lines: Vec<PlannedLine> = draft
        .flown
        .lines
        .iter()
        .map(|line| PlannedLine {
            from: line.from,
            to: line.to,
            altitude_m: draft.altitude_m,
            from_s: line.from_s,
            ground_speed_mps: line.ground_speed_mps,
            crab_deg: line.crab_deg,
            pitch_deg: wish.mission.model.cruise_pitch_rad(draft.altitude_m).to_degrees(),
            on_ground_s: None,
        })
        .collect();
    let looks = looks(wish, scanner, &lines);
    let quality = shut(factors(wish, &looks, false)?, draft.shut_by.as_deref());
    let manoeuvre = Manoeuvre {
        name: draft.name,
        altitude_m: draft.altitude_m,
        lines: draft.lines,
        entry: draft.flown.entry,
        duration_s: draft.flown.duration_s,
        length_m: draft.flown.length_m,
        quality,
        pictures: None,
    };
    (manoeuvre.quality.product() > 0.0).then_some(Sweep { manoeuvre, looks, shut_by: draft.shut_by })
}

/// Returns the factors with the zone that closes part of the ground among the causes of their losses.
fn shut(mut quality: QualityFactors, zone: Option<&str>) -> QualityFactors {
    if let Some(zone) = zone.filter(|_| quality.coverage.factor < 1.0) {
        let known = std::mem::take(&mut quality.coverage.cause);
        let joined = if known.is_empty() { known } else { format!("{known}, ") };
        quality.coverage.cause = format!("{joined}zone {zone} closes part of the ground");
    }
    quality
}

/// Returns the wanted look alone: a manoeuvre is planned for it.
fn wanted(wish: &Wish<'_>) -> ObservedTarget {
    ObservedTarget { looks: vec![wish.look.clone()], after: Vec::new(), ..wish.fire.wanted.clone() }
}

/// Returns the predicted looks of the lines.
fn looks(wish: &Wish<'_>, scanner: &PredictedScanner, lines: &[PlannedLine]) -> TargetLooks {
    let wanted = wanted(wish);
    let context = PredictionContext {
        zero_unix_s: zero_unix_s(wish),
        ground: &MissionGround::new(wish.mission.terrain.clone(), wanted.elevation_m),
        conditions: &ForecastAir::new(wish.mission),
        seen: None,
        products: &[],
        first_valid_s: &BTreeMap::new(),
        is_explained: false,
    };
    planned_looks(&wanted, &wish.fire.grid, lines, scanner, &context)
}

/// Returns the predicted factors of the wanted look for the looks of the lines.
fn factors(wish: &Wish<'_>, looks: &TargetLooks, is_explained: bool) -> Option<QualityFactors> {
    let context =
        AssessContext { zero_unix_s: zero_unix_s(wish), products: &[], first_valid_s: &BTreeMap::new(), is_explained };
    assess_factors(&wanted(wish), &wish.fire.grid, &[looks], &context).looks.first().map(quality)
}

fn zero_unix_s(wish: &Wish<'_>) -> f64 {
    wish.mission.settings.epoch_unix_s.unwrap_or(0.0)
}

/// Returns the predicted factors with their causes.
pub(super) fn quality(look: &LookResult) -> QualityFactors {
    let points = |causes: &[LossCause]| {
        let losses = look.losses.iter().filter(|loss| causes.contains(&loss.cause) && loss.points > 0.0);
        let told: Vec<String> =
            losses.map(|loss| format!("{} {:.1} points", loss.cause.words(), loss.points)).collect();
        told.join(", ")
    };
    let factor = |factor: f64, causes: &[LossCause]| QualityFactor {
        factor,
        cause: if factor >= 1.0 { String::new() } else { points(causes) },
    };
    QualityFactors {
        coverage: factor(look.factors.coverage, &COVERAGE),
        clarity: factor(look.factors.clarity, &CLARITY),
        resolution: factor(look.factors.resolution, &RESOLUTION),
    }
}
