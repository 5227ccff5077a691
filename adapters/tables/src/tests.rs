//! Round trips of tables.

use super::*;
use apex_model::quantity::Quantity;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;

fn rows() -> Vec<Row> {
    let roll = StateVariable::new(Symbol::new("roll-angle"), Value::symbol("uav"));
    let mode = StateVariable::new(Symbol::new("mode"), Value::symbol("uav"));
    let degrees = Symbol::new("deg");
    let value = Value::Quantity(Quantity::of(0.5, unit_named("rad").unwrap()));
    vec![
        Row::sample((1, Time(5), Time(7)), &roll, &value, Some(&degrees), Some(Recorded::Appended)),
        Row::sample((2, Time(6), Time(7)), &mode, &Value::symbol("auto, manual"), None, Some(Recorded::TooLate)),
        Row::sample((3, Time(6), Time(8)), &roll, &Value::symbol("steep"), Some(&degrees), None),
        Row::event((4, Time(9), Time(9)), &Value::list([Value::symbol("go")])),
    ]
}

#[test]
fn numbers_are_in_the_declared_unit() {
    let first = rows().remove(0);
    assert_eq!((first.value.unwrap().round(), first.unit, first.status), (29.0, Some("deg"), "kept"));
    assert_eq!(rows()[2].status, "refused");
}

#[test]
fn csv_has_a_row_for_each() {
    let mut bytes = Vec::new();
    let mut writer = Box::new(CsvWriter::new(&mut bytes).unwrap());
    rows().into_iter().for_each(|row| writer.write(row).unwrap());
    writer.finish().unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "number,t_ns,arrived_ns,kind,name,value,unit,text,status");
    assert_eq!(lines[2], "2,6,7,sample,(mode uav),,,\"auto, manual\",late");
    assert_eq!(lines[4], "4,9,9,event,(go),,,,kept");
}

#[test]
fn parquet_is_read_as_it_was_written() {
    let file = tempfile::tempfile().unwrap();
    let facts = vec![("unit (roll-angle uav)".to_string(), "deg".to_string())];
    let mut writer = Box::new(ParquetWriter::new(file.try_clone().unwrap(), facts).unwrap());
    // More than one group.
    let many: Vec<Row> = rows().into_iter().cycle().take(70_000).collect();
    many.iter().cloned().for_each(|row| writer.write(row).unwrap());
    writer.finish().unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let metadata = reader.metadata().file_metadata();
    assert_eq!(metadata.num_rows(), 70_000);
    let facts = metadata.key_value_metadata().unwrap();
    assert!(facts.iter().any(|fact| fact.key == "unit (roll-angle uav)" && fact.value.as_deref() == Some("deg")));
    for (row, written) in reader.get_row_iter(None).unwrap().zip(&many) {
        let row = row.unwrap();
        assert_eq!((row.get_long(0).unwrap(), row.get_long(1).unwrap()), (written.number, written.t_ns));
        assert_eq!(row.get_string(4).unwrap(), &written.name);
        assert_eq!(row.get_double(5).ok(), written.value);
        assert_eq!(row.get_string(6).ok().map(String::as_str), written.unit);
        assert_eq!(row.get_string(8).unwrap(), written.status);
    }
}
