//! The condition for the loss of a signal or the failure of a test: a monotone formula over failure modes, in both normal forms.
//!
//! Bound: at most [`TERMS_MAX`] sets in each form; a formula with more is rejected.

use crate::bits::{Bits, minimal};
use crate::limits::TERMS_MAX;

/// Largest number of sets in a product before its non-minimal sets are removed: comparing them takes the square of that number.
const PRODUCT_MAX: usize = 8 * TERMS_MAX;

/// A monotone formula of failure modes in its two minimal normal forms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Formula {
    /// Disjunctive form: the formula is true if all modes of any one of these sets are present.
    pub(crate) implicants: Vec<Bits>,
    /// Conjunctive form: the formula is true if every one of these sets has a present mode.
    pub(crate) clauses: Vec<Bits>,
}

/// A normal form has more than [`TERMS_MAX`] sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TooManyTerms;

impl Formula {
    /// Returns a formula that is never true.
    pub(crate) fn never(modes: usize) -> Formula {
        Formula { implicants: Vec::new(), clauses: vec![Bits::new(modes)] }
    }

    /// Returns a formula that is always true.
    fn always(modes: usize) -> Formula {
        Formula { implicants: vec![Bits::new(modes)], clauses: Vec::new() }
    }

    /// Returns a formula that is true if any of these modes is present.
    pub(crate) fn one_of(modes: usize, which: &[usize]) -> Formula {
        let implicants = which.iter().map(|mode| Bits::of(modes, [*mode])).collect();
        Formula { implicants: minimal(implicants), clauses: vec![Bits::of(modes, which.iter().copied())] }
    }

    /// Returns a formula that is true if a part is true.
    pub(crate) fn any<'a>(modes: usize, parts: impl Iterator<Item = &'a Formula>) -> Result<Formula, TooManyTerms> {
        let mut whole = Formula::never(modes);
        for part in parts {
            let implicants = whole.implicants.into_iter().chain(part.implicants.iter().cloned()).collect();
            whole = Formula { implicants: limited(implicants)?, clauses: product(&whole.clauses, &part.clauses)? };
        }
        Ok(whole)
    }

    /// Returns a formula that is true if all parts are true.
    pub(crate) fn all<'a>(modes: usize, parts: impl Iterator<Item = &'a Formula>) -> Result<Formula, TooManyTerms> {
        let mut whole = Formula::always(modes);
        for part in parts {
            let clauses = whole.clauses.into_iter().chain(part.clauses.iter().cloned()).collect();
            whole = Formula { clauses: limited(clauses)?, implicants: product(&whole.implicants, &part.implicants)? };
        }
        Ok(whole)
    }
}

fn product(left: &[Bits], right: &[Bits]) -> Result<Vec<Bits>, TooManyTerms> {
    if left.len() * right.len() > PRODUCT_MAX {
        return Err(TooManyTerms);
    }
    limited(left.iter().flat_map(|one| right.iter().map(|other| one.union(other))).collect())
}

fn limited(sets: Vec<Bits>) -> Result<Vec<Bits>, TooManyTerms> {
    let sets = minimal(sets);
    if sets.len() > TERMS_MAX { Err(TooManyTerms) } else { Ok(sets) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn telemetry_by_any_link_has_the_clauses_of_its_implicants() {
        let mode = |number: usize| Formula::one_of(5, &[number]);
        let radio = Formula::any(5, [mode(0), mode(1), mode(2)].iter()).unwrap();
        let satcom = Formula::any(5, [mode(0), mode(3)].iter()).unwrap();
        let links = Formula::all(5, [radio, satcom].iter()).unwrap();
        assert_eq!(links.implicants, [vec![0], vec![1, 3], vec![2, 3]].map(|set| Bits::of(5, set)));
        assert_eq!(links.clauses, [vec![0, 3], vec![0, 1, 2]].map(|set| Bits::of(5, set)));
        assert_eq!(Formula::any(5, [].iter()).unwrap(), Formula::never(5));
    }

    #[test]
    fn redundancy_of_redundancy_is_limited() {
        let pairs: Vec<Formula> = (0..10).map(|pair| Formula::one_of(20, &[2 * pair, 2 * pair + 1])).collect();
        assert_eq!(Formula::all(20, pairs.iter()), Err(TooManyTerms));
    }
}
