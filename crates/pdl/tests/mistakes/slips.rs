//! Typing errors in a word.

use super::chance::Chance;

const ROWS: [&str; 3] = ["qwertyuiop", "asdfghjkl", "zxcvbnm"];

/// Returns `word` with one typing error: a letter dropped, doubled, swapped with the next or replaced by a neighbouring key, or a hyphen
/// written as an underscore or left out.
pub fn misspelt(chance: &mut Chance, word: &str) -> String {
    let letters: Vec<char> = word.chars().collect();
    let mut slipped = letters.clone();
    let at = chance.below(letters.len());
    if letters[at] == '-' || letters[at] == '_' {
        slipped[at] = '_';
        if chance.below(2) == 0 {
            slipped.remove(at);
        }
        return slipped.into_iter().collect();
    }
    match chance.below(4) {
        0 if letters.len() > 2 => {
            slipped.remove(at);
        }
        1 => slipped.insert(at, letters[at]),
        2 if at + 1 < letters.len() && letters[at + 1] != '-' => slipped.swap(at, at + 1),
        _ => slipped[at] = neighbour(chance, letters[at]),
    }
    slipped.into_iter().collect()
}

fn neighbour(chance: &mut Chance, letter: char) -> char {
    for row in ROWS {
        let keys: Vec<char> = row.chars().collect();
        if let Some(at) = keys.iter().position(|key| *key == letter) {
            let left = at.checked_sub(1).map(|at| keys[at]);
            let beside: Vec<char> = left.into_iter().chain(keys.get(at + 1).copied()).collect();
            return *chance.pick(&beside).unwrap();
        }
    }
    'x'
}
