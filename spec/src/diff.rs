//! A human-readable difference of two texts, by lines.

/// Returns lines of `expected` that are missing (`-`), lines of `actual` that are new (`+`), and common lines around them; `None` if the
/// texts are equal.
pub fn lines(expected: &str, actual: &str) -> Option<String> {
    if expected == actual {
        return None;
    }
    let (old, new): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), actual.lines().collect());
    let common = common_lengths(&old, &new);
    let length = |i: usize, j: usize| common.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0);
    let (mut i, mut j) = (0, 0);
    let mut text = String::new();
    loop {
        match (old.get(i), new.get(j)) {
            (Some(a), Some(b)) if a == b => {
                text.push_str(&format!("    {a}\n"));
                (i, j) = (i + 1, j + 1);
            }
            (Some(a), b) if b.is_none() || length(i + 1, j) >= length(i, j + 1) => {
                text.push_str(&format!("  - {a}\n"));
                i += 1;
            }
            (_, Some(b)) => {
                text.push_str(&format!("  + {b}\n"));
                j += 1;
            }
            _ => return Some(text),
        }
    }
}

/// Returns, for every pair of suffixes, the length of their longest common subsequence.
fn common_lengths(old: &[&str], new: &[&str]) -> Vec<Vec<usize>> {
    let mut table = vec![vec![0; new.len() + 1]];
    for a in old.iter().rev() {
        let below = table.last().cloned().unwrap_or_default();
        let mut row = vec![0; new.len() + 1];
        for (j, b) in new.iter().enumerate().rev() {
            let at = |row: &[usize], j: usize| row.get(j).copied().unwrap_or(0);
            let best = if a == b { at(&below, j + 1) + 1 } else { at(&below, j).max(at(&row, j + 1)) };
            if let Some(cell) = row.get_mut(j) {
                *cell = best;
            }
        }
        table.push(row);
    }
    table.reverse();
    table
}

#[cfg(test)]
mod tests {
    use super::lines;

    #[test]
    fn equal_texts_have_no_difference() {
        assert_eq!(lines("a\nb\n", "a\nb\n"), None);
    }

    #[test]
    fn the_difference_keeps_common_lines() {
        assert_eq!(lines("a\nb\nc\n", "a\nx\nc\nd\n").as_deref(), Some("    a\n  - b\n  + x\n    c\n  + d\n"));
    }
}
