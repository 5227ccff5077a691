//! Storage of figures that Criterion does not measure, in a folder that the report reads.

use serde_json::{Map, Value, json};
use std::path::Path;

/// Environment variable that names the folder; without it no figures are stored.
pub const FOLDER: &str = "APEX_BENCH_ROWS";

/// Stores the figures of one row of the report, by count: nanoseconds, or bytes if the row measures memory.
///
/// # Errors
/// If the file cannot be written.
pub fn keep(group: &str, function: &str, figures: &[(u64, f64)]) -> std::io::Result<()> {
    let Some(folder) = std::env::var_os(FOLDER) else { return Ok(()) };
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let figures: Map<String, Value> =
        figures.iter().map(|(count, figure)| (count.to_string(), json!(figure))).collect();
    let file = format!("{group} {function}.json").replace([' ', '/'], "-");
    std::fs::write(folder.join(file), json!({ "group": group, "function": function, "rows": figures }).to_string())
}
