//! The downlink of images as planners assume it: option `:downlink` of the application.

use crate::error::MissionError;
use apex_model::value::Value;

/// Bits in a megabit.
const BIT_PER_MBIT: f64 = 1e6;
/// The form of the option.
const EXAMPLE: &str = "`:downlink (:rate-mbit-s 2 :picture-mbit 40)`: the rate of the link, and the size of a picture";

/// A downlink.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedDownlink {
    /// Rate of the link.
    pub rate_bit_s: f64,
    /// Size of a picture, or of the image of a line.
    pub picture_bit: f64,
}

/// Reads the option; `wrong` makes the error of a value with what to write.
pub(crate) fn read(
    value: Option<&Value>,
    wrong: impl Fn(&Value, &str) -> MissionError,
) -> Result<Option<StatedDownlink>, MissionError> {
    let Some(value) = value else { return Ok(None) };
    let items = value.as_list().ok_or_else(|| wrong(value, EXAMPLE))?;
    let (mut rate, mut picture) = (None, None);
    for pair in items.chunks(2) {
        let [Value::Symbol(key), figure] = pair else { return Err(wrong(value, EXAMPLE)) };
        let slot = match key.folded() {
            ":rate-mbit-s" => &mut rate,
            ":picture-mbit" => &mut picture,
            _ => return Err(wrong(value, EXAMPLE)),
        };
        let number = figure.as_number().filter(|(number, dimension)| {
            *dimension == apex_model::quantity::Dimension::NONE && number.is_finite() && *number > 0.0
        });
        match (number, slot.is_some()) {
            (Some((number, _)), false) => *slot = Some(BIT_PER_MBIT * number),
            _ => return Err(wrong(value, EXAMPLE)),
        }
    }
    match (rate, picture) {
        (Some(rate_bit_s), Some(picture_bit)) => Ok(Some(StatedDownlink { rate_bit_s, picture_bit })),
        _ => Err(wrong(value, EXAMPLE)),
    }
}
