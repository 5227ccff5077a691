//! One target per file.

pub(crate) mod benchmarks;
pub(crate) mod http;
pub(crate) mod inputs;
pub(crate) mod logs;
pub(crate) mod mission;
pub(crate) mod pdl;
pub(crate) mod problems;
pub(crate) mod protocol;
pub(crate) mod records;

/// Largest input of a text target; larger inputs take time without new findings.
const TEXT_BYTES_MAX: usize = 8_192;

/// Returns the input as text, or `None` if it is too long or not UTF-8.
fn text(bytes: &[u8]) -> Option<&str> {
    if bytes.len() > TEXT_BYTES_MAX {
        return None;
    }
    std::str::from_utf8(bytes).ok()
}

/// Reads a PDL value, as the commands do.
fn read_value(text: &str) -> Result<apex_model::value::Value, String> {
    apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message)
}
