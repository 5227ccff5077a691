//! The figures that follow from a vehicle file, as text.

use crate::model::VehicleModel;
use crate::sensor::CarriedSensor;
use std::fmt::Write;

impl VehicleModel {
    /// Returns the figures that follow from the vehicle file, as text with one figure a line.
    pub fn sheet(&self) -> String {
        sheet(self)
    }
}

fn sheet(model: &VehicleModel) -> String {
    let (unit, factor) = model.energy_unit();
    let drain_unit = if unit == "kg" { "kg/h" } else { "W" };
    let per_hour = if unit == "kg" { 3_600.0 } else { 1.0 };
    let minutes = |seconds: f64| format!("{:.0} min", seconds / 60.0);
    let mut lines: Vec<(String, String)> = vec![
        ("energy".into(), format!("{:.4} {unit}", model.stored_full() / factor)),
        ("drain in cruise".into(), format!("{:.2} {drain_unit}", model.drain_cruise_per_s() * per_hour)),
        ("endurance in cruise".into(), minutes(model.endurance_cruise_s())),
    ];
    if let Some(hover_s) = model.endurance_hover_s() {
        lines.push(("endurance in hover".into(), minutes(hover_s)));
    }
    let reserve = format!("{:.2} {unit}, {} of cruise", model.reserve() / factor, minutes(model.reserve_s()));
    lines.extend([
        ("reserve".into(), reserve),
        ("low".into(), format!("below {:.2} {unit}", model.low() / factor)),
        ("range above the reserve".into(), format!("{:.1} km", model.range_m() / 1_000.0)),
        ("planned turn radius".into(), format!("{:.0} m", model.planned_turn_radius_m())),
    ]);
    for sensor in &model.sensors {
        sensor_lines(model, sensor, &mut lines);
    }
    let mut text = format!("{}\n", model.name);
    for (name, value) in lines {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {name:<26} {value}");
    }
    text
}

fn sensor_lines(model: &VehicleModel, sensor: &CarriedSensor, lines: &mut Vec<(String, String)>) {
    let mode = sensor.mode.as_ref().map_or_else(String::new, |mode| format!(", mode {mode}"));
    lines.push((sensor.name.clone(), format!("{} ({}{mode})", sensor.model.name, sensor.model.kind())));
    if !sensor.model.sees_nadir() {
        lines.push((String::new(), "it cannot look straight down: no views from overhead".into()));
    }
    for height_m in model.sample_heights_m() {
        let sight = model.sight(sensor, height_m);
        let rate = sight.scan_rate_hz_min.map_or_else(String::new, |rate| format!(", {rate:.1} lines/s or more"));
        let figures = format!(
            "pixel {:.3} m below, {:.3} m at the edge, swath {:.0} m{rate}",
            sight.nadir_pixel_m, sight.edge_pixel_m, sight.swath_m
        );
        lines.push((format!("  from {height_m:.0} m"), figures));
    }
    for free in sensor.scanner_mode().map_or_else(Vec::new, |mode| model.gap_free_heights(mode)) {
        let value = format!("no gaps from {:.0} m up", free.height_m);
        lines.push((format!("  at {} lines/s", free.scan_rate_hz), value));
    }
}
