//! `apex export`: writes the samples and events of a flight record, a log or JSON lines as a table.

use crate::error::{CliError, CliResult, read_text};
use crate::options::{ExportFormat, ExportOptions};
use crate::output::Listened;
use crate::{sources, table_file};
use apex_executive::MonitorSession;
use apex_log_monitor::Source;
use apex_model::library::Library;
use apex_pdl::SourceText;
use apex_tables::{CsvWriter, ParquetWriter, SampleTable, TableWriter};
use std::path::Path;
use std::sync::Arc;

/// Writes every sample and event with its use.
pub fn run(options: &ExportOptions) -> CliResult {
    let note = |line: &str| crate::output::print_error(line);
    let mut source = Source::of(&options.inputs, options.mapping.as_deref(), options.log_time, &note)?;
    let library = Arc::new(library(options, &mut source)?);
    let session = MonitorSession::new(Arc::clone(&library), sources::host_functions())
        .map_err(|reason| CliError::user("the library cannot be used").because(reason))?;
    let out = options.out.as_deref().filter(|path| path.as_os_str() != "-");
    if let Some(path) = out {
        table_file::refuse_to_overwrite(path, std::slice::from_ref(&options.inputs), "--out")?;
    }
    let format = format_of(options, out)?;
    let standard = Listened::standard();
    let gone = standard.gone();
    let writer: Box<dyn TableWriter> = match (format, out) {
        (ExportFormat::Csv, None) => {
            Box::new(CsvWriter::new(standard).map_err(|error| table_file::unwritten(None, &error))?)
        }
        (ExportFormat::Csv, Some(path)) => {
            Box::new(CsvWriter::new(table_file::created(path)?).map_err(|error| table_file::unwritten(out, &error))?)
        }
        (ExportFormat::Parquet, Some(path)) => Box::new(
            ParquetWriter::new(table_file::created(path)?, facts(&library))
                .map_err(|error| table_file::unwritten(out, &error))?,
        ),
        (ExportFormat::Parquet, None) => {
            return Err(CliError::user("a Parquet table needs a file").help("name it with `--out FILE.parquet`"));
        }
    };
    let mut table = SampleTable::new(session, writer);
    let fed = source.feed(&library, None, &note, &mut |at, kind| {
        table.write(at, kind).map_err(|error| table_file::unwritten(out, &error))
    });
    if gone.get() {
        return Ok(());
    }
    // The table is completed before an error of reading is returned: it keeps the rows that were read before the error.
    let rows = table.finish().map_err(|error| table_file::unwritten(out, &error))?;
    fed?;
    if let Some(path) = out {
        crate::output::print_error(format_args!("{rows} rows in {}", path.display()));
    }
    Ok(())
}

fn library(options: &ExportOptions, source: &mut Source) -> CliResult<Library> {
    let mut texts: Vec<SourceText> = Vec::new();
    for path in &options.library {
        texts.push(SourceText { name: path.display().to_string(), text: read_text(path)? });
    }
    let folder = options.library.first().and_then(|path| path.parent()).map(Path::to_path_buf).unwrap_or_default();
    texts.extend(source.recorded_texts(texts.is_empty())?);
    let known = sources::check_texts(texts.clone(), &folder);
    if let Some(declarations) = source.declarations(&known.library)? {
        texts.push(declarations);
    }
    let checked = sources::check_texts(texts, &folder);
    if checked.has_errors() {
        sources::print_warnings_and_errors(&checked);
        return Err(CliError::already_reported());
    }
    Ok(checked.library)
}

/// Returns the requested format, otherwise that of the file name.
fn format_of(options: &ExportOptions, out: Option<&Path>) -> CliResult<ExportFormat> {
    let extension = out.and_then(Path::extension).map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match (options.format, extension.as_deref()) {
        (Some(format), _) => Ok(format),
        (None, Some("parquet" | "pq")) => Ok(ExportFormat::Parquet),
        (None, None | Some("csv")) => Ok(ExportFormat::Csv),
        (None, Some(other)) => Err(CliError::user(format!("the ending `.{other}` does not determine the format"))
            .help("add `--format csv` or `--format parquet`")),
    }
}

/// Returns the units of the state variables and the meaning of the columns.
fn facts(library: &Library) -> Vec<(String, String)> {
    let unit =
        |(attribute, declared): (&apex_model::symbol::Symbol, &apex_model::library::StateVariableDeclaration)| {
            declared.unit.as_ref().map(|unit| (format!("unit {attribute}"), unit.to_string()))
        };
    let mut facts: Vec<(String, String)> = library.state_variables.iter().filter_map(unit).collect();
    facts.push(("t_ns".into(), "nanoseconds of mission time".into()));
    facts
}
