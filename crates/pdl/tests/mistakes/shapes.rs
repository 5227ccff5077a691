//! Mistakes in parentheses and quotation marks.

use super::mistake::{Mistake, replace, replaced};
use super::program::Program;
use super::rng::TestRng;
use super::roles::Role;
use super::tree::{NodeKind, line_of};

/// Returns ends of all lists.
fn closers(program: &Program<'_>) -> Vec<usize> {
    program.roles.tree.nodes.iter().filter(|node| node.kind == NodeKind::List).map(|node| node.range.end - 1).collect()
}

pub fn dropped_close(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let at = *rng.pick(&closers(program))?;
    Some(replace(program, at..at + 1, ""))
}

pub fn doubled_close(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let at = *rng.pick(&closers(program))?;
    Some(replace(program, at..at, ")"))
}

pub fn dropped_open(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let lists: Vec<usize> = program
        .roles
        .tree
        .nodes
        .iter()
        .filter(|node| node.kind == NodeKind::List)
        .map(|node| node.range.start)
        .collect();
    let at = *rng.pick(&lists)?;
    Some(replace(program, at..at + 1, ""))
}

/// Returns a clause that only steps have, outside of its step: the step is closed too early.
pub fn closed_too_early(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let clauses = ["waitfor", "priority", "rank", "forall", "repeating", "responding", "on-failure"];
    let is_clause =
        |site: &&super::roles::Site| site.role == Role::Clause && clauses.contains(&program.roles.word(site.node));
    let sites: Vec<usize> = program.roles.sites.iter().filter(is_clause).map(|site| site.node).collect();
    let tree = &program.roles.tree;
    let clause = tree.nodes[*rng.pick(&sites)?].parent?;
    let step = tree.nodes[clause].parent.filter(|step| tree.head(*step, program.text) == "step")?;
    let position = tree.nodes[step].children.iter().position(|item| *item == clause)?;
    let before = tree.nodes[tree.nodes[step].children[position - 1]].range.end;
    let end = tree.nodes[step].range.end;
    let lines = vec![line_of(program.text, before), line_of(program.text, tree.nodes[clause].range.start)];
    let what = format!("step closed before ({}", program.roles.tree.head(clause, program.text));
    Some(replaced(program, &[(before..before, ")".to_string()), (end - 1..end, String::new())], lines, what))
}

/// Returns a step that is closed too late, so that the next step is inside of it.
pub fn closed_too_late(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let tree = &program.roles.tree;
    let is_step = |node: &usize| tree.nodes[*node].kind == NodeKind::List && tree.head(*node, program.text) == "step";
    let steps: Vec<usize> = (0..tree.nodes.len()).filter(is_step).collect();
    let step = *rng.pick(&steps)?;
    let siblings = &tree.nodes[tree.nodes[step].parent?].children;
    let next = *siblings.get(siblings.iter().position(|item| *item == step)? + 1)?;
    let (end, later) = (tree.nodes[step].range.end, tree.nodes[next].range.end);
    let lines = vec![line_of(program.text, end - 1), line_of(program.text, tree.nodes[next].range.start)];
    Some(replaced(
        program,
        &[(end - 1..end, String::new()), (later..later, ")".to_string())],
        lines,
        "step closed after the next".into(),
    ))
}

/// Returns a string without one of its quotation marks.
pub fn without_quote(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let tree = &program.roles.tree;
    let texts: Vec<usize> = (0..tree.nodes.len()).filter(|node| tree.nodes[*node].kind == NodeKind::Text).collect();
    let range = tree.nodes[*rng.pick(&texts)?].range.clone();
    let at = if rng.below(2) == 0 { range.start } else { range.end - 1 };
    let mut mistake = replace(program, at..at + 1, "");
    mistake.what = format!("{} without one mark", &program.text[range]);
    Some(mistake)
}
