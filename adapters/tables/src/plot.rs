//! A picture of the watched variables as SVG: each state variable over time, its limits, and the intervals of all results.

use apex_executive::MonitorSession;
use apex_model::condition::{Condition, ConditionKind, Constraint};
use apex_model::event::StateVariable;
use apex_model::expression::{Expr, ExprKind};
use apex_model::quantity::{Dimension, unit_named};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use plotters::prelude::*;

const WIDTH: u32 = 1_000;
const PANEL_HEIGHT: u32 = 220;
/// Maximum number of panels in a picture; further variables are left out, with a note in the picture.
const PANELS_MAX: usize = 20;
/// Maximum number of points of a line; with more samples each column keeps its least and greatest value.
const POINTS_MAX: usize = 4_000;

type DrawResult = Result<(), Box<dyn std::error::Error>>;

/// One state variable.
struct Panel {
    title: String,
    points: Vec<(f64, f64)>,
    limits: Vec<f64>,
}

/// Returns a picture of the session's variables that `conditions` read, with the intervals of their results, as SVG; `None` if no sample
/// is a number.
///
/// # Errors
/// An error of the drawing library.
pub fn plot(
    session: &MonitorSession,
    conditions: &[Condition],
    intervals: &[(Time, Time)],
) -> Result<Option<String>, Box<dyn std::error::Error>> {
    let panels: Vec<Panel> =
        session.histories().iter().filter_map(|(variable, _)| panel(session, variable, conditions)).collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let mut text = String::new();
    svg(&mut text, &panels, intervals)?;
    Ok(Some(text))
}

fn panel(session: &MonitorSession, variable: &StateVariable, conditions: &[Condition]) -> Option<Panel> {
    let declared = session.library().state_variables.get(&variable.attribute);
    let unit = declared.and_then(|declared| unit_named(declared.unit.as_ref()?.printed()));
    let number = |value: &Value| match value {
        Value::Quantity(quantity) => Some(unit.map_or(quantity.si, |unit| quantity.in_unit(unit))),
        other => other.as_number().map(|(number, _)| number),
    };
    let history = session.histories().get(variable)?;
    let samples: Vec<(f64, f64)> =
        history.samples().filter_map(|sample| Some((sample.at.seconds(), number(&sample.value)?))).collect();
    let points = thinned(samples);
    if points.is_empty() {
        return None;
    }
    let mut limits = Vec::new();
    for condition in conditions {
        limits_in(condition, &variable.attribute, &mut limits);
    }
    let plain = |value: &Value| match value.as_number() {
        Some((number, Dimension::NONE)) => Some(number),
        _ => number(value),
    };
    let limits = limits.iter().filter_map(plain).collect();
    let unit = unit.map(|unit| format!(", {}", unit.name)).unwrap_or_default();
    Some(Panel { title: format!("{variable}{unit}"), points, limits })
}

/// Collects the constants with which conditions compare values of the attribute.
fn limits_in(condition: &Condition, attribute: &Symbol, limits: &mut Vec<Value>) {
    let mut note = |constraints: &[Constraint]| {
        let sides = constraints.iter().flat_map(|constraint| match constraint {
            Constraint::Compare { right, .. } => vec![right],
            Constraint::Range(low, high) => low.iter().chain(high).collect::<Vec<&Expr>>(),
            Constraint::Matches(_) | Constraint::Predicate(..) => Vec::new(),
        });
        limits.extend(sides.filter_map(|side| match &side.kind {
            ExprKind::Constant(value) => Some(value.clone()),
            _ => None,
        }));
    };
    match &condition.kind {
        ConditionKind::Measurement(leaf) if leaf.variable.attribute == *attribute => note(&leaf.value),
        ConditionKind::Episode(leaf) if leaf.variable.attribute == *attribute => note(&leaf.value),
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().for_each(|part| limits_in(part, attribute, limits));
        }
        ConditionKind::Allen { parts, .. } => parts.iter().for_each(|part| limits_in(part, attribute, limits)),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => limits_in(part, attribute, limits),
        ConditionKind::Probing { condition, .. } => limits_in(condition, attribute, limits),
        _ => {}
    }
}

/// Returns at most [`POINTS_MAX`] points, among them the least and greatest value of each stretch of samples.
fn thinned(samples: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    if samples.len() <= POINTS_MAX {
        return samples;
    }
    let stretch = samples.len().div_ceil(POINTS_MAX / 2);
    let mut points = Vec::with_capacity(POINTS_MAX);
    for part in samples.chunks(stretch) {
        let least = part.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
        let most = part.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        let mut both: Vec<(f64, f64)> = least.into_iter().chain(most).collect();
        both.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.extend(both);
    }
    points
}

fn svg(text: &mut String, panels: &[Panel], intervals: &[(Time, Time)]) -> DrawResult {
    let shown = panels.get(..PANELS_MAX).unwrap_or(panels);
    let height = PANEL_HEIGHT * u32::try_from(shown.len())?;
    let root = SVGBackend::with_string(text, (WIDTH, height)).into_drawing_area();
    root.fill(&WHITE)?;
    let all = shown.iter().flat_map(|panel| panel.points.iter().map(|point| point.0));
    let (from, to) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let span = from..if to > from { to } else { from + 1.0 };
    for (area, panel) in root.split_evenly((shown.len(), 1)).iter().zip(shown) {
        let left_out = if panels.len() > shown.len() {
            format!("; {} more variables", panels.len() - shown.len())
        } else {
            String::new()
        };
        draw_panel(area, panel, &left_out, span.clone(), intervals)?;
    }
    root.present()?;
    Ok(())
}

fn draw_panel(
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    panel: &Panel,
    left_out: &str,
    span: std::ops::Range<f64>,
    intervals: &[(Time, Time)],
) -> DrawResult {
    let values = panel.points.iter().map(|point| point.1).chain(panel.limits.iter().copied());
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), each| (low.min(each), high.max(each)));
    let margin = if high > low { (high - low) * 0.05 } else { 1.0 };
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .caption(format!("{}{left_out}", panel.title), ("sans-serif", 14))
        .x_label_area_size(28)
        .y_label_area_size(56)
        .build_cartesian_2d(span.clone(), low - margin..high + margin)?;
    chart.configure_mesh().x_desc("s").light_line_style(WHITE).draw()?;
    let shaded = |(start, end): &(Time, Time)| {
        // An instant is drawn as a narrow bar.
        let least = (span.end - span.start) / f64::from(WIDTH);
        let (start, end) = (start.seconds(), end.seconds().max(start.seconds() + least));
        Rectangle::new([(start, low - margin), (end, high + margin)], RGBColor(230, 120, 40).mix(0.25).filled())
    };
    chart.draw_series(intervals.iter().map(shaded))?;
    for limit in &panel.limits {
        chart.draw_series(LineSeries::new([(span.start, *limit), (span.end, *limit)], RED))?;
    }
    chart.draw_series(LineSeries::new(panel.points.iter().copied(), BLUE))?;
    Ok(())
}
