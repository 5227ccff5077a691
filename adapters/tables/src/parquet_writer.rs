//! Tables as Parquet: one column for each field, rows in groups; absent values are null.

use crate::{Row, TableWriter};
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};
use std::io::{self, Write};
use std::sync::Arc;

/// Rows in one group, which is held in memory.
const GROUP_ROWS: usize = 1 << 16;

/// Writes Parquet.
pub struct ParquetWriter<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    rows: Vec<Row>,
}

impl<W: Write + Send> ParquetWriter<W> {
    /// Returns a table on `output`; `facts` become its metadata.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn new(output: W, facts: Vec<(String, String)>) -> io::Result<ParquetWriter<W>> {
        let facts = facts.into_iter().map(|(key, value)| KeyValue::new(key, value)).collect();
        let properties = WriterProperties::builder()
            .set_created_by(format!("apex {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some(facts))
            .build();
        let schema = schema().map_err(failed)?;
        let writer = SerializedFileWriter::new(output, schema, Arc::new(properties)).map_err(failed)?;
        Ok(ParquetWriter { writer, rows: Vec::new() })
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let rows = std::mem::take(&mut self.rows);
        let mut group = self.writer.next_row_group()?;
        let text = |text: &str| ByteArray::from(text.as_bytes().to_vec());
        column::<Int64Type, _>(&mut group, rows.iter().map(|row| Some(row.number)), true)?;
        column::<Int64Type, _>(&mut group, rows.iter().map(|row| Some(row.t_ns)), true)?;
        column::<Int64Type, _>(&mut group, rows.iter().map(|row| Some(row.arrived_ns)), true)?;
        column::<ByteArrayType, _>(&mut group, rows.iter().map(|row| Some(text(row.kind))), true)?;
        column::<ByteArrayType, _>(&mut group, rows.iter().map(|row| Some(text(&row.name))), true)?;
        column::<DoubleType, _>(&mut group, rows.iter().map(|row| row.value), false)?;
        column::<ByteArrayType, _>(&mut group, rows.iter().map(|row| row.unit.map(text)), false)?;
        column::<ByteArrayType, _>(&mut group, rows.iter().map(|row| row.text.as_deref().map(text)), false)?;
        column::<ByteArrayType, _>(&mut group, rows.iter().map(|row| Some(text(row.status))), true)?;
        group.close().map(|_| ())
    }
}

pub(crate) fn failed(error: ParquetError) -> io::Error {
    io::Error::other(error.to_string())
}

/// Returns the columns of [`crate::COLUMNS`].
fn schema() -> Result<TypePtr, ParquetError> {
    let [number, t_ns, arrived_ns, kind, name, value, unit, text, status] = crate::COLUMNS;
    let fields = vec![
        field(number, Physical::INT64, true)?,
        field(t_ns, Physical::INT64, true)?,
        field(arrived_ns, Physical::INT64, true)?,
        field(kind, Physical::BYTE_ARRAY, true)?,
        field(name, Physical::BYTE_ARRAY, true)?,
        field(value, Physical::DOUBLE, false)?,
        field(unit, Physical::BYTE_ARRAY, false)?,
        field(text, Physical::BYTE_ARRAY, false)?,
        field(status, Physical::BYTE_ARRAY, true)?,
    ];
    Ok(Arc::new(Type::group_type_builder("history").with_fields(fields).build()?))
}

/// Returns a column of numbers or, as UTF-8, of texts.
pub(crate) fn field(name: &str, physical: Physical, required: bool) -> Result<TypePtr, ParquetError> {
    let words = if physical == Physical::BYTE_ARRAY { ConvertedType::UTF8 } else { ConvertedType::NONE };
    let repetition = if required { Repetition::REQUIRED } else { Repetition::OPTIONAL };
    let builder = Type::primitive_type_builder(name, physical).with_repetition(repetition);
    builder.with_converted_type(words).build().map(Arc::new)
}

/// Writes the next column of a group.
pub(crate) fn column<T: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: impl Iterator<Item = Option<T::T>>,
    required: bool,
) -> Result<(), ParquetError> {
    let Some(mut writer) = group.next_column()? else { return Ok(()) };
    let mut values = Vec::new();
    let mut levels = Vec::new();
    for cell in cells {
        levels.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    writer.typed::<T>().write_batch(&values, (!required).then_some(&levels), None)?;
    writer.close()
}

impl<W: Write + Send> TableWriter for ParquetWriter<W> {
    fn write(&mut self, row: Row) -> io::Result<()> {
        self.rows.push(row);
        if self.rows.len() >= GROUP_ROWS { self.write_group().map_err(failed) } else { Ok(()) }
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        if !self.rows.is_empty() {
            self.write_group().map_err(failed)?;
        }
        self.writer.finish().map(|_| ()).map_err(failed)
    }
}
