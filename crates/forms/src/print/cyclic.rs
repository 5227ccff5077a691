//! Cyclic conditions as text.

use super::layout::list_text;
use super::style::Style;
use apex_model::condition::CyclicCondition;

impl Style {
    /// Returns a cyclic condition as text.
    pub fn cyclic(self, condition: &CyclicCondition) -> String {
        self.cyclic_with(condition, String::new())
    }

    pub(super) fn cyclic_with(self, cyclic: &CyclicCondition, tag: String) -> String {
        let options = cyclic.options.iter().map(|(name, constraints)| self.option(&format!(":{name}"), constraints));
        list_text(":cyclic", [tag, self.variable(&cyclic.variable, String::new())].into_iter().chain(options))
    }
}
