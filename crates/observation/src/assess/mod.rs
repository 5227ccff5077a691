//! Assessment of passes: the factors of each wanted look of a target, chained per cell.
//!
//! For each look of a cell: clarity s, resolution r, timing o; the best look of a cell counts for each wanted look. With N the wanted
//! weight and sums weighted by cell: `c = A(seen)/N`, `s = sum s / A(seen)`, `r = sum s r / sum s`, `o = sum s r o / sum s r`; so `c s r
//! o = (1/N) sum s r o` exactly, and seeing more ground never lowers the score. Predicted looks count with the probability that they are
//! the best valid one (`chance`).
//! Bound: O(cell looks), times the assignments of a cell's passes where several looks are wanted (`assign`).

mod assign;
mod by_cell;
mod chance;
mod context;
mod worth;

pub use context::{AssessContext, Product};

use crate::grid::TargetGrid;
use crate::looks::{TargetLooks, TargetPass};
use crate::result::{Factors, LookResult, Loss, LossCause, Remark, SeenFigures, TargetResult};
use crate::target::{ObservedTarget, WantedLook};
use assign::Chosen;
use by_cell::ByCell;
use chance::CellWorth;
use std::collections::BTreeSet;
use worth::{CAUSES, StripWorth};

/// Returns the factors, points and losses of every wanted look of a target, from all passes in `looks`, which must belong to `grid`
/// ([`TargetLooks::on_grid`] moves them to another grid).
pub fn assess(
    target: &ObservedTarget,
    grid: &TargetGrid,
    looks: &[&TargetLooks],
    context: &AssessContext<'_>,
) -> TargetResult {
    assessed(target, grid, looks, (context, true))
}

/// Returns what [`assess`] returns, without the figures of what was seen ([`LookResult::seen`]): planners compare factors.
pub fn assess_factors(
    target: &ObservedTarget,
    grid: &TargetGrid,
    looks: &[&TargetLooks],
    context: &AssessContext<'_>,
) -> TargetResult {
    assessed(target, grid, looks, (context, false))
}

fn assessed(
    target: &ObservedTarget,
    grid: &TargetGrid,
    looks: &[&TargetLooks],
    (context, has_figures): (&AssessContext<'_>, bool),
) -> TargetResult {
    debug_assert!(looks.iter().all(|looks| looks.fits(grid)), "looks of another grid of target {}", target.name);
    let mut passes: Vec<&TargetPass> =
        looks.iter().flat_map(|looks| &looks.passes).filter(|pass| !pass.looks.is_empty()).collect();
    passes.sort_by(|a, b| a.from_s().unwrap_or(0.0).total_cmp(&b.from_s().unwrap_or(0.0)));
    let by_cell = ByCell::new(passes, grid.len());
    let worths: Vec<StripWorth<'_>> =
        target.looks.iter().map(|look| StripWorth::new(target, look, grid, &by_cell.passes, context)).collect();
    let mut cells: Vec<Vec<CellWorth>> = target.looks.iter().map(|_| Vec::with_capacity(grid.len())).collect();
    let explained = if context.is_explained { grid.len() } else { 0 };
    let mut losses: Vec<Vec<[f64; CAUSES]>> = target.looks.iter().map(|_| Vec::with_capacity(explained)).collect();
    let mut scratch = chance::Scratch::default();
    for cell in 0..grid.len() {
        let chosen = assign::assign(&by_cell, cell, &worths, &mut scratch);
        for (k, worth) in worths.iter().enumerate() {
            let entries = by_cell.of(cell);
            let outcome = match &chosen {
                Chosen::All => {
                    chance::outcome(&by_cell, worth, entries.iter().map(|entry| (*entry, 1.0)), &mut scratch)
                }
                Chosen::Passes(passes) => {
                    chance::outcome(&by_cell, worth, assign::serving(passes, k, entries), &mut scratch)
                }
            };
            if let Some(all) = cells.get_mut(k) {
                all.push(outcome);
            }
            if context.is_explained
                && let Some(all) = losses.get_mut(k)
            {
                all.push(chance::losses(&by_cell, worth, &outcome, &scratch));
            }
        }
    }
    let mut remarks: BTreeSet<Remark> = looks.iter().flat_map(|looks| looks.remarks.iter().copied()).collect();
    if grid.is_terrain_missing() {
        remarks.insert(Remark::TerrainNotKnown);
    }
    let results = target.looks.iter().zip(&worths).zip(cells.iter().zip(&losses));
    let results = results.map(|((look, worth), (cells, losses))| {
        let mut remarks = remarks.clone();
        if look.latency.is_some() && worth.is_arrival_missing {
            remarks.insert(Remark::ArrivalNotKnown);
        }
        result_of((look, has_figures), grid, &by_cell, (cells, losses), remarks)
    });
    TargetResult { name: target.name.clone(), looks: results.collect() }
}

/// Returns the cells that count, each with its share: all of them, or the best ones up to the wanted share.
fn counted(look: &WantedLook, grid: &TargetGrid, cells: &[CellWorth]) -> (f64, Vec<(usize, f64)>) {
    let share = if look.coverage_share.is_nan() { 1.0 } else { look.coverage_share.clamp(0.0, 1.0) };
    if share >= 1.0 {
        return (grid.total(), grid.weights().iter().copied().enumerate().collect());
    }
    let mut order: Vec<usize> = (0..cells.len()).collect();
    let rank = |index: &usize| cells.get(*index).copied().unwrap_or_default();
    order.sort_by(|a, b| {
        let (first, second) = (rank(a), rank(b));
        let by_worth = second.sro.total_cmp(&first.sro).then(second.is_seen.cmp(&first.is_seen));
        by_worth.then(second.sr.total_cmp(&first.sr)).then(second.s.total_cmp(&first.s))
    });
    let wanted = share * grid.total();
    let (mut left, mut kept) = (wanted, Vec::new());
    for index in order {
        if left <= 0.0 {
            break;
        }
        let weight = grid.weights().get(index).copied().unwrap_or(0.0).min(left);
        kept.push((index, weight));
        left -= weight;
    }
    (wanted, kept)
}

fn result_of(
    (look, has_figures): (&WantedLook, bool),
    grid: &TargetGrid,
    by_cell: &ByCell<'_>,
    (cells, losses): (&[CellWorth], &[[f64; CAUSES]]),
    remarks: BTreeSet<Remark>,
) -> LookResult {
    let (wanted, kept) = counted(look, grid, cells);
    let (mut seen, mut s, mut sr, mut sro) = (0.0, 0.0, 0.0, 0.0);
    let mut lost = [0.0; CAUSES];
    for (index, weight) in &kept {
        let Some(cell) = cells.get(*index) else { continue };
        if cell.is_seen {
            seen += weight;
            s += weight * cell.s;
            sr += weight * cell.sr;
            sro += weight * cell.sro;
        }
        if let Some(shares) = losses.get(*index) {
            lost.iter_mut().zip(shares).for_each(|(sum, share)| *sum += weight * share);
        }
    }
    let ratio = |above: f64, below: f64| if below > 0.0 { above / below } else { 0.0 };
    let factors = Factors {
        // Sums of the same cells in another order may differ in the last digits.
        coverage: ratio(seen, wanted).min(1.0),
        clarity: ratio(s, seen),
        resolution: ratio(sr, s),
        timing: ratio(sro, sr),
    };
    let product = factors.product();
    let value_per_weight = ratio(look.value, wanted);
    let losses = LossCause::ALL.iter().zip(lost).filter(|(_, weight)| *weight > 0.0);
    let missed = look.must.filter(|must| product <= must.factor_min).map(|must| must.cost);
    LookResult {
        name: look.name.clone(),
        value: look.value,
        factors,
        points: look.value * product,
        must_missed: missed,
        losses: losses.map(|(cause, weight)| Loss { cause: *cause, points: value_per_weight * weight }).collect(),
        seen: if has_figures { figures(by_cell, cells, &kept, wanted, seen) } else { SeenFigures::default() },
        remarks,
    }
}

fn figures(by_cell: &ByCell<'_>, cells: &[CellWorth], kept: &[(usize, f64)], wanted: f64, seen: f64) -> SeenFigures {
    let mut figures = SeenFigures { wanted, seen, passes: by_cell.passes.len(), ..SeenFigures::default() };
    let (mut weights, mut pixels, mut angles) = (0.0, 0.0, 0.0);
    for (index, weight) in kept {
        let Some((cell, entry)) = cells.get(*index).and_then(|cell| cell.best.map(|entry| (cell, entry))) else {
            continue;
        };
        let (Some(look), Some(pass)) = (by_cell.look(entry), by_cell.passes.get(entry.0 as usize)) else { continue };
        let Some(strip) = pass.strip(look) else { continue };
        weights += weight;
        pixels += weight * f64::from(look.pixel_across_m.max(look.pixel_along_m));
        angles += weight * libm::acos(f64::from(look.look_cosine).min(1.0));
        let earlier = |known: Option<f64>| Some(known.map_or(strip.time_s, |time_s: f64| time_s.min(strip.time_s)));
        figures.first_s = earlier(figures.first_s);
        figures.last_s = Some(figures.last_s.map_or(strip.time_s, |time_s: f64| time_s.max(strip.time_s)));
        if cell.s > 0.0 {
            figures.first_valid_s = earlier(figures.first_valid_s);
        }
    }
    if weights > 0.0 {
        figures.pixel_m_mean = Some(pixels / weights);
        figures.look_angle_deg_mean = Some(angles / weights / apex_geo::geodesy::RAD_PER_DEG);
    }
    figures
}
