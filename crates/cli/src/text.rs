//! Text for reports and shells.

pub use apex_mission::text::{plain_duration, wrapped_line};

/// Quotes a word if the shell would interpret it.
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
    fn words_are_quoted_for_the_shell_where_needed() {
        assert_eq!(shell_word("a/b-1.apex"), "a/b-1.apex");
        assert_eq!(shell_word("my flight.apex"), "'my flight.apex'");
        assert_eq!(shell_word("it's"), "'it'\\''s'");
    }
}
