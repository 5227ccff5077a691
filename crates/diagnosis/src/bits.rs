//! Sets of small numbers as bit sets. An operation on two sets expects sets of equal bounds.

/// A set of numbers below a bound that is fixed when the set is made.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bits(Vec<u64>);

const WORD: usize = 64;

impl Bits {
    /// Returns the empty set of numbers below `bound`.
    pub fn new(bound: usize) -> Bits {
        Bits(vec![0; bound.div_ceil(WORD)])
    }

    /// Returns the set of these numbers, all below `bound`.
    pub fn of(bound: usize, numbers: impl IntoIterator<Item = usize>) -> Bits {
        let mut bits = Bits::new(bound);
        numbers.into_iter().for_each(|number| bits.insert(number));
        bits
    }

    /// Adds a number, which must be below the bound. A number beyond the last word of the set is ignored.
    pub fn insert(&mut self, number: usize) {
        if let Some(word) = self.0.get_mut(number / WORD) {
            *word |= 1 << (number % WORD);
        }
    }

    /// Removes a number.
    pub fn remove(&mut self, number: usize) {
        if let Some(word) = self.0.get_mut(number / WORD) {
            *word &= !(1 << (number % WORD));
        }
    }

    /// Returns true if the set has the number.
    pub fn contains(&self, number: usize) -> bool {
        self.0.get(number / WORD).is_some_and(|word| word >> (number % WORD) & 1 == 1)
    }

    /// Returns true if the set is empty.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|word| *word == 0)
    }

    /// Returns the number of members.
    pub fn len(&self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Returns true if every number of this set is in `other`.
    pub fn is_subset(&self, other: &Bits) -> bool {
        self.0.iter().zip(&other.0).all(|(mine, theirs)| mine & !theirs == 0)
    }

    /// Returns true if a number is in both.
    pub fn intersects(&self, other: &Bits) -> bool {
        self.0.iter().zip(&other.0).any(|(mine, theirs)| mine & theirs != 0)
    }

    /// Returns the number of common members.
    pub fn common(&self, other: &Bits) -> usize {
        self.0.iter().zip(&other.0).map(|(mine, theirs)| (mine & theirs).count_ones() as usize).sum()
    }

    /// Returns the number of members that are not in `other`.
    pub fn beyond(&self, other: &Bits) -> usize {
        self.0.iter().zip(&other.0).map(|(mine, theirs)| (mine & !theirs).count_ones() as usize).sum()
    }

    /// Adds all numbers of `other`.
    pub fn extend(&mut self, other: &Bits) {
        self.0.iter_mut().zip(&other.0).for_each(|(mine, theirs)| *mine |= theirs);
    }

    /// Keeps the numbers that are in `other`, too.
    pub fn retain(&mut self, other: &Bits) {
        self.0.iter_mut().zip(&other.0).for_each(|(mine, theirs)| *mine &= theirs);
    }

    /// Removes all numbers of `other`.
    pub fn subtract(&mut self, other: &Bits) {
        self.0.iter_mut().zip(&other.0).for_each(|(mine, theirs)| *mine &= !theirs);
    }

    /// Returns the union of both sets.
    pub fn union(&self, other: &Bits) -> Bits {
        let mut both = self.clone();
        both.extend(other);
        both
    }

    /// Returns the numbers of this set that are not in `other`.
    pub fn without(&self, other: &Bits) -> Bits {
        let mut rest = self.clone();
        rest.subtract(other);
        rest
    }

    /// Returns the least number; `None` if the set is empty.
    pub fn first(&self) -> Option<usize> {
        self.iter().next()
    }

    /// Returns its numbers in rising order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().enumerate().flat_map(|(index, word)| Bits::numbers(index, *word))
    }

    /// Returns the numbers of one word; `index` is the position of the word.
    pub(crate) fn numbers(index: usize, word: u64) -> impl Iterator<Item = usize> {
        let mut rest = word;
        std::iter::from_fn(move || {
            let low = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
            rest &= rest - 1;
            Some(index * WORD + low)
        })
    }

    pub(crate) fn words(&self) -> &[u64] {
        &self.0
    }

    pub(crate) fn words_mut(&mut self) -> &mut [u64] {
        &mut self.0
    }
}

/// Returns the sets of which no other set is a subset, ordered by their size; of equal sets, one.
pub(crate) fn minimal(mut sets: Vec<Bits>) -> Vec<Bits> {
    sets.sort_by_cached_key(|set| (set.len(), set.clone()));
    sets.dedup();
    let mut kept: Vec<Bits> = Vec::with_capacity(sets.len());
    for set in sets {
        if !kept.iter().any(|small| small.is_subset(&set)) {
            kept.push(set);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_hold_what_was_put_in() {
        let set = Bits::of(130, [129, 3, 64]);
        assert_eq!(set.iter().collect::<Vec<_>>(), [3, 64, 129]);
        assert_eq!((set.len(), set.first(), set.contains(64), set.contains(65)), (3, Some(3), true, false));
        assert!(Bits::of(130, [3]).is_subset(&set) && !set.is_subset(&Bits::of(130, [3])));
        assert_eq!((set.common(&Bits::of(130, [64, 5])), set.beyond(&Bits::of(130, [64, 5]))), (1, 2));
    }

    #[test]
    fn only_minimal_sets_stay() {
        let sets = [[1, 2].as_slice(), &[2], &[1, 3], &[1, 3], &[2, 3]].map(|set| Bits::of(8, set.iter().copied()));
        assert_eq!(minimal(sets.to_vec()), [Bits::of(8, [2]), Bits::of(8, [1, 3])]);
    }
}
