//! Generated mistakes of one word: each returns the changed program and the lines on which a diagnostic must appear.

use super::mistake::{Mistake, replace};
use super::program::Program;
use super::rng::TestRng;
use super::roles::{Role, Site};
use super::slips::misspelt;
use super::tree::line_of;
use apex_model::quantity::unit_named;

/// Mistypes a word of the given role.
pub fn typo(program: &Program<'_>, rng: &mut TestRng, role: Role) -> Option<Mistake> {
    let sites: Vec<Site> = program.roles.sites.iter().filter(|site| site.role == role).copied().collect();
    let site = rng.pick(&sites)?;
    let word = program.roles.word(site.node);
    let (name, before) = bare(word);
    if name.len() < 2 {
        return None;
    }
    let slipped = misspelt(rng, name);
    let new = word.replacen(name, &slipped, 1);
    let is_unit = role == Role::Unit && unit_named(&slipped).is_some();
    if new.eq_ignore_ascii_case(word)
        || slipped.is_empty()
        || is_unit
        || program.knows(&new)
        || (before == 0 && program.knows(&slipped))
    {
        return None;
    }
    let lines = lines_of_contradiction(program, site)?;
    let mut mistake = replace(program, program.roles.tree.nodes[site.node].range.clone(), &new);
    mistake.lines.extend(lines);
    mistake.elsewhere = program.only_counterpart(site);
    Some(mistake)
}

/// Returns the name in a word without its leading marks (`?`, `:`), and the number of those marks.
fn bare(word: &str) -> (&str, usize) {
    let name = word.trim_start_matches(['?', ':', '"', '+']);
    (name.trim_end_matches(['"', '+']), word.len() - name.len())
}

/// Returns the other lines at which a diagnostic about a mistyped word at `site` is correct, too. `None` if no other word contradicts
/// the mistake: then no checker can detect it. If several words contradict it, the list is empty.
fn lines_of_contradiction(program: &Program<'_>, site: &Site) -> Option<Vec<u32>> {
    let word = program.roles.word(site.node);
    let others: Vec<u32> = program
        .roles
        .sites
        .iter()
        .filter(|other| other.form == site.form && other.node != site.node)
        .filter(|other| bare(program.roles.word(other.node)).0 == bare(word).0)
        .map(|other| line_of(program.text, program.roles.tree.nodes[other.node].range.start))
        .collect();
    let one_against_one = |lines: Vec<u32>| if lines.len() == 1 { lines } else { Vec::new() };
    match site.role {
        Role::Tag => {
            let uses = program.count_in_form(&format!("?{word}"), site);
            (uses > 0).then(|| one_against_one(others))
        }
        Role::Variable => (program.count_in_form(word, site) > 1).then(|| one_against_one(others)),
        Role::GoalWord => {
            let objects = [Role::GoalWord, Role::Resource, Role::EventWord, Role::IndexWord];
            (program.is_word_of_index(site) || program.count(word, &objects) > 2).then(Vec::new)
        }
        Role::IndexWord => {
            let index = program.roles.tree.nodes[site.node].parent?;
            let goals: Vec<u32> = program
                .goals_of(index)
                .iter()
                .map(|goal| line_of(program.text, program.roles.tree.nodes[*goal].range.start))
                .collect();
            let elsewhere = program.count(word, &[Role::GoalWord, Role::IndexWord]) > 2;
            program.is_pursued(index).then(|| if elsewhere { Vec::new() } else { one_against_one(goals) })
        }
        Role::AttributeDeclared => (program.count(word, &[Role::Attribute]) > 0).then(Vec::new),
        Role::Resource => (program.count(word, &[Role::Resource]) > 1).then(Vec::new),
        Role::EventWord => (program.count(word, &[Role::EventWord]) > 1).then(|| one_against_one(others)),
        _ => Some(Vec::new()),
    }
}

/// Removes the question mark of a variable.
pub fn without_question_mark(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let is_variable = |site: &&Site| matches!(site.role, Role::Variable | Role::TagUse);
    let sites: Vec<Site> = program.roles.sites.iter().filter(is_variable).copied().collect();
    let site = rng.pick(&sites)?;
    let word = program.roles.word(site.node);
    if site.role == Role::Variable && program.count_in_form(word, site) < 2 {
        return None;
    }
    let lines = if site.role == Role::Variable { lines_of_contradiction(program, site)? } else { Vec::new() };
    let mut mistake = replace(program, program.roles.tree.nodes[site.node].range.clone(), &word[1..]);
    mistake.lines.extend(lines);
    Some(mistake)
}

/// Removes the colon of a keyword.
pub fn without_colon(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let has_colon = |site: &&Site| program.roles.word(site.node).starts_with(':');
    let sites: Vec<Site> = program.roles.sites.iter().filter(has_colon).copied().collect();
    let site = rng.pick(&sites)?;
    let word = program.roles.word(site.node);
    Some(replace(program, program.roles.tree.nodes[site.node].range.clone(), &word[1..]))
}

/// Misspells the unit of a quantity.
pub fn misspelt_quantity(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let (range, digits, unit) = quantity(program, rng, |_| true)?;
    let slipped = misspelt(rng, unit);
    if unit_named(&slipped).is_some() || slipped.is_empty() {
        return None;
    }
    Some(replace(program, range, &format!("{digits}{slipped}")))
}

/// Replaces a unit by one of another dimension, at places whose dimension the text determines.
pub fn wrong_dimension(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let (range, digits, unit) = quantity(program, rng, |node| needs_dimension(program, node))?;
    let other = *rng.pick(&["deg", "kg", "ft", "kt", "min", "V", "s", "m"])?;
    let dimension = |name: &str| unit_named(name).map(|unit| unit.dimension);
    if dimension(other) == dimension(unit) {
        return None;
    }
    let mut mistake = replace(program, range.clone(), &format!("{digits}{other}"));
    // The definition of an indexical and its use contradict each other.
    let line = program.text[..range.start].rfind('\n').map_or(0, |at| at + 1);
    if let Some(name) = program.text[line..].strip_prefix("(defindexical ").and_then(|rest| rest.split(' ').next()) {
        let uses = program.roles.sites.iter().filter(|site| program.roles.word(site.node) == name);
        mistake.lines.extend(uses.map(|site| line_of(program.text, program.roles.tree.nodes[site.node].range.start)));
    }
    Some(mistake)
}

type Quantity<'t> = (std::ops::Range<usize>, &'t str, &'t str);

fn quantity<'t>(program: &Program<'t>, rng: &mut TestRng, wanted: impl Fn(usize) -> bool) -> Option<Quantity<'t>> {
    let split = |word: &'t str| {
        let at = word.find(|c: char| !c.is_ascii_digit() && c != '.').filter(|at| *at > 0)?;
        unit_named(&word[at..]).map(|_| word.split_at(at))
    };
    let nodes = 0..program.roles.tree.nodes.len();
    let found: Vec<usize> = nodes.filter(|node| split(program.roles.word(*node)).is_some() && wanted(*node)).collect();
    let node = *rng.pick(&found)?;
    let (digits, unit) = split(program.roles.word(node))?;
    Some((program.roles.tree.nodes[node].range.clone(), digits, unit))
}

/// Returns true if the dimension at the quantity is determined: after certain options, in a duration clause, in a comparison with
/// the time that a step takes, or in the definition of an indexical that is used at such a place.
fn needs_dimension(program: &Program<'_>, node: usize) -> bool {
    let tree = &program.roles.tree;
    let Some(parent) = tree.nodes[node].parent else { return false };
    let at = tree.nodes[parent].children.iter().position(|item| *item == node).unwrap();
    let before = at.checked_sub(1).map_or("", |at| program.roles.word(tree.nodes[parent].children[at]));
    let head = tree.head(parent, program.text);
    let siblings: Vec<&str> = tree.nodes[parent].children.iter().map(|item| program.roles.word(*item)).collect();
    let is_limit =
        head == "defindexical" && ["+max-off-nominal-", "+low-fuel+"].iter().any(|name| siblings[1].starts_with(name));
    matches!(before, ":duration" | ":budget" | ":timeout")
        || head == "duration"
        || is_limit
        || siblings.iter().any(|item| item.starts_with("(elapsed"))
}
