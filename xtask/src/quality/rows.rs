//! Tables of Markdown from tab-separated rows.

/// Returns a table with this head; every line of `text` is a row.
pub(super) fn table(head: &[&str], text: &str) -> String {
    let mut table = format!("| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let mut cells: Vec<&str> = line.split('\t').map(str::trim).collect();
        cells.resize(head.len(), "");
        table += &format!("| {} |\n", cells.join(" | "));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::table;

    #[test]
    fn short_rows_are_filled_and_empty_lines_dropped() {
        assert_eq!(table(&["a", "b"], "x\t1\n\ny\n"), "| a | b |\n|---|---|\n| x | 1 |\n| y |  |\n");
    }
}
