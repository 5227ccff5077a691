//! Distances of a TSPLIB file: computed from places by a metric, or stated as a matrix.

use super::super::distance::Metric;
use super::super::words::TextToken;
use super::HELP;
use super::header::Header;
use crate::format_error::FormatError;
use apex_model::problem::UNREACHABLE_S;

/// Source of distances.
pub(super) enum Weights {
    /// A metric of places.
    Places(Metric, Vec<(f64, f64)>),
    /// A whole matrix, row after row.
    Matrix(Vec<f64>),
}

impl Weights {
    /// Returns the distance from one node to another, of `count` nodes.
    pub(super) fn between(&self, from: usize, to: usize, count: usize) -> f64 {
        match self {
            Weights::Places(metric, places) => match (places.get(from), places.get(to)) {
                (Some(from), Some(to)) => metric.between(*from, *to),
                _ => UNREACHABLE_S,
            },
            Weights::Matrix(matrix) => matrix.get(from * count + to).copied().unwrap_or(UNREACHABLE_S),
        }
    }

    /// Returns the longest distance between two nodes.
    pub(super) fn longest(&self, count: usize) -> f64 {
        let pairs = (0..count).flat_map(|from| (0..count).map(move |to| (from, to)));
        pairs.filter(|(from, to)| from != to).map(|(from, to)| self.between(from, to, count)).fold(0.0, f64::max)
    }

    /// Returns true if all distances are whole numbers.
    pub(super) fn are_whole(&self) -> bool {
        match self {
            Weights::Places(..) => true,
            Weights::Matrix(matrix) => matrix.iter().all(|weight| *weight == libm::floor(*weight)),
        }
    }

    /// Returns true if places are latitudes and longitudes.
    pub(super) fn is_geographical(&self) -> bool {
        matches!(self, Weights::Places(Metric::Geographical, _))
    }
}

/// Returns the cells of a matrix in the order of a layout.
fn cells(layout: &str, count: usize) -> Option<Box<dyn Iterator<Item = (usize, usize)>>> {
    let rows = 0..count;
    Some(match layout {
        "FULL_MATRIX" => Box::new(rows.flat_map(move |row| (0..count).map(move |column| (row, column)))),
        // Columns of one half are rows of the other, because the matrix is symmetric.
        "UPPER_ROW" | "LOWER_COL" => Box::new(rows.flat_map(move |row| (row + 1..count).map(move |to| (row, to)))),
        "LOWER_ROW" | "UPPER_COL" => Box::new(rows.flat_map(move |row| (0..row).map(move |to| (row, to)))),
        "UPPER_DIAG_ROW" | "LOWER_DIAG_COL" => {
            Box::new(rows.flat_map(move |row| (row..count).map(move |to| (row, to))))
        }
        "LOWER_DIAG_ROW" | "UPPER_DIAG_COL" => Box::new(rows.flat_map(move |row| (0..=row).map(move |to| (row, to)))),
        _ => return None,
    })
}

/// Returns the whole matrix.
pub(super) fn read(
    at: &TextToken<'_>,
    numbers: &[TextToken<'_>],
    count: usize,
    header: &Header,
) -> Result<Vec<f64>, FormatError> {
    let layout = header.layout.as_deref().unwrap_or("");
    let order = cells(layout, count).ok_or_else(|| {
        let reason = "supported formats are FULL_MATRIX, UPPER_ROW, LOWER_ROW, UPPER_DIAG_ROW, LOWER_DIAG_ROW and their _COL twins";
        at.trouble(format!("EDGE_WEIGHT_FORMAT {layout:?} is not known"), reason, HELP)
    })?;
    let mut matrix = vec![0.0; count * count];
    let mut words = numbers.iter();
    for (row, column) in order {
        let word = words.next().ok_or_else(|| {
            let reason = format!("{layout} of {count} nodes continues to row {}, column {}", row + 1, column + 1);
            let last = numbers.last().unwrap_or(at);
            last.trouble(format!("there are only {} weights", numbers.len()), reason, "add those that are missing")
        })?;
        let weight = word.amount("a weight")?;
        for (row, column) in [(row, column), (column, row)] {
            if let Some(slot) = matrix.get_mut(row * count + column) {
                *slot = weight;
            }
            // A full matrix states both directions.
            if layout == "FULL_MATRIX" {
                break;
            }
        }
    }
    match words.next() {
        None => Ok(matrix),
        Some(more) => {
            let reason = format!("the matrix `{layout}` of {count} nodes is complete before this weight");
            Err(more.trouble(
                "there are more weights than the matrix has",
                reason,
                "correct DIMENSION or EDGE_WEIGHT_FORMAT",
            ))
        }
    }
}
