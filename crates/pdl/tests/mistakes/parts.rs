//! Mistakes in the parts of forms: something forgotten, given twice, or in the wrong order.

use super::mistake::{Mistake, remove, replace, replaced};
use super::program::Program;
use super::rng::TestRng;
use super::roles::{Role, Site};
use super::tree::line_of;
use apex_model::builtins::built_in;

fn line(program: &Program<'_>, node: usize) -> u32 {
    line_of(program.text, program.roles.tree.nodes[node].range.start)
}

fn sites(program: &Program<'_>, role: Role) -> Vec<Site> {
    program.roles.sites.iter().filter(|site| site.role == role).copied().collect()
}

/// Returns the lists that begin with a clause of one of these names.
fn clauses(program: &Program<'_>, names: &[&str]) -> Vec<usize> {
    let named = |site: &Site| names.contains(&program.roles.word(site.node));
    sites(program, Role::Clause)
        .into_iter()
        .filter(named)
        .filter_map(|site| program.roles.tree.nodes[site.node].parent)
        .collect()
}

/// Returns a step forgotten that others wait for.
pub fn without_step(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let tag = *rng.pick(&sites(program, Role::Tag))?;
    let step = program.roles.tree.nodes[tag.node].parent?;
    let range = program.roles.tree.nodes[step].range.clone();
    let name = format!("?{}", program.roles.word(tag.node));
    let uses: Vec<usize> = sites(program, Role::TagUse)
        .iter()
        .filter(|site| site.form == tag.form && program.roles.word(site.node) == name)
        .map(|site| site.node)
        .filter(|node| !range.contains(&program.roles.tree.nodes[*node].range.start))
        .collect();
    let mut mistake = remove(program, range.clone(), "step forgotten");
    let removed = u32::try_from(program.text.matches('\n').count() - mistake.text.matches('\n').count()).unwrap();
    let last = line_of(program.text, range.end);
    mistake.lines.extend(
        uses.iter().map(|node| line(program, *node)).map(|line| if line > last { line - removed } else { line }),
    );
    (!uses.is_empty()).then_some(mistake)
}

/// Returns a step renamed without the conditions that wait for it: the mistake is visible at them, or at the step.
pub fn renamed_step(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let tag = *rng.pick(&sites(program, Role::Tag))?;
    let name = format!("?{}", program.roles.word(tag.node));
    let uses: Vec<Site> = sites(program, Role::TagUse)
        .into_iter()
        .filter(|site| site.form == tag.form && program.roles.word(site.node) == name)
        .collect();
    let new = *rng.pick(&["begin", "again", "inspect", "approach", "wrap-up"])?;
    if uses.is_empty() || program.knows(new) {
        return None;
    }
    let mut mistake = replace(program, program.roles.tree.nodes[tag.node].range.clone(), new);
    mistake.lines.extend(uses.iter().map(|site| line(program, site.node)));
    Some(mistake)
}

/// Returns a step that waits for its own end.
pub fn waits_for_itself(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let tag = *rng.pick(&sites(program, Role::TagUse))?;
    let tree = &program.roles.tree;
    let end = tree.nodes[tag.node].parent.filter(|list| tree.head(*list, program.text) == "end")?;
    let mut step = end;
    while tree.head(step, program.text) != "step" {
        step = tree.nodes[step].parent?;
    }
    let own = program.roles.word(*tree.tail(step).first()?);
    let range = tree.nodes[tag.node].range.clone();
    (!own.starts_with('(')).then(|| replace(program, range, &format!("?{own}")))
}

/// Returns two steps with one tag.
pub fn same_tag(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let tags = sites(program, Role::Tag);
    let (one, other) = (*rng.pick(&tags)?, *rng.pick(&tags)?);
    if one.node == other.node || one.form != other.form {
        return None;
    }
    let mut mistake =
        replace(program, program.roles.tree.nodes[one.node].range.clone(), program.roles.word(other.node));
    mistake.lines.push(line(program, other.node));
    Some(mistake)
}

/// Returns a goal without one of its arguments.
pub fn goal_without_argument(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let goals: Vec<usize> = program.roles.goals.iter().filter(|goal| !goal.is_index).map(|goal| goal.node).collect();
    let goal = *rng.pick(&goals)?;
    let item = *rng.pick(program.roles.tree.tail(goal))?;
    let is_argument = !program.roles.word(item).starts_with(|c: char| c.is_ascii_alphabetic() || c == '=');
    let range = program.roles.tree.nodes[item].range.clone();
    let mistake = remove(program, range, "argument forgotten");
    (is_argument && program.is_unserved_with(&mistake.text, goal)).then_some(mistake)
}

/// Returns two words of a goal in the wrong order.
pub fn swapped_words(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let goals: Vec<usize> = program.roles.goals.iter().filter(|goal| !goal.is_index).map(|goal| goal.node).collect();
    let goal = *rng.pick(&goals)?;
    let items = program.roles.tree.tail(goal);
    let at = rng.below(items.len());
    let (one, other) = (*items.get(at)?, *items.get(at + 1)?);
    let (a, b) = (program.roles.tree.nodes[one].range.clone(), program.roles.tree.nodes[other].range.clone());
    let (left, right) = (program.roles.word(one), program.roles.word(other));
    if program.text[a.end..b.start].trim() != "" || [left, right].contains(&"=>") {
        return None;
    }
    let mistake = replace(program, a.start..b.end, &format!("{right}{}{left}", &program.text[a.end..b.start]));
    program.is_unserved_with(&mistake.text, goal).then_some(mistake)
}

/// Returns a function called without one of the arguments that it needs.
pub fn call_without_argument(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let function = *rng.pick(&sites(program, Role::Function))?;
    let list = program.roles.tree.nodes[function.node].parent?;
    let needed = built_in(program.roles.word(function.node))?.arguments_min;
    let arguments = program.roles.tree.tail(list);
    if arguments.len() != needed {
        return None;
    }
    let range = program.roles.tree.nodes[*arguments.last()?].range.clone();
    Some(remove(program, range, "argument forgotten"))
}

/// Returns an option without its value.
pub fn option_without_value(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let option = *rng.pick(&sites(program, Role::Option))?;
    let siblings = &program.roles.tree.nodes[program.roles.tree.nodes[option.node].parent?].children;
    let value = *siblings.get(siblings.iter().position(|item| *item == option.node)? + 1)?;
    if program.roles.word(value).starts_with(':') || siblings[0] == option.node {
        return None;
    }
    Some(remove(program, program.roles.tree.nodes[value].range.clone(), "value forgotten"))
}

/// Returns an episode without its quality.
pub fn without_quality(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let is_quality = |site: &Site| program.roles.word(site.node) == ":quality";
    let options: Vec<Site> = sites(program, Role::Option).into_iter().filter(is_quality).collect();
    let option = rng.pick(&options)?;
    let tree = &program.roles.tree;
    let episode = tree.nodes[option.node].parent?;
    let siblings = &tree.nodes[episode].children;
    let value = *siblings.get(siblings.iter().position(|item| *item == option.node)? + 1)?;
    let range = tree.nodes[option.node].range.start..tree.nodes[value].range.end;
    let mut mistake = remove(program, range, "quality forgotten");
    mistake.lines.push(line(program, episode));
    Some(mistake)
}

/// Returns a repeated clause that may occur only once.
pub fn clause_twice(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let once = clauses(
        program,
        &["waitfor", "forall", "repeating", "responding", "on-failure", "index", "restart-when", "duration"],
    );
    let clause = *rng.pick(&once)?;
    let range = program.roles.tree.nodes[clause].range.clone();
    let (first, last) = (line_of(program.text, range.start), line_of(program.text, range.end));
    let copy = format!(" {}", &program.text[range.clone()]);
    let what = format!("({} ..) twice", program.roles.tree.head(clause, program.text));
    Some(replaced(program, &[(range.end..range.end, copy)], vec![first, last], what))
}

/// Returns a procedure or primitive without its index.
pub fn without_index(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let index = *rng.pick(&clauses(program, &["index"]))?;
    let form = program.roles.tree.nodes[index].parent?;
    let mut mistake = remove(program, program.roles.tree.nodes[index].range.clone(), "index forgotten");
    mistake.lines.push(line(program, form));
    Some(mistake)
}

/// Returns a concurrent procedure without the step that ends it.
pub fn without_end(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let is_end = |site: &Site| program.roles.word(site.node) == "terminate";
    let ends: Vec<Site> = sites(program, Role::Activity).into_iter().filter(is_end).collect();
    let end = rng.pick(&ends)?;
    let step = program.roles.tree.nodes[program.roles.tree.nodes[end.node].parent?].parent?;
    let mut mistake = remove(program, program.roles.tree.nodes[step].range.clone(), "end forgotten");
    mistake.lines.push(line(program, end.form));
    Some(mistake)
}

/// Returns a program without a procedure, primitive or function that others need. Permitted are the lines that need it, in any text of
/// the program; the scorer finds them.
pub fn without_definition(program: &Program<'_>, rng: &mut TestRng) -> Option<Mistake> {
    let form = *rng.pick(&program.roles.tree.forms)?;
    let own = |node: usize| program.roles.tree.nodes[form].range.contains(&program.roles.tree.nodes[node].range.start);
    let text = program.text;
    let needs: Vec<u32> = match program.roles.tree.head(form, text) {
        "procedure" | "primitive" => {
            let index = program.roles.goals.iter().find(|goal| goal.is_index && own(goal.node))?;
            program.goals_of(index.node).into_iter().map(|node| line(program, node)).collect()
        }
        "defun" | "defindexical" => {
            let name = program.roles.word(*program.roles.tree.tail(form).first()?);
            let uses =
                program.roles.sites.iter().filter(|site| program.roles.word(site.node) == name && !own(site.node));
            uses.map(|site| line(program, site.node)).collect()
        }
        _ => return None,
    };
    let end = line_of(text, program.roles.tree.nodes[form].range.end);
    let mut mistake = remove(program, program.roles.tree.nodes[form].range.clone(), "definition forgotten");
    let removed = u32::try_from(text.matches('\n').count() - mistake.text.matches('\n').count()).unwrap();
    mistake.lines = needs.iter().map(|line| if *line > end { line - removed } else { *line }).collect();
    (!needs.is_empty()).then_some(mistake)
}
