//! Typing errors in a word.

use super::rng::TestRng;

const ROWS: [&str; 3] = ["qwertyuiop", "asdfghjkl", "zxcvbnm"];

/// Returns `word` with one typing error: a letter dropped, doubled, swapped with the next or replaced by a neighbouring key, or a hyphen
/// written as an underscore or left out.
pub fn misspelt(rng: &mut TestRng, word: &str) -> String {
    let letters: Vec<char> = word.chars().collect();
    let mut slipped = letters.clone();
    let at = rng.below(letters.len());
    if letters[at] == '-' || letters[at] == '_' {
        slipped[at] = '_';
        if rng.below(2) == 0 {
            slipped.remove(at);
        }
        return slipped.into_iter().collect();
    }
    match rng.below(4) {
        0 if letters.len() > 2 => {
            slipped.remove(at);
        }
        1 => slipped.insert(at, letters[at]),
        2 if at + 1 < letters.len() && letters[at + 1] != '-' => slipped.swap(at, at + 1),
        _ => slipped[at] = neighbour(rng, letters[at]),
    }
    slipped.into_iter().collect()
}

fn neighbour(rng: &mut TestRng, letter: char) -> char {
    for row in ROWS {
        let keys: Vec<char> = row.chars().collect();
        if let Some(at) = keys.iter().position(|key| *key == letter) {
            let left = at.checked_sub(1).map(|at| keys[at]);
            let beside: Vec<char> = left.into_iter().chain(keys.get(at + 1).copied()).collect();
            return *rng.pick(&beside).unwrap();
        }
    }
    'x'
}
