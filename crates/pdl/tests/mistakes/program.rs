//! Occurrences of a word in the rest of a program: a mistake that no other place contradicts does not count.

use super::corpus::{Corpus, Place};
use super::roles::{Goal, Role, Roles, Site};
use super::tree::{NodeKind, Tree, line_of};

/// One text with its words, and the other texts of its program.
pub struct Program<'c> {
    pub place: &'c Place,
    pub text: &'c str,
    pub roles: Roles<'c>,
    others: Vec<Roles<'c>>,
    /// The names of the other files.
    names: Vec<String>,
}

impl<'c> Program<'c> {
    pub fn new(corpus: &'c Corpus, place: &'c Place) -> Program<'c> {
        let texts = corpus.program_texts(place);
        let attributes: Vec<String> = texts.iter().flat_map(|text| declared(text)).collect();
        let text = &*corpus.texts[&place.file];
        let other_texts: Vec<&str> = texts.into_iter().filter(|other| *other != text).collect();
        let named = |text: &&str| corpus.texts.iter().find(|(_, known)| *known == text).map(|(name, _)| name.clone());
        let names = other_texts.iter().filter_map(named).collect();
        let others = other_texts.into_iter().map(|text| Roles::new(text, &attributes)).collect();
        Program { place, text, roles: Roles::new(text, &attributes), others, names }
    }

    fn all(&self) -> impl Iterator<Item = &Roles<'c>> {
        std::iter::once(&self.roles).chain(&self.others)
    }

    /// Returns the number of occurrences of the word in one of `roles` in the whole program.
    pub fn count(&self, word: &str, roles: &[Role]) -> usize {
        let in_one = |each: &Roles<'c>| {
            each.sites.iter().filter(|site| roles.contains(&site.role) && each.word(site.node) == word).count()
        };
        self.all().map(in_one).sum()
    }

    /// Returns the number of occurrences of the word in the top-level form of `site`, as atom.
    pub fn count_in_form(&self, word: &str, site: &Site) -> usize {
        let range = &self.roles.tree.nodes[site.form].range;
        let nodes = self.roles.tree.nodes.iter().enumerate();
        nodes
            .filter(|(index, node)| {
                node.kind == NodeKind::Atom && range.contains(&node.range.start) && self.roles.word(*index) == word
            })
            .count()
    }

    /// Returns true if the word occurs anywhere in the program.
    pub fn knows(&self, word: &str) -> bool {
        let is_there =
            |each: &Roles<'c>| (0..each.tree.nodes.len()).any(|node| each.word(node).eq_ignore_ascii_case(word));
        self.all().any(is_there) || apex_model::builtins::built_in(&word.to_lowercase()).is_some()
    }

    /// Returns true if the index, a node of this text, serves a goal of the program.
    pub fn is_pursued(&self, index: usize) -> bool {
        self.all()
            .any(|other| other.goals.iter().any(|goal| !goal.is_index && matches(&self.roles, index, other, goal)))
    }

    /// Returns the only place in another file that contradicts a slip at `site`: then either is right.
    pub fn only_counterpart(&self, site: &Site) -> Vec<(String, u32)> {
        let word = self.roles.word(site.node);
        let wanted = match site.role {
            Role::AttributeDeclared => [Role::Attribute].as_slice(),
            Role::IndexWord => &[Role::GoalWord, Role::IndexWord],
            _ => return Vec::new(),
        };
        let own = usize::from(site.role == Role::IndexWord);
        if self.count(word, wanted) != 1 + own {
            return Vec::new();
        }
        let found = self.others.iter().zip(&self.names).flat_map(|(other, name)| {
            let sites = other.sites.iter().filter(|each| wanted.contains(&each.role) && other.word(each.node) == word);
            sites.map(|each| (name.clone(), line_of(other.text, other.tree.nodes[each.node].range.start)))
        });
        found.collect()
    }

    /// Returns the goals of this text that the index, a node of this text, serves; none unless they are all of this text.
    pub fn goals_of(&self, index: usize) -> Vec<usize> {
        let of = |each: &Roles<'c>| -> Vec<usize> {
            let served = each.goals.iter().filter(|goal| !goal.is_index && matches(&self.roles, index, each, goal));
            served.map(|goal| goal.node).collect()
        };
        if self.others.iter().any(|other| !of(other).is_empty()) { Vec::new() } else { of(&self.roles) }
    }

    /// Returns true if no method serves the goal, a node of this text, once the text has become `changed`.
    pub fn is_unserved_with(&self, changed: &str, goal: usize) -> bool {
        let start = self.roles.tree.nodes[goal].range.start;
        let changed = Roles::new(changed, &[]);
        let Some(goal) = changed.goals.iter().find(|each| changed.tree.nodes[each.node].range.start == start) else {
            return false;
        };
        !self
            .all()
            .any(|other| other.goals.iter().any(|index| index.is_index && matches(other, index.node, &changed, goal)))
    }

    /// Returns true if the word of a goal at `site` is a word of the index that serves it, and not the name of an object.
    pub fn is_word_of_index(&self, site: &Site) -> bool {
        let Some(goal) = self.roles.tree.nodes[site.node].parent else { return false };
        let at = self.roles.tree.nodes[goal].children.iter().position(|item| *item == site.node);
        self.all().any(|other| {
            other
                .goals
                .iter()
                .filter(|index| {
                    index.is_index && matches(other, index.node, &self.roles, &Goal { node: goal, is_index: false })
                })
                .any(|index| {
                    let literal = at.and_then(|at| other.tree.nodes[index.node].children.get(at));
                    literal.is_some_and(|literal| other.word(*literal) == self.roles.word(site.node))
                })
        })
    }
}

/// Returns the state variables that a text declares.
fn declared(text: &str) -> Vec<String> {
    let tree = Tree::new(text);
    let forms = tree.forms.iter().filter(|form| tree.head(**form, text) == "state-variable");
    forms.map(|form| tree.head(tree.tail(*form)[0], text).to_string()).collect()
}

fn matches(a: &Roles<'_>, index: usize, b: &Roles<'_>, goal: &Goal) -> bool {
    let items = &a.tree.nodes[index].children;
    let parts: Vec<usize> =
        b.tree.nodes[goal.node].children.iter().copied().take_while(|part| b.word(*part) != "=>").collect();
    let literal = |item: usize| a.tree.nodes[item].kind == NodeKind::Atom && !a.word(item).starts_with('?');
    items.len() == parts.len()
        && items.iter().zip(&parts).all(|(item, part)| {
            let open = b.word(*part).starts_with('?') || b.tree.nodes[*part].kind == NodeKind::List;
            !literal(*item) || open || a.word(*item) == b.word(*part)
        })
}
