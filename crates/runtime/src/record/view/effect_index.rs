//! An index of the log in memory, shared by all views of a record and extended with it: where each time begins, and which blocks of
//! effects may contain a text or a kind.
//!
//! Effects are recorded in order of time, so a time is found by bisection over blocks of effects. For each block the index keeps the
//! kinds in it and a Bloom filter (Bloom 1970) of the n-grams of its texts: a search reads the blocks that may match, the newest first.
//! Bound: each effect is read once; about 4.2 kB of memory for 128 effects.

use crate::error::RecordError;
use crate::record::{EffectKind, EffectNeed, RecordReader};
use std::collections::BTreeMap;

/// Effects of one block: few, as a search reads all of a block that may match.
pub(super) const BLOCK_EFFECTS: i64 = 32;
/// Number of bits of a block's filter.
const FILTER_BITS: usize = 1 << 13;
/// Lengths of the n-grams in bytes: long ones exclude more blocks, short ones serve searches for short texts.
const GRAMS: [usize; 3] = [5, 3, 2];
/// Number of effects that are read at once, a multiple of those of a block: a query that extends the index reads no more than these after
/// its time is over.
const CHUNK_EFFECTS: i64 = 2_048;

/// A block of effects with consecutive numbers.
#[derive(Clone)]
struct EffectBlock {
    first_ns: i64,
    last_ns: i64,
    kinds: u64,
    filter: Box<[u64]>,
}

/// The index.
#[derive(Default)]
pub(super) struct EffectIndex {
    /// Number of blocks that are left out before the first one; none are, but in a continuation.
    left_out: usize,
    blocks: Vec<EffectBlock>,
    /// The last effect that was read.
    seen: i64,
    /// Bits of kinds; kinds beyond 63 share the last bit.
    kinds: BTreeMap<String, u32>,
}

/// Conditions of a search in the log.
pub(super) struct EffectSearch<'a> {
    pub(super) from_ns: i64,
    pub(super) to_ns: i64,
    pub(super) kinds: &'a [String],
    /// In any case of ASCII letters.
    pub(super) find: Option<&'a str>,
}

/// Returns the number of the block of an effect, from 0.
fn block_number(id: i64) -> usize {
    usize::try_from((id - 1).max(0) / BLOCK_EFFECTS).unwrap_or(usize::MAX)
}

impl EffectIndex {
    /// Returns the last effect that the index has.
    pub(super) fn seen(&self) -> i64 {
        self.seen
    }

    /// Returns an empty index that continues this one: it reads the next effects while queries use this one.
    pub(super) fn continuation(&self) -> EffectIndex {
        // The last block may not be full.
        let left_out = block_number(self.seen.saturating_add(1)).min(self.blocks.len());
        let blocks = self.blocks.get(left_out..).unwrap_or_default().to_vec();
        EffectIndex { left_out, blocks, seen: self.seen, kinds: self.kinds.clone() }
    }

    /// Takes what a continuation from effect `after` has read. If another thread has extended the index meanwhile, nothing changes.
    pub(super) fn append(&mut self, after: i64, next: EffectIndex) {
        if self.seen == after && self.left_out == 0 {
            self.blocks.truncate(next.left_out);
            self.blocks.extend(next.blocks);
            (self.seen, self.kinds) = (next.seen, next.kinds);
        }
    }

    /// Reads the next chunk of effects, none after effect `last`.
    pub(super) fn refresh(&mut self, reader: &RecordReader, last: i64) -> Result<(), RecordError> {
        let effects = reader.effects()?;
        let end = self.seen.saturating_add(CHUNK_EFFECTS).min(last);
        let places = effects.table.place_after(self.seen)..effects.table.place_after(end);
        let all = |_: &EffectKind| EffectNeed::Effect;
        effects.scan(places, all, |found| {
            let Some(effect) = found.effect else { return Ok(()) };
            let told = effects.tell(found.place, effect)?;
            self.add(told.id, told.at.0, told.row.kind, [&told.row.subject, &told.row.text]);
            Ok(())
        })?;
        // If numbers are missing, the index continues after them.
        self.seen = self.seen.max(end);
        Ok(())
    }

    /// Enters an effect.
    fn add(&mut self, id: i64, t_ns: i64, kind: &str, texts: [&str; 2]) {
        let kind = self.kind_bit(kind);
        self.seen = id;
        let Some(block) = self.block_of(id, t_ns) else { return };
        block.last_ns = t_ns;
        block.kinds |= kind;
        texts.into_iter().for_each(|text| block.add(text));
    }

    fn kind_bit(&mut self, kind: &str) -> u64 {
        if let Some(bit) = self.kinds.get(kind) {
            return 1 << bit;
        }
        let bit = u32::try_from(self.kinds.len()).unwrap_or(u32::MAX).min(63);
        self.kinds.insert(kind.to_owned(), bit);
        1 << bit
    }

    /// Returns the block of effect `id`, which is not in the index yet.
    fn block_of(&mut self, id: i64, t_ns: i64) -> Option<&mut EffectBlock> {
        let place = block_number(id).checked_sub(self.left_out)?;
        while self.blocks.len() <= place {
            let filter = vec![0; FILTER_BITS / 64].into_boxed_slice();
            self.blocks.push(EffectBlock { first_ns: t_ns, last_ns: t_ns, kinds: 0, filter });
        }
        self.blocks.get_mut(place)
    }

    /// Returns the blocks below effect `below` that may contain a match, as ranges of effects, the newest first.
    pub(super) fn blocks<'a>(
        &'a self,
        wanted: &'a EffectSearch<'a>,
        below: i64,
    ) -> impl Iterator<Item = (i64, i64)> + 'a {
        let kinds = wanted.kinds.iter().filter_map(|kind| self.kinds.get(kind)).fold(0, |bits, bit| bits | 1 << bit);
        let any_kind = wanted.kinds.is_empty();
        let grams: Vec<usize> = wanted.find.map(search_bits).unwrap_or_default();
        let first = self.blocks.partition_point(|block| block.last_ns < wanted.from_ns);
        let below = usize::try_from((below - 1).max(0) / BLOCK_EFFECTS).unwrap_or(usize::MAX);
        let end = self.blocks.partition_point(|block| block.first_ns <= wanted.to_ns).min(below).max(first);
        (first..end).rev().filter_map(move |place| {
            let block = self.blocks.get(place)?;
            let fits = (any_kind || block.kinds & kinds != 0) && grams.iter().all(|bit| block.has(*bit));
            let begin = i64::try_from(place).ok()? * BLOCK_EFFECTS + 1;
            fits.then_some((begin, begin + BLOCK_EFFECTS - 1))
        })
    }
}

impl EffectBlock {
    fn add(&mut self, text: &str) {
        for length in GRAMS {
            for gram in text.as_bytes().windows(length) {
                let bit = bit_of(gram);
                if let Some(word) = self.filter.get_mut(bit / 64) {
                    *word |= 1 << (bit % 64);
                }
            }
        }
    }

    fn has(&self, bit: usize) -> bool {
        self.filter.get(bit / 64).is_some_and(|word| word & (1 << (bit % 64)) != 0)
    }
}

/// Returns the bits that a block must have to contain `find`; empty for a text of one byte, which any block may contain.
fn search_bits(find: &str) -> Vec<usize> {
    let length = GRAMS.into_iter().find(|length| *length <= find.len());
    length.map(|length| find.as_bytes().windows(length).map(bit_of).collect()).unwrap_or_default()
}

/// Returns the bit of the filter for a text: Fowler-Noll-Vo hash (FNV-1a) of the lower-case bytes.
fn bit_of(gram: &[u8]) -> usize {
    let mut hash: u32 = 0x811c_9dc5 ^ gram.len() as u32;
    for byte in gram {
        hash = (hash ^ u32::from(byte.to_ascii_lowercase())).wrapping_mul(0x0100_0193);
    }
    (hash ^ (hash >> 15)) as usize % FILTER_BITS
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn indexed<'e>(effects: impl Iterator<Item = (i64, &'e (i64, &'e str, String))>) -> EffectIndex {
        let mut index = EffectIndex::default();
        effects.for_each(|(id, (t_ns, kind, text))| index.add(id, *t_ns, kind, ["", text]));
        index
    }

    #[test]
    fn a_rare_text_leads_to_its_block() {
        let mut effects: Vec<(i64, &str, String)> = (0..40_000)
            .map(|id| (id / 3, "transition", format!("task {} is granted the Flight Path", id % 97)))
            .collect();
        effects[20_000].2 = "a Chimney was seen".into();
        let index = indexed((1..).zip(&effects).filter(|(id, _)| !(25_000..=35_000).contains(id)));
        let blocks = |find: &str, kinds: &[String]| {
            let wanted = EffectSearch { from_ns: i64::MIN, to_ns: i64::MAX, kinds, find: Some(find) };
            index.blocks(&wanted, i64::MAX).collect::<Vec<_>>()
        };
        assert_eq!(blocks("chimney", &[]), [(20_001, 20_032)]);
        assert!(blocks("smoke", &[]).is_empty() && blocks("chimney", &["command".into()]).is_empty());
        assert!(blocks("flight path", &["transition".into()]).len() > 200);
        let wanted = EffectSearch { from_ns: 5_000, to_ns: 5_010, kinds: &[], find: None };
        let range: Vec<(i64, i64)> = index.blocks(&wanted, i64::MAX).collect();
        assert!(range.len() <= 2 && range.iter().any(|(first, last)| (first..=last).contains(&&15_010)), "{range:?}");
    }

    const WORDS: [&str; 6] = ["Roll", "alpha", "T1", "ü", "granted", "x"];

    proptest! {
        #[test]
        fn no_effect_that_is_wanted_is_outside_of_the_blocks(
            steps in prop::collection::vec((0i64..3, 0usize..2, prop::collection::vec(0usize..6, 0..4)), 1..400),
            (from, to, find, kind) in (0i64..600, 0i64..600, 0usize..6, 0usize..3),
            turn in 1usize..90,
        ) {
            let kinds = ["created", "transition"];
            let mut at = 0;
            let effects: Vec<(i64, &str, String)> = steps.into_iter().map(|(passed, kind, words)| {
                at += passed;
                (at, kinds[kind], words.into_iter().map(|word| WORDS[word]).collect::<Vec<_>>().join(" "))
            }).collect();
            let whole = indexed((1..).zip(&effects));
            // In turns, as while queries use the index; a continuation that comes too late is left out.
            let mut index = EffectIndex::default();
            let numbered: Vec<(i64, &(i64, &str, String))> = (1..).zip(&effects).collect();
            for effects in numbered.chunks(turn) {
                let (after, mut next, mut late) = (index.seen(), index.continuation(), index.continuation());
                for (id, (t_ns, kind, text)) in effects {
                    next.add(*id, *t_ns, kind, ["", text]);
                    late.add(*id, *t_ns, "other", ["", "wrong"]);
                }
                index.append(after, next);
                index.append(after, late);
            }
            prop_assert_eq!(index.seen(), whole.seen());
            let everything = EffectSearch { from_ns: i64::MIN, to_ns: i64::MAX, kinds: &[], find: None };
            prop_assert_eq!(
                index.blocks(&everything, i64::MAX).collect::<Vec<_>>(),
                whole.blocks(&everything, i64::MAX).collect::<Vec<_>>()
            );
            let wanted_kinds: Vec<String> = kinds.get(kind).map(|kind| (*kind).to_owned()).into_iter().collect();
            let find = WORDS[find].to_ascii_lowercase();
            let wanted = EffectSearch { from_ns: from, to_ns: to, kinds: &wanted_kinds, find: Some(&find) };
            let blocks: Vec<(i64, i64)> = index.blocks(&wanted, i64::MAX).collect();
            prop_assert!(blocks.windows(2).all(|pair| pair[0].0 > pair[1].1));
            for (id, (t_ns, kind, text)) in (1..).zip(&effects) {
                let is_wanted = (from..=to).contains(t_ns)
                    && (wanted_kinds.is_empty() || wanted_kinds.iter().any(|each| each == kind))
                    && text.to_ascii_lowercase().contains(&find);
                prop_assert!(!is_wanted || blocks.iter().any(|(first, last)| (*first..=*last).contains(&id)));
            }
        }
    }
}
