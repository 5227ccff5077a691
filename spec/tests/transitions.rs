//! Every legal change of a task's state occurs on some page, and no other does.

use apex_model::task::TaskState::{self, Enabled, Interrupted, Ongoing, Pending, Terminated};
use apex_spec::{page, verdict};
use std::collections::BTreeSet;

#[test]
fn every_legal_transition_is_shown_on_a_page_and_no_other() {
    let legal: BTreeSet<(TaskState, TaskState)> = BTreeSet::from([
        (Pending, Enabled),
        (Enabled, Ongoing),
        (Ongoing, Interrupted),
        (Interrupted, Ongoing),
        (Ongoing, Pending),
        (Interrupted, Pending),
        (Terminated, Pending),
        (Pending, Terminated),
        (Enabled, Terminated),
        (Ongoing, Terminated),
        (Interrupted, Terminated),
    ]);
    let pages = page::files();
    let texts = pages.iter().filter_map(|path| std::fs::read_to_string(path).ok());
    let shown: BTreeSet<_> = texts.flat_map(|text| verdict::transitions(&text)).collect();
    assert_eq!(shown, legal);
}
