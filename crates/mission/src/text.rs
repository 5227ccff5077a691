//! Text layout of reports: words and columns.

use apex_model::time::Duration;

/// Maximum width of lines for operators.
const LINE_WIDTH: usize = 100;
/// Indent of the text next to the times of a history.
const TIME_INDENT: &str = "                ";
/// The narrowest column of names.
const NAME_WIDTH_MIN: usize = 10;

/// Returns a duration as text: `22 h 4 min 56 s`, `4 min 3 s`, `13.5 s`.
pub fn plain_duration(duration: Duration) -> String {
    let seconds = duration.seconds();
    if seconds < 60.0 {
        let text = format!("{seconds:.1}");
        return format!("{} s", text.strip_suffix(".0").unwrap_or(&text));
    }
    let whole = seconds.round() as u64;
    let parts = [(whole / 3600, "h"), (whole / 60 % 60, "min"), (whole % 60, "s")];
    let words: Vec<String> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, unit)| format!("{count} {unit}")).collect();
    words.join(" ")
}

/// Returns the width of a column that fits its heading and all of its names.
pub fn name_width<'a>(heading: &str, names: impl IntoIterator<Item = &'a str>) -> usize {
    let longest = names.into_iter().map(|name| name.chars().count()).max().unwrap_or(0);
    longest.max(heading.chars().count()).max(NAME_WIDTH_MIN)
}

/// Returns words joined by `joint` in lines of at most [`LINE_WIDTH`]; later lines begin with `indent`, and `used` columns of the first
/// line are occupied.
pub fn wrapped(words: &[String], joint: &str, used: usize, indent: &str) -> String {
    let mut text = String::new();
    let mut width = used;
    for (index, word) in words.iter().enumerate() {
        let piece = if index + 1 < words.len() { format!("{word}{joint}") } else { word.clone() };
        let length = piece.chars().count();
        if index > 0 && width + length > LINE_WIDTH {
            text.truncate(text.trim_end().len());
            text.push('\n');
            text.push_str(indent);
            width = indent.len();
        }
        text.push_str(&piece);
        width += length;
    }
    text
}

/// Wraps one line; text after a leading time is aligned next to the time.
pub fn wrapped_line(line: &str) -> String {
    let words: Vec<String> = line.split(' ').map(str::to_string).collect();
    let leading = line.len() - line.trim_start().len();
    // A moment of a history is aligned next to its time; other lines get a deeper indent.
    let moment = line.trim_start().split_once("  ").is_some_and(|(time, _)| !time.contains(' '));
    let indent = if moment && leading > 2 { TIME_INDENT.to_owned() } else { " ".repeat(leading.max(2) + 2) };
    wrapped(&words, " ", 0, &indent)
}

/// Returns a name in a column of `width`, with its text wrapped in the next column.
pub fn named(name: &str, width: usize, text: &str) -> String {
    let words: Vec<String> = text.split(' ').map(str::to_string).collect();
    format!("  {name:<width$}  {}", wrapped(&words, " ", width + 4, &" ".repeat(width + 4)))
}

/// Quotes a word that a command line would interpret.
pub fn shell_word(word: &str) -> String {
    let plain = |character: char| character.is_alphanumeric() || "-_./+,:@".contains(character);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_string();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_read_as_they_are_spoken() {
        let said = |seconds: f64| plain_duration(Duration::from_seconds(seconds));
        assert_eq!(said(79_495.896), "22 h 4 min 56 s");
        assert_eq!(said(243.146), "4 min 3 s");
        assert_eq!(said(3600.0), "1 h");
        assert_eq!(said(13.5), "13.5 s");
        assert_eq!(said(0.0), "0 s");
        assert_eq!(said(59.99), "60 s");
    }

    #[test]
    fn long_texts_continue_in_their_column() {
        let text = named("cabin", 10, &"word ".repeat(25));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(lines[0].starts_with("  cabin       word ") && lines[0].len() <= LINE_WIDTH, "{text}");
        assert!(lines[1].starts_with("              word "), "{text}");
    }

    #[test]
    fn a_history_continues_next_to_its_times() {
        let line = format!("         13.5s  {}", "word ".repeat(20).trim_end());
        let text = wrapped_line(&line);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2, "{text}");
        assert_eq!(lines[0].len(), 95, "as full as can be: {text}");
        assert!(lines[1].starts_with("                word"), "{text}");
        assert_eq!(wrapped_line("short"), "short");
        assert_eq!(wrapped_line(""), "");
    }

    #[test]
    fn words_are_quoted_for_the_shell_where_needed() {
        assert_eq!(shell_word("a/b-1.apex"), "a/b-1.apex");
        assert_eq!(shell_word("my flight.apex"), "'my flight.apex'");
        assert_eq!(shell_word("it's"), "'it'\\''s'");
    }
}
