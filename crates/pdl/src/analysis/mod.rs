//! Checks of a complete library: certain errors of its behaviour, and probable mistakes.
//!
//! They run if lowering has found no error, so that no message describes the consequence of another one. An error is proven; a probable
//! mistake is a warning.

mod bindings;
mod bound;
mod constant_number;
mod contradictions;
mod deadlocks;
mod derived;
mod dimensions;
mod early_ends;
mod endings;
mod flow;
mod function_calls;
mod horn;
mod impossible;
pub(crate) mod kinds;
mod limits;
mod loops;
mod memory;
pub(crate) mod methods;
mod negative_spans;
mod objects;
mod operands;
mod own_tag;
mod probes;
mod profiles;
mod published;
mod published_words;
mod quoted_words;
mod replenished;
mod resemblance;
mod served;
mod shadows;
mod starts;
mod unused;
pub(crate) mod walk;

use crate::diagnostic::Diagnostic;
use crate::locate::Locator;
use crate::lower::Names;
use apex_model::condition::Condition;
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, BuiltInActivity, Hooks, Procedure, ProcedureKind, Step, Transitions};
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use endings::Endings;
use methods::Methods;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Maximum number of messages; the first ones are kept.
const MESSAGES_MAX: usize = 200;

/// A library with the results that several checks share.
pub(crate) struct Program<'l> {
    library: &'l Library,
    names: &'l Names,
    /// True if the text is a part of something larger, which may define and serve more.
    fragment: bool,
    /// Files loaded as libraries: their definitions need not be used.
    foreign: &'l BTreeSet<u32>,
    methods: Methods<'l>,
    endings: Endings,
}

/// Collects messages and finds their places.
struct FindingCollector<'l> {
    locator: Locator<'l>,
    diagnostics: Vec<Diagnostic>,
    /// State variables with the indexicals that were reported as values of the wrong type for them: one wrong definition would be an error
    /// at each of its uses.
    mistyped: BTreeSet<(Symbol, Symbol)>,
}

impl FindingCollector<'_> {
    fn add(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < MESSAGES_MAX {
            self.diagnostics.push(diagnostic);
        }
    }
}

/// Returns all diagnostics of `library`.
pub(crate) fn analyse(library: &Library, names: &Names, fragment: bool, foreign: &BTreeSet<u32>) -> Vec<Diagnostic> {
    let methods = Methods::new(library);
    let endings = Endings::new(library, names, &methods);
    let program = Program { library, names, fragment, foreign, methods, endings };
    let mut report = FindingCollector {
        locator: Locator::new(&library.sources),
        diagnostics: Vec::new(),
        mistyped: BTreeSet::new(),
    };
    let caught = loops::check(&program, &mut report);
    flow::check(&program, &caught, &mut report);
    early_ends::findings(library, &program.endings).into_iter().for_each(|each| report.add(each));
    limits::check(&program, &mut report);
    own_tag::check(&program, &mut report);
    probes::check(&program, &mut report);
    profiles::check(&program, &mut report);
    deadlocks::check(&program, &mut report);
    served::check(&program, &mut report);
    shadows::check(&program, &mut report);
    bindings::check(&program, &mut report);
    dimensions::check(&program, &mut report);
    let amounts = derived::findings(library).into_iter().chain(replenished::findings(library));
    amounts.for_each(|each| report.add(each));
    operands(library, &mut report);
    resemblance::check(&program, &mut report);
    let published = published::findings(library).into_iter().chain(objects::findings(library));
    published.chain(published_words::findings(library)).for_each(|each| report.add(each));
    if !fragment {
        let words = quoted_words::findings(library, foreign, &report.diagnostics);
        words.into_iter().for_each(|each| report.add(each));
    }
    memory::check(&program, &mut report);
    unused::check(&program, &mut report);
    report.diagnostics
}

/// Returns the diagnostics of `conditions` without a program, in terms of `library`.
pub(crate) fn analyse_conditions(library: &Library, conditions: &[Condition], names: &Names) -> Vec<Diagnostic> {
    // The checks inspect procedures, so each condition becomes the wait of a step in one.
    let mut whole = library.clone();
    whole.procedures.extend(conditions.iter().map(|condition| Arc::new(waiting_for(condition))));
    let methods = Methods::new(&whole);
    let endings = Endings::new(&whole, names, &methods);
    let foreign = BTreeSet::new();
    let program = Program { library: &whole, names, fragment: false, foreign: &foreign, methods, endings };
    let mut report =
        FindingCollector { locator: Locator::new(&whole.sources), diagnostics: Vec::new(), mistyped: BTreeSet::new() };
    limits::check(&program, &mut report);
    probes::check(&program, &mut report);
    probes::without_effect(conditions, &mut report);
    dimensions::check(&program, &mut report);
    operands(&whole, &mut report);
    resemblance::check(&program, &mut report);
    memory::check(&program, &mut report);
    report.diagnostics
}

fn operands(library: &Library, report: &mut FindingCollector<'_>) {
    for finding in operands::findings(library) {
        let diagnostic = finding.diagnostic(&mut report.locator);
        report.add(diagnostic);
    }
}

fn waiting_for(condition: &Condition) -> Procedure {
    let place = condition.place;
    let activity = Activity::BuiltIn(BuiltInActivity::Print, Vec::new());
    let step = Step { waitfor: vec![condition.clone()], ..Step::plain(Symbol::new("s1"), activity, place) };
    Procedure {
        kind: ProcedureKind::Concurrent,
        index: Pattern::Literal(Value::list([Value::symbol("monitor")])),
        profile: Vec::new(),
        log: Vec::new(),
        expected_duration: None,
        interrupt_cost: None,
        transitions: Transitions::default(),
        hooks: Hooks::default(),
        steps: vec![step],
        bundle: None,
        place,
    }
}
