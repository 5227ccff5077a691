//! Symbols: case-insensitive names, folded for matching and printed as written (`pdl.md`, Text).

use rustc_hash::FxBuildHasher;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::cmp::Ordering;
use std::fmt;
use std::hash::{BuildHasher, Hash, Hasher};
use std::sync::Arc;

/// A name of PDL. Two symbols are equal when they differ in case only.
#[derive(Clone)]
pub struct Symbol(Arc<SymbolText>);

struct SymbolText {
    folded: Box<str>,
    printed: Option<Box<str>>,
    /// Hash of the folded text: symbols with different hashes differ.
    hash: u64,
    /// The first eight bytes of the folded text as one number, which orders most symbols without their texts.
    prefix: u64,
}

/// Returns the first eight bytes of `text` as a number, the first byte most significant; a shorter text is padded with zeros.
fn prefix(text: &str) -> u64 {
    let mut bytes = [0; 8];
    bytes.iter_mut().zip(text.bytes()).for_each(|(place, byte)| *place = byte);
    u64::from_be_bytes(bytes)
}

impl Symbol {
    /// Returns the symbol written as `text`.
    pub fn new(text: &str) -> Symbol {
        let folded: Box<str> = text.to_lowercase().into();
        let printed = (*folded != *text).then(|| text.into());
        let (hash, prefix) = (FxBuildHasher.hash_one(&*folded), prefix(&folded));
        Symbol(Arc::new(SymbolText { folded, printed, hash, prefix }))
    }

    /// Returns the folded (lower case) text: the symbol's identity.
    pub fn folded(&self) -> &str {
        &self.0.folded
    }

    /// Returns the text as written by its author.
    pub fn printed(&self) -> &str {
        self.0.printed.as_deref().unwrap_or(&self.0.folded)
    }

    /// Returns true if this is the symbol with the folded text `folded`.
    pub fn is(&self, folded: &str) -> bool {
        &*self.0.folded == folded
    }
}

impl PartialEq for Symbol {
    fn eq(&self, other: &Symbol) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || (self.0.hash == other.0.hash && self.0.folded == other.0.folded)
    }
}

impl Eq for Symbol {}

impl PartialOrd for Symbol {
    fn partial_cmp(&self, other: &Symbol) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Symbol {
    fn cmp(&self, other: &Symbol) -> Ordering {
        if Arc::ptr_eq(&self.0, &other.0) {
            return Ordering::Equal;
        }
        self.0.prefix.cmp(&other.0.prefix).then_with(|| self.0.folded.cmp(&other.0.folded))
    }
}

impl Hash for Symbol {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.0.hash);
    }
}

impl From<&str> for Symbol {
    fn from(text: &str) -> Symbol {
        Symbol::new(text)
    }
}

impl fmt::Display for Symbol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.printed())
    }
}

impl fmt::Debug for Symbol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.printed())
    }
}

impl Serialize for Symbol {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.printed())
    }
}

impl<'de> Deserialize<'de> for Symbol {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Symbol, D::Error> {
        let text = <std::borrow::Cow<'de, str>>::deserialize(deserializer)?;
        Ok(Symbol::new(&text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_are_ordered_as_their_folded_texts() {
        let texts =
            ["", "a", "a\0", "a\0b", "ab", "abcdefg", "abcdefgh", "abcdefghi", "ABCDEFGHJ", "abcdefgé", "é", "z", "Ab"];
        for one in texts {
            for other in texts {
                let expected = one.to_lowercase().cmp(&other.to_lowercase());
                assert_eq!(Symbol::new(one).cmp(&Symbol::new(other)), expected, "{one:?} {other:?}");
            }
        }
    }
}
