//! Notes about entries of a mapping that a log contradicts or does not need.

use crate::FieldUnit;
use apex_model::event::StateVariable;
use apex_model::quantity::{Dimension, Unit, unit_named};
use apex_model::symbol::Symbol;

/// Place and unit of an entry in the file of a mapping.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WrittenEntry {
    /// File, line and column; `None` for entries of a mapping that ships, which prefer one of several fields by design.
    pub place: Option<String>,
    /// The unit that the mapping states for the field.
    pub unit: Option<Symbol>,
    /// The factor as written.
    pub scale: f64,
}

/// A field with its variable and the dimension in which that is declared, if the field's unit is left to the log.
#[derive(Clone, Copy)]
pub(crate) struct MappedField<'a> {
    pub(crate) field: &'a str,
    pub(crate) variable: &'a StateVariable,
    pub(crate) declared: Option<Dimension>,
}

/// Returns the note about a field that is not read, because an earlier entry gives the same variable.
pub(crate) fn second_field(written: &WrittenEntry, mapped: MappedField<'_>, used: &str) -> Option<String> {
    let place = written.place.as_ref()?;
    let MappedField { field, variable, .. } = mapped;
    Some(format!("{place}: the log has `{field}`, which is not read: an earlier entry takes {variable} from `{used}`"))
}

/// Returns the note about a unit that the log states for a field, if it differs from that of the mapping or of the declaration.
pub(crate) fn other_unit(
    written: &WrittenEntry,
    mapped: MappedField<'_>,
    stated: Option<&FieldUnit>,
) -> Option<String> {
    let place = written.place.as_ref()?;
    let stated = stated?;
    let unit = unit_of_label(&stated.label)?;
    let MappedField { field, variable, declared } = mapped;
    let of_log =
        if stated.multiplier == 1.0 { stated.label.clone() } else { format!("{} {}", stated.multiplier, stated.label) };
    if let Some(own) = written.unit.as_ref().and_then(|own| unit_named(own.printed())) {
        let same =
            own.dimension == unit.dimension && alike(written.scale * own.factor, stated.multiplier * unit.factor);
        let scale = if written.scale == 1.0 { String::new() } else { format!("{} ", written.scale) };
        let own = format!("{scale}{}", own.name);
        return (!same).then(|| {
            format!("{place}: the log states `{of_log}` for `{field}`, and the mapping {own}, which counts; leave `:unit` and `:scale` out to take the unit of the log")
        });
    }
    let dimension = declared?;
    (dimension != unit.dimension && dimension != Dimension::NONE).then(|| {
        format!("{place}: the log states `{of_log}` for `{field}`, but {variable} is declared as {dimension}: its numbers are taken as they are")
    })
}

fn alike(one: f64, other: f64) -> bool {
    (one - other).abs() <= 1e-6 * one.abs().max(other.abs())
}

/// Returns the unit that a log means by a label.
pub(crate) fn unit_of_label(label: &str) -> Option<&'static Unit> {
    unit_named(match label {
        "deglatitude" | "deglongitude" | "degheading" => "deg",
        "m/s/s" => "m/s2",
        "Watt" => "W",
        other => other,
    })
}

/// Returns line and column, counted from 1, of each form of a text that can be read.
pub(crate) fn places_of_forms(text: &str) -> Vec<(u32, u32)> {
    let mut places = Vec::new();
    let (mut line, mut column, mut depth) = (1, 0, 0_usize);
    let (mut in_text, mut in_comment, mut escaped) = (false, false, false);
    for letter in text.chars() {
        column += 1;
        if letter == '\n' {
            (line, column, in_comment) = (line + 1, 0, false);
        }
        match letter {
            _ if in_comment => {}
            _ if escaped => escaped = false,
            '\\' if in_text => escaped = true,
            '"' => in_text = !in_text,
            _ if in_text => {}
            ';' => in_comment = true,
            '(' => {
                if depth == 0 {
                    places.push((line, column));
                }
                depth += 1;
            }
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    places
}
