//! Lists of evidence: shared instead of copied, because several decisions rest on the same facts.

use crate::because::Evidence;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ops::Deref;
use std::sync::Arc;

/// Evidence in order; cheap to clone, and without an allocation if empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EvidenceList(Option<Arc<[Evidence]>>);

impl EvidenceList {
    /// Returns a list of one fact.
    pub fn one(evidence: Evidence) -> EvidenceList {
        EvidenceList(Some(Arc::from([evidence])))
    }

    /// Returns the facts of both, those of `self` first.
    pub fn joined(&self, other: &EvidenceList) -> EvidenceList {
        match (self.is_empty(), other.is_empty()) {
            (true, _) => other.clone(),
            (_, true) => self.clone(),
            _ => self.iter().chain(other.iter()).cloned().collect(),
        }
    }
}

impl Deref for EvidenceList {
    type Target = [Evidence];

    fn deref(&self) -> &[Evidence] {
        self.0.as_deref().unwrap_or_default()
    }
}

impl FromIterator<Evidence> for EvidenceList {
    fn from_iter<I: IntoIterator<Item = Evidence>>(facts: I) -> EvidenceList {
        let facts: Arc<[Evidence]> = facts.into_iter().collect();
        EvidenceList((!facts.is_empty()).then_some(facts))
    }
}

impl From<Vec<Evidence>> for EvidenceList {
    fn from(facts: Vec<Evidence>) -> EvidenceList {
        facts.into_iter().collect()
    }
}

impl Serialize for EvidenceList {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for EvidenceList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<EvidenceList, D::Error> {
        Vec::deserialize(deserializer).map(EvidenceList::from)
    }
}
