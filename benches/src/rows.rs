//! Figures that are not taken by Criterion, kept where the report finds them.

use serde_json::{Map, Value, json};
use std::path::Path;

/// The environment variable that names the folder of these figures; without it none are kept.
pub const FOLDER: &str = "APEX_BENCH_ROWS";

/// Keeps the figures of one row, by count: nanoseconds, or bytes where the row counts memory.
///
/// # Errors
/// When the file cannot be written.
pub fn keep(group: &str, function: &str, figures: &[(u64, f64)]) -> std::io::Result<()> {
    let Some(folder) = std::env::var_os(FOLDER) else { return Ok(()) };
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let figures: Map<String, Value> =
        figures.iter().map(|(count, figure)| (count.to_string(), json!(figure))).collect();
    let file = format!("{group} {function}.json").replace([' ', '/'], "-");
    std::fs::write(folder.join(file), json!({ "group": group, "function": function, "rows": figures }).to_string())
}
