//! Reads the level of a radio by place: `:station home :full-level 1500m :range 5km :shadows ((:around barn :radius 300m :factor 0.1))`.
//!
//! `:modems` states the levels of the simulated world, `:link-map` those that the planner assumes.

use crate::error::MissionResult;
use crate::link_form::LinkForm;
use apex_geo::link::{EXPONENT, LevelLaw, LevelModel, Shadow, ShadowShape};
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::value::Value;

/// Distance up to which a ground radio has full level, if the mission does not state it.
const FULL_LEVEL_M: f64 = 1_000.0;
/// Height of the station's antenna above its ground, m: a mast that is set up by hand.
const ANTENNA_M: f64 = 3.0;
/// Greatest accepted distance, m: radios of aircraft do not reach farther.
const RANGE_M_MAX: f64 = 2e6;
/// Path-loss exponents: from a street canyon to dense forest.
const EXPONENT_MIN_MAX: (f64, f64) = (1.0, 8.0);
/// Maximum number of shadows of one radio, and of entries of a table.
const ENTRIES_MAX: usize = 200;

/// Keys that [`LevelReader::take`] reads.
pub(crate) const KEYS: &str = ":station, :full-level, :range, :exponent, :levels, :shadows";

/// Figures of a level as far as they have been read.
#[derive(Default)]
pub(crate) struct LevelReader {
    station: Option<(Position, f64)>,
    full_level_m: Option<f64>,
    range_m: Option<f64>,
    exponent: Option<f64>,
    table: Option<Vec<(f64, f64)>>,
    shadows: Vec<Shadow>,
}

impl LevelReader {
    /// Reads one key; returns false if the key does not belong to a level.
    ///
    /// # Errors
    /// A value of another type or outside of its range.
    pub(crate) fn take(&mut self, form: &LinkForm<'_>, key: &str, value: &Value) -> MissionResult<bool> {
        match key {
            ":station" => self.station = Some(form.place(key, value)?),
            ":full-level" => self.full_level_m = Some(form.figure(key, value, Dimension::LENGTH, RANGE_M_MAX)?),
            ":range" => self.range_m = Some(form.figure(key, value, Dimension::LENGTH, RANGE_M_MAX)?),
            ":exponent" => {
                let exponent = form.figure(key, value, Dimension::NONE, EXPONENT_MIN_MAX.1)?;
                if exponent < EXPONENT_MIN_MAX.0 {
                    return Err(form.wrong(format!("`:exponent {value}` is below {}", EXPONENT_MIN_MAX.0)));
                }
                self.exponent = Some(exponent);
            }
            ":levels" => self.table = Some(table(form, value)?),
            ":shadows" => {
                let items = form.list(key, value)?;
                if items.len() > ENTRIES_MAX {
                    return Err(form.wrong(format!("it has more than {ENTRIES_MAX} shadows")));
                }
                self.shadows = items.iter().map(|item| shadow(form, item)).collect::<MissionResult<_>>()?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Returns the level model of the options that were read.
    ///
    /// # Errors
    /// Keys that exclude one another, a range that is not greater than the distance of full level, a distance without a station.
    pub(crate) fn finish(self, form: &LinkForm<'_>) -> MissionResult<LevelModel> {
        let stated = [
            (":full-level", self.full_level_m.is_some()),
            (":range", self.range_m.is_some()),
            (":exponent", self.exponent.is_some()),
            (":levels", self.table.is_some()),
        ];
        let Some((station, elevation_m)) = self.station else {
            if let Some((key, _)) = stated.iter().find(|(_, is_stated)| *is_stated) {
                return Err(form.wrong(format!("`{key}` needs a `:station`: a satellite link is full everywhere")));
            }
            let of_station =
                |shadow: &&Shadow| matches!(shadow.shape, ShadowShape::Sector { .. } | ShadowShape::Ridge { .. });
            if self.shadows.iter().any(|shadow| of_station(&shadow)) {
                return Err(form.wrong("shadows by `:sector` and `:ridge` need a `:station`".to_string()));
            }
            return Ok(LevelModel { shadows: self.shadows, ..LevelModel::satellite() });
        };
        if self.table.is_some() && stated.iter().take(3).any(|(_, is_stated)| *is_stated) {
            return Err(form.wrong("`:levels` excludes `:full-level`, `:range` and `:exponent`".to_string()));
        }
        if self.range_m.is_some() && self.exponent.is_some() {
            return Err(form.wrong("`:range` and `:exponent` both determine how fast the level falls".to_string()));
        }
        let full_level_m = self.full_level_m.unwrap_or(FULL_LEVEL_M);
        let law = match (self.table, self.range_m) {
            (Some(points), _) => LevelLaw::Table(points),
            (None, Some(range_m)) if range_m > full_level_m => LevelLaw::Logarithmic { full_level_m, range_m },
            (None, Some(range_m)) => {
                return Err(
                    form.wrong(format!("`:range` of {range_m} m is not beyond the {full_level_m} m of full level"))
                );
            }
            (None, None) => LevelLaw::with_exponent(full_level_m, self.exponent.unwrap_or(EXPONENT)),
        };
        Ok(LevelModel {
            station: Some(station),
            station_altitude_m: elevation_m + ANTENNA_M,
            law,
            shadows: self.shadows,
        })
    }
}

/// `((1km 1) (2km 0.5) (3km 0))`
fn table(form: &LinkForm<'_>, value: &Value) -> MissionResult<Vec<(f64, f64)>> {
    let wrong = |why: &str| form.wrong(format!("`:levels {value}`: {why}"));
    let items = form.list(":levels", value)?;
    let mut points: Vec<(f64, f64)> = Vec::new();
    for item in items {
        let Some([distance, level]) = item.as_list() else {
            return Err(wrong("expected pairs of a distance and a level, for example ((1km 1) (3km 0))"));
        };
        let distance_m = form.figure(":levels", distance, Dimension::LENGTH, RANGE_M_MAX)?;
        let level = form.share(":levels", level)?;
        if points.last().is_some_and(|(before_m, before)| *before_m >= distance_m || *before < level) {
            return Err(wrong("distances must rise and levels must not"));
        }
        points.push((distance_m, level));
    }
    match points.len() {
        2..=ENTRIES_MAX => Ok(points),
        _ => Err(wrong("expected two pairs or more, and at most 200")),
    }
}

/// Reads `(:around PLACE :radius 300m | :corners (PLACE ..) | :sector (40deg 80deg) [:beyond 2km] | :ridge (PLACE PLACE) :top 140m)` with
/// `[:below 120m] [:factor 0.1]`.
fn shadow(form: &LinkForm<'_>, item: &Value) -> MissionResult<Shadow> {
    let mut shape: Option<(&str, &Value)> = None;
    let (mut radius_m, mut beyond_m, mut top_m, mut below_m, mut factor) = (None, None, None, None, None);
    for (key, value) in form.pairs_of(item)? {
        match key {
            ":around" | ":corners" | ":sector" | ":ridge" => {
                if let Some((other, _)) = shape.replace((key, value)) {
                    return Err(form.wrong(format!("a shadow has `{other}` or `{key}`, not both")));
                }
            }
            ":radius" => radius_m = Some(form.figure(key, value, Dimension::LENGTH, RANGE_M_MAX)?),
            ":beyond" => beyond_m = Some(form.figure(key, value, Dimension::LENGTH, RANGE_M_MAX)?),
            ":top" => top_m = Some(form.figure(key, value, Dimension::LENGTH, 10_000.0)?),
            ":below" => below_m = Some(form.figure(key, value, Dimension::LENGTH, 100_000.0)?),
            ":factor" => factor = Some(form.share(key, value)?),
            other => {
                return Err(
                    form.unknown(other, ":around, :radius, :corners, :sector, :beyond, :ridge, :top, :below, :factor")
                );
            }
        }
    }
    let place = |value: &Value| form.place("shadow", value).map(|(position, _)| position);
    let needs = |key: &str, of: &str| form.wrong(format!("a shadow with `{of}` needs `{key}`"));
    let head = shape.map_or("", |(key, _)| key);
    let stated = [(":radius", ":around", radius_m), (":beyond", ":sector", beyond_m), (":top", ":ridge", top_m)];
    if let Some((key, of, _)) = stated.iter().find(|(_, of, figure)| figure.is_some() && head != *of) {
        return Err(form.wrong(format!("`{key}` belongs to a shadow with `{of}`")));
    }
    if factor.is_some() && head == ":ridge" {
        return Err(form.wrong("a ridge computes its own loss: leave `:factor` out".to_string()));
    }
    let shape = match shape {
        Some((":around", value)) => ShadowShape::Disc {
            position: place(value)?,
            radius_m: radius_m.ok_or_else(|| needs(":radius", ":around"))?,
        },
        Some((":corners", value)) => {
            let corners = form.list(":corners", value)?.iter().map(place).collect::<MissionResult<Vec<_>>>()?;
            if !(3..=ENTRIES_MAX).contains(&corners.len()) {
                return Err(form.wrong(format!("`:corners` has {} places; expected 3 to {ENTRIES_MAX}", corners.len())));
            }
            ShadowShape::Polygon(corners)
        }
        Some((":sector", value)) => match form.list(":sector", value)? {
            [from, to] => ShadowShape::Sector {
                from_deg: form.angle_deg(":sector", from)?,
                to_deg: form.angle_deg(":sector", to)?,
                beyond_m: beyond_m.unwrap_or(0.0),
            },
            _ => {
                return Err(
                    form.wrong(format!("`:sector {value}`: expected two directions, for example (40deg 80deg)"))
                );
            }
        },
        Some((_, value)) => match form.list(":ridge", value)? {
            [first, second] => ShadowShape::Ridge {
                ends: (place(first)?, place(second)?),
                top_m: top_m.ok_or_else(|| needs(":top", ":ridge"))?,
            },
            _ => return Err(form.wrong(format!("`:ridge {value}`: expected its two ends"))),
        },
        None => {
            return Err(
                form.wrong(format!("the shadow {item} has no shape; expected :around, :corners, :sector or :ridge"))
            );
        }
    };
    Ok(Shadow { shape, altitude_m_max: below_m.unwrap_or(f64::INFINITY), factor: factor.unwrap_or(0.0) })
}
