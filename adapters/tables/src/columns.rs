//! Tables written as a whole, column by column.

use crate::parquet_writer::{column, failed, field};
use parquet::basic::Type as Physical;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::{self, Write};
use std::sync::Arc;

/// The cells of a column, in the order of the rows.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Integers.
    Integers(Vec<i64>),
    /// Numbers; `None` in a row without a value.
    Numbers(Vec<Option<f64>>),
    /// Texts.
    Texts(Vec<String>),
}

impl Cells {
    fn len(&self) -> usize {
        match self {
            Cells::Integers(cells) => cells.len(),
            Cells::Numbers(cells) => cells.len(),
            Cells::Texts(cells) => cells.len(),
        }
    }

    /// Returns the cell of a row as CSV: a missing number is empty.
    fn text(&self, row: usize) -> String {
        match self {
            Cells::Integers(cells) => cells.get(row).map(ToString::to_string),
            Cells::Numbers(cells) => cells.get(row).copied().flatten().map(|number| number.to_string()),
            Cells::Texts(cells) => cells.get(row).cloned(),
        }
        .unwrap_or_default()
    }
}

/// Writes named columns of equal length as CSV (RFC 4180), or as Parquet with one row group.
///
/// # Errors
/// The output cannot be written.
pub fn write_columns<W: Write + Send>(output: W, is_parquet: bool, columns: &[(&str, Cells)]) -> io::Result<()> {
    if is_parquet {
        return write_parquet(output, columns).map_err(failed);
    }
    let mut writer = csv::Writer::from_writer(output);
    writer.write_record(columns.iter().map(|(name, _)| name))?;
    let rows = columns.iter().map(|(_, cells)| cells.len()).max().unwrap_or_default();
    for row in 0..rows {
        writer.write_record(columns.iter().map(|(_, cells)| cells.text(row)))?;
    }
    writer.flush()
}

fn write_parquet<W: Write + Send>(output: W, columns: &[(&str, Cells)]) -> Result<(), ParquetError> {
    let properties = WriterProperties::builder().set_created_by(format!("apex {}", env!("CARGO_PKG_VERSION"))).build();
    let fields = columns.iter().map(|(name, cells)| match cells {
        Cells::Integers(_) => field(name, Physical::INT64, true),
        Cells::Numbers(_) => field(name, Physical::DOUBLE, false),
        Cells::Texts(_) => field(name, Physical::BYTE_ARRAY, true),
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("rows").with_fields(fields).build()?;
    let mut writer = SerializedFileWriter::new(output, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, cells) in columns {
        match cells {
            Cells::Integers(cells) => column::<Int64Type, _>(&mut group, cells.iter().copied().map(Some), true)?,
            Cells::Numbers(cells) => column::<DoubleType, _>(&mut group, cells.iter().copied(), false)?,
            Cells::Texts(cells) => {
                let bytes = cells.iter().map(|text| Some(ByteArray::from(text.as_bytes().to_vec())));
                column::<ByteArrayType, _>(&mut group, bytes, true)?;
            }
        }
    }
    group.close()?;
    writer.finish().map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};

    fn columns() -> Vec<(&'static str, Cells)> {
        vec![
            ("seed", Cells::Integers(vec![1, 2])),
            ("score", Cells::Numbers(vec![Some(0.5), None])),
            ("reason", Cells::Texts(vec!["done, \"well\"".into(), "lost".into()])),
        ]
    }

    #[test]
    fn both_formats_hold_the_same_cells() {
        let mut csv = Vec::new();
        write_columns(&mut csv, false, &columns()).unwrap();
        assert_eq!(String::from_utf8(csv).unwrap(), "seed,score,reason\n1,0.5,\"done, \"\"well\"\"\"\n2,,lost\n");
        let path = tempfile::NamedTempFile::new().unwrap();
        write_columns(path.reopen().unwrap(), true, &columns()).unwrap();
        let reader = SerializedFileReader::new(path.reopen().unwrap()).unwrap();
        let rows: Vec<String> = reader.get_row_iter(None).unwrap().map(|row| row.unwrap().to_string()).collect();
        assert_eq!(
            rows,
            ["{seed: 1, score: 0.5, reason: \"done, \"well\"\"}", "{seed: 2, score: null, reason: \"lost\"}"]
        );
    }
}
