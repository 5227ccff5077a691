//! Rust text with comments, strings and characters blanked out, for safe counting of braces and words.
//!
//! Not a full lexer: it handles nested block comments, escapes, raw and byte strings, and distinguishes lifetimes from characters.

/// Returns `source` with the same lines, with everything except code replaced by spaces.
pub(crate) fn code_only(source: &str) -> String {
    masked(source, true)
}

/// Returns `source` with the same lines, with everything except comments, strings and character literals replaced by spaces.
pub(crate) fn prose_only(source: &str) -> String {
    masked(source, false)
}

fn masked(source: &str, keep_code: bool) -> String {
    let characters: Vec<char> = source.chars().collect();
    let mut masked = String::with_capacity(source.len());
    let mut position = 0;
    while position < characters.len() {
        let length = blank_length(&characters, position);
        let end = (position + length.max(1)).min(characters.len());
        let part = characters.get(position..end).unwrap_or_default();
        let kept = keep_code == (length == 0);
        masked.extend(part.iter().map(|character| if kept || *character == '\n' { *character } else { ' ' }));
        position = end;
    }
    masked
}

/// Returns the length of the comment, string or character literal at `position`; 0 if it is code.
fn blank_length(text: &[char], position: usize) -> usize {
    let at = |offset: usize| text.get(position + offset).copied().unwrap_or('\0');
    match at(0) {
        '/' if at(1) == '/' => until(text, position, |c| c == '\n'),
        '/' if at(1) == '*' => block_comment(text, position),
        '"' => quoted(text, position, 1),
        'r' | 'b' | 'c' if !joins_word(text, position) => prefixed_string(text, position),
        '\'' => character_literal(text, position),
        _ => 0,
    }
}

/// Returns true if the character before `position` is part of the same word.
fn joins_word(text: &[char], position: usize) -> bool {
    position.checked_sub(1).and_then(|before| text.get(before)).is_some_and(|c| c.is_alphanumeric() || *c == '_')
}

fn until(text: &[char], position: usize, stop: impl Fn(char) -> bool) -> usize {
    text.iter().skip(position).take_while(|c| !stop(**c)).count()
}

fn block_comment(text: &[char], position: usize) -> usize {
    let (mut depth, mut length) = (0usize, 0);
    loop {
        match (text.get(position + length), text.get(position + length + 1)) {
            (Some('/'), Some('*')) => (depth, length) = (depth + 1, length + 2),
            (Some('*'), Some('/')) => {
                (depth, length) = (depth - 1, length + 2);
                if depth == 0 {
                    return length;
                }
            }
            (Some(_), _) => length += 1,
            (None, _) => return length,
        }
    }
}

/// Returns the length of a string with escapes whose opening quote ends `opening` characters after `position`.
fn quoted(text: &[char], position: usize, opening: usize) -> usize {
    let mut length = opening;
    loop {
        match text.get(position + length) {
            Some('\\') => length += 2,
            Some('"') => return length + 1,
            Some(_) => length += 1,
            None => return length,
        }
    }
}

/// Returns the length of `b".."`, `c".."`, `r".."`, `br##".."##`; 0 for a plain word or a raw identifier.
fn prefixed_string(text: &[char], position: usize) -> usize {
    let letters = until(text, position, |c| !matches!(c, 'r' | 'b' | 'c'));
    let raw = text.iter().skip(position).take(letters).any(|c| *c == 'r');
    let hashes = if raw { until(text, position + letters, |c| c != '#') } else { 0 };
    let opening = letters + hashes + 1;
    if letters > 2 || text.get(position + letters + hashes) != Some(&'"') {
        let byte_character = letters == 1 && text.get(position + 1) == Some(&'\'') && !raw;
        return if byte_character { 1 + character_literal(text, position + 1) } else { 0 };
    }
    if !raw {
        return quoted(text, position, opening);
    }
    let mut length = opening;
    while let Some(character) = text.get(position + length) {
        length += 1;
        if *character == '"' && until(text, position + length, |c| c != '#') >= hashes {
            return length + hashes;
        }
    }
    length
}

/// Returns the length of `'x'`, `'\n'`, `'\u{1F681}'`; 0 for a lifetime.
fn character_literal(text: &[char], position: usize) -> usize {
    match (text.get(position + 1), text.get(position + 2)) {
        (Some('\\'), _) => 3 + until(text, position + 3, |c| c == '\'') + 1,
        (Some(_), Some('\'')) => 3,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::code_only;

    #[test]
    fn braces_in_texts_do_not_count() {
        let source = "a /* { /* { */ */ b \"{\\\"{\" r#\"{\"{\"# b'{' '{' '\\'' 'life: {}";
        let masked = code_only(source);
        assert_eq!(masked.matches('{').count(), 1, "{masked}");
        assert_eq!(masked.chars().count(), source.chars().count());
        assert!(masked.contains("'life"), "{masked}");
    }

    #[test]
    fn lines_stay_where_they_are() {
        assert_eq!(code_only("x // }\ny \"\n}\" z"), "x     \ny  \n   z");
    }

    #[test]
    fn unfinished_texts_end_with_the_file() {
        for source in ["\"{", "/* {", "r#\"{", "'"] {
            assert!(!code_only(source).contains('{'), "{source}");
        }
    }
}
