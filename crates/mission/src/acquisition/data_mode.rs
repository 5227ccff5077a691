//! Handling of the data of a manoeuvre in PDL notation: `:data store`, `:data stream` or `:data (process DELAY SHARE)`.

use crate::downlink::StatedDownlink;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_observation::manoeuvres::DataHandling;

/// Values of `:data`.
const VALUES: &str = "store, stream, or (process DELAY SHARE) with the time to process a picture and the size of its product as a share of \
                      it, such as (process 5s 0.1)";

/// A handling of data that a form or a goal states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum DataMode {
    /// Stored on board until landing.
    Store,
    /// Sent while it is recorded.
    Stream,
    /// Processed on board; the product is sent.
    Process {
        /// Time to process a picture.
        delay_s: f64,
        /// Size of the product as a share of the picture.
        share: f64,
    },
}

impl DataMode {
    /// Reads a value; `whose` names the form in errors.
    ///
    /// # Errors
    /// The values that work.
    pub(crate) fn read(value: &Value, whose: &str) -> Result<DataMode, String> {
        let wrong = || format!("`:data` of `{whose}` is {value}; write {VALUES}");
        if let Some(word) = value.as_symbol() {
            return match word.folded() {
                "store" => Ok(DataMode::Store),
                "stream" => Ok(DataMode::Stream),
                _ => Err(wrong()),
            };
        }
        let Some([Value::Symbol(head), delay, share]) = value.as_list() else { return Err(wrong()) };
        let delay_s = match delay.as_number() {
            Some((delay_s, Dimension::TIME | Dimension::NONE)) if delay_s.is_finite() && delay_s >= 0.0 => delay_s,
            _ => return Err(wrong()),
        };
        match share.as_number() {
            Some((share, Dimension::NONE)) if head.is("process") && share > 0.0 && share <= 1.0 => {
                Ok(DataMode::Process { delay_s, share })
            }
            _ => Err(wrong()),
        }
    }

    /// Returns the value that is read as this handling.
    pub(crate) fn value(self) -> Value {
        match self {
            DataMode::Store => Value::symbol("store"),
            DataMode::Stream => Value::symbol("stream"),
            DataMode::Process { delay_s, share } => {
                Value::list([Value::symbol("process"), Value::measured(delay_s, Dimension::TIME), Value::Real(share)])
            }
        }
    }

    /// Returns the handling over the mission's downlink.
    ///
    /// # Errors
    /// The mission states no downlink, and the data are not stored.
    pub(crate) fn over(self, link: Option<&StatedDownlink>) -> Result<DataHandling, String> {
        let Some(StatedDownlink { rate_bit_s, picture_bit }) = link.copied() else {
            return match self {
                DataMode::Store => Ok(DataHandling::Store),
                DataMode::Stream | DataMode::Process { .. } => Err(format!(
                    "`:data {}` needs a link, and the mission states none; add `:downlink (:rate-mbit-s 2 :picture-mbit 40)` to the \
                     application with the figures of the link, and for simulation a `downlink` to the world file; or write `:data store`",
                    self.value()
                )),
            };
        };
        Ok(match self {
            DataMode::Store => DataHandling::Store,
            DataMode::Stream => DataHandling::Stream { picture_bit, link_bit_s: rate_bit_s },
            DataMode::Process { delay_s, share } => {
                DataHandling::Process { delay_s, product_bit: share * picture_bit, link_bit_s: rate_bit_s }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_modes_are_read_as_they_are_printed_and_need_a_link_to_leave() {
        let link = StatedDownlink { rate_bit_s: 2e6, picture_bit: 4e7 };
        for mode in [DataMode::Store, DataMode::Stream, DataMode::Process { delay_s: 5.0, share: 0.1 }] {
            assert_eq!(DataMode::read(&mode.value(), "orbit"), Ok(mode));
            assert_eq!(mode.over(None).is_ok(), mode == DataMode::Store);
        }
        let process = DataMode::Process { delay_s: 5.0, share: 0.1 };
        let product = DataHandling::Process { delay_s: 5.0, product_bit: 4e6, link_bit_s: 2e6 };
        assert_eq!(process.over(Some(&link)), Ok(product));
        let wrong = [
            Value::symbol("keep"),
            Value::Real(2.0),
            Value::list([Value::symbol("process"), Value::Real(5.0)]),
            Value::list([Value::symbol("process"), Value::Real(5.0), Value::Real(1.5)]),
            Value::list([Value::symbol("process"), Value::Real(-5.0), Value::Real(0.5)]),
        ];
        for value in wrong {
            let why = DataMode::read(&value, "orbit").unwrap_err();
            assert!(why.contains("write store, stream, or (process DELAY SHARE)"), "{why}");
        }
    }
}
