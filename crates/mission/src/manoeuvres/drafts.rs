//! Candidate manoeuvres for pictures, before and after the prediction of their quality factors.

use super::scanner::quality;
use super::wish::Wish;
use crate::ground::MissionGround;
use crate::observing::ForecastAir;
use apex_model::problem::{Manoeuvre, PictureWork, Position, QualityFactors};
use apex_observation::pictures::{PlannedPicture, predict_pictures};
use apex_observation::predict::PredictionContext;
use apex_observation::target::ObservedTarget;
use std::collections::BTreeMap;

/// A candidate manoeuvre without predicted factors.
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) altitude_m: f64,
    pub(super) lines: Vec<(Position, Position)>,
    /// Beginning of the first lead-in; `None` without one.
    pub(super) entry: Option<Position>,
    pub(super) duration_s: f64,
    pub(super) length_m: f64,
    /// Planned pictures, one list for each independent attempt.
    pub(super) passes: Vec<Vec<PlannedPicture>>,
    pub(super) work: PictureWork,
}

/// Returns the draft with its predicted factors; `None` if it has no value.
pub(super) fn predicted(wish: &Wish<'_>, draft: Draft) -> Option<Manoeuvre> {
    let wanted = ObservedTarget { looks: vec![wish.look.clone()], after: Vec::new(), ..wish.fire.wanted.clone() };
    let air = ForecastAir::new(wish.mission);
    let first_valid_s = BTreeMap::new();
    let context = PredictionContext {
        zero_unix_s: wish.mission.settings.epoch_unix_s.unwrap_or(0.0),
        ground: &MissionGround::new(wish.mission.terrain.clone(), wanted.elevation_m),
        conditions: &air,
        seen: None,
        products: &[],
        first_valid_s: &first_valid_s,
        is_explained: true,
    };
    let result = predict_pictures(&wanted, &wish.fire.grid, &draft.passes, &context);
    let quality: QualityFactors = quality(result.looks.first()?);
    (quality.product() > 0.0).then_some(Manoeuvre {
        name: draft.name,
        altitude_m: draft.altitude_m,
        lines: draft.lines,
        entry: draft.entry,
        duration_s: draft.duration_s,
        length_m: draft.length_m,
        quality,
        pictures: Some(draft.work),
    })
}
