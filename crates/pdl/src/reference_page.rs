//! Text of the reference pages about a word: rows of tables, lines of grammar and sentences, for `apex explain`.

use std::fmt::Write as _;

/// Pages that are searched, in this order.
const PAGES: [(&str, &str); 2] = [
    ("docs/reference/pdl.md", include_str!("../../../docs/reference/pdl.md")),
    ("docs/reference/conditions.md", include_str!("../../../docs/reference/conditions.md")),
];
/// Pages about missions and flights. They are searched for a word that the pages about the language do not have.
const PAGES_OF_MISSIONS: [(&str, &str); 6] = [
    ("docs/reference/mission-data.md", include_str!("../../../docs/reference/mission-data.md")),
    ("docs/reference/requirements.md", include_str!("../../../docs/reference/requirements.md")),
    ("docs/reference/travel.md", include_str!("../../../docs/reference/travel.md")),
    ("docs/reference/manoeuvres.md", include_str!("../../../docs/reference/manoeuvres.md")),
    ("docs/reference/simulator.md", include_str!("../../../docs/reference/simulator.md")),
    ("docs/reference/world.md", include_str!("../../../docs/reference/world.md")),
];
/// Finds the places of a word in a page: a heading and a text for each.
type Finder = fn(&str, &str) -> Vec<(String, String)>;

/// Number of places that are shown.
const SHOWN_MAX: usize = 4;

/// Returns what the reference says about a clause or keyword: the table rows that begin with it, then lines of grammar and sentences that
/// have it in a form. `None` if no page has it.
pub(crate) fn explain(word: &str) -> Option<String> {
    if word.is_empty() {
        return None;
    }
    in_pages(&PAGES, word).or_else(|| in_pages(&PAGES_OF_MISSIONS, word))
}

fn in_pages(pages: &[(&str, &str)], word: &str) -> Option<String> {
    let mut text = String::new();
    let kinds: [Finder; 2] = [of_rows, of_text];
    let places = kinds.into_iter().flat_map(|kind| pages.iter().map(move |(name, page)| (name, kind(page, word))));
    let places = places.flat_map(|(name, places)| places.into_iter().map(move |place| (name, place)));
    for (name, (heading, place)) in places.take(SHOWN_MAX) {
        let below = if heading.is_empty() { String::new() } else { format!(", \"{heading}\"") };
        let _ = writeln!(text, "{name}{below}:\n  {place}");
    }
    (!text.is_empty()).then_some(text)
}

/// Returns the rows whose first cell has the word, each with the heading above it.
fn of_rows(page: &str, word: &str) -> Vec<(String, String)> {
    let of_row = |(heading, line): (&str, &str)| {
        let cells: Vec<&str> = line.strip_prefix('|')?.strip_suffix('|')?.split(" | ").map(str::trim).collect();
        let (first, rest) = cells.split_first()?;
        has(first, word).then(|| (heading.to_string(), format!("{}: {}", plain(first), plain(&rest.join("; ")))))
    };
    under_headings(page).filter_map(of_row).collect()
}

/// Returns the lines of grammar and the sentences that have the word.
fn of_text(page: &str, word: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let (mut paragraph, mut above, mut is_grammar) = (String::new(), String::new(), false);
    for (heading, line) in under_headings(page).chain([("", "")]) {
        if line.starts_with("```") {
            is_grammar = !is_grammar;
        } else if is_grammar {
            if has(line, word) {
                found.push((heading.to_string(), line.trim().to_string()));
            }
        } else if line.is_empty() || line.starts_with(['|', '#']) {
            let sentences = paragraph.split_inclusive(". ").filter(|sentence| has(sentence, word));
            found.extend(sentences.map(|sentence| (above.clone(), plain(sentence.trim()))));
            paragraph.clear();
            let cells = line.strip_prefix('|').and_then(|cells| cells.split_once(" | "));
            if cells.is_some_and(|(first, rest)| has(rest, word) && !has(first, word)) {
                found.push((heading.to_string(), plain(line.trim_matches('|').trim())));
            }
        } else {
            above = heading.to_string();
            let _ = write!(paragraph, "{}{line}", if paragraph.is_empty() { "" } else { " " });
        }
    }
    found
}

/// Returns the lines of a page, each with the heading above it.
fn under_headings(page: &str) -> impl Iterator<Item = (&str, &str)> {
    let mut heading = "";
    page.lines().map(move |line| {
        if let Some(title) = line.strip_prefix("## ") {
            heading = title;
        }
        (heading, line)
    })
}

/// Returns true if the text has the word as a keyword or as the first word of a form.
fn has(text: &str, word: &str) -> bool {
    [format!(":{word}"), format!("({word}")].iter().any(|mark| {
        text.match_indices(&**mark).any(|(at, _)| {
            let continues = |next: char| next.is_alphanumeric() || "-+*?".contains(next);
            let before = text.get(..at).and_then(|before| before.chars().next_back());
            let after = text.get(at + mark.len()..).and_then(|after| after.chars().next());
            !before.is_some_and(|before| before.is_alphanumeric()) && !after.is_some_and(continues)
        })
    })
}

/// Returns the text without marks of emphasis and targets of links.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("](") {
        let (shown, link) = before.rsplit_once('[').unwrap_or((before, ""));
        plain.push_str(shown);
        plain.push_str(link);
        rest = after.split_once(')').map_or("", |(_, after)| after);
    }
    plain.push_str(rest);
    plain.replace(" **+**", "").replace("**+** ", "")
}

#[cfg(test)]
mod tests {
    use super::{PAGES, PAGES_OF_MISSIONS, explain, has, in_pages};
    use crate::words::explain_word;
    use std::collections::BTreeSet;

    /// Returns the keywords in forms of a page, without those of its links and prose.
    fn keywords(page: &str) -> BTreeSet<&str> {
        let words = page.split(|each: char| !(each.is_alphanumeric() || ":-".contains(each)));
        words.filter_map(|word| word.strip_prefix(':')).filter(|word| word.starts_with(char::is_lowercase)).collect()
    }

    #[test]
    fn each_keyword_of_the_reference_is_explained_by_a_place_that_has_it() {
        let mut count = 0;
        for word in PAGES.iter().flat_map(|(_, page)| keywords(page)) {
            let text = explain_word(&format!(":{word}")).unwrap_or_else(|| panic!("`:{word}` is not explained"));
            assert!(text.contains("docs/reference/") && has(&text, word), "`:{word}`: {text}");
            count += 1;
        }
        assert!(count > 100, "{count} keywords");
    }

    #[test]
    fn words_of_missions_are_explained() {
        let commands = [":via", ":hold-around", ":course", ":centre", ":speeds", "flight-time-limit"];
        let requirements = [":clearance", ":reserve", ":at-most", ":lost-for", ":pattern"];
        let modems = [":around", ":ridge", ":sector", ":beyond"];
        let messages = ["truth-fault", "truth-fault-over", "truth-fire", "truth-fire-seen"];
        for word in commands.iter().chain(&requirements).chain(&modems).chain(&messages) {
            let text = explain_word(word).unwrap_or_else(|| panic!("`{word}` is not explained"));
            assert!(text.contains("docs/reference/"), "`{word}`: {text}");
        }
        for word in PAGES_OF_MISSIONS.iter().flat_map(|(_, page)| keywords(page)) {
            assert!(explain_word(&format!(":{word}")).is_some(), "`:{word}` is not explained");
        }
    }

    #[test]
    fn rows_come_before_sentences_and_other_words_have_no_place() {
        let text = explain("waitfor").unwrap();
        assert!(text.starts_with("docs/reference/pdl.md, \"Steps\":\n  `(waitfor C..)`: the preconditions"), "{text}");
        let text = explain("capacity").unwrap();
        assert!(text.contains("has units"), "{text}");
        for word in ["capacit", "", "no-such-word"] {
            assert_eq!(explain(word), None, "{word}");
        }
        assert_eq!(in_pages(&PAGES, "wait"), None, "`waitfor` is another word");
    }
}
