//! Role of each word of a program. A mistake is made in a word of a known role, so that it is known whether another place can contradict
//! it.

use super::tree::{NodeKind, Tree};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    FormName,
    Clause,
    Option,
    Condition,
    Tag,
    TagUse,
    Variable,
    GoalWord,
    Activity,
    IndexWord,
    Function,
    Indexical,
    Attribute,
    AttributeDeclared,
    Unit,
    TypeName,
    Resource,
    Library,
    EventWord,
}

/// A word in its role.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    pub role: Role,
    pub node: usize,
    /// The top-level form around it.
    pub form: usize,
}

/// A goal that is pursued (`is_goal`) or an index.
pub struct Goal {
    pub node: usize,
    pub is_index: bool,
}

pub struct Roles<'t> {
    pub text: &'t str,
    pub tree: Tree,
    pub sites: Vec<Site>,
    pub goals: Vec<Goal>,
    attributes: Vec<String>,
    form: usize,
}

const EXPRESSIONS: [&str; 12] = [
    "duration",
    "return",
    "priority",
    "rank",
    "on-start",
    "on-end",
    "on-completion",
    "update",
    "select",
    "forall",
    "repeating",
    "responding",
];
const CONDITIONS: [&str; 6] = ["waitfor", "end-when", "restart-when", "resume-when", "suspend-when", "terminate"];
const ACTIVITIES: [&str; 6] = ["terminate", "inform", "plan", "print", "reset", "cogevent"];

impl<'t> Roles<'t> {
    /// Returns the words of `text`; `attributes` are the state variables that its program declares.
    pub fn new(text: &'t str, attributes: &[String]) -> Roles<'t> {
        let tree = Tree::new(text);
        let mut roles =
            Roles { text, tree, sites: Vec::new(), goals: Vec::new(), attributes: attributes.to_vec(), form: 0 };
        for form in roles.tree.forms.clone() {
            roles.form = form;
            roles.top(form);
            roles.anywhere(form);
        }
        roles
    }

    pub fn word(&self, node: usize) -> &'t str {
        &self.text[self.tree.nodes[node].range.clone()]
    }

    fn add(&mut self, role: Role, node: usize) {
        let form = self.form;
        self.sites.push(Site { role, node, form });
    }

    fn is(&self, node: usize, kind: NodeKind) -> bool {
        self.tree.nodes[node].kind == kind
    }

    fn children(&self, node: usize) -> Vec<usize> {
        self.tree.nodes[node].children.clone()
    }

    fn tail(&self, node: usize) -> Vec<usize> {
        self.tree.tail(node).to_vec()
    }

    fn head_site(&mut self, role: Role, list: usize) {
        if !self.tree.head(list, self.text).is_empty() {
            self.add(role, self.tree.nodes[list].children[0]);
        }
    }

    fn top(&mut self, form: usize) {
        self.head_site(Role::FormName, form);
        let tail = self.tail(form);
        match self.tree.head(form, self.text) {
            "procedure" | "primitive" | "solver" => tail.into_iter().for_each(|item| self.clause(item)),
            "defun" => tail.into_iter().skip(2).for_each(|item| self.expression(item)),
            "defindexical" => tail.into_iter().skip(1).for_each(|item| self.expression(item)),
            "state-variable" => {
                self.head_site(Role::AttributeDeclared, tail[0]);
                self.options(&tail);
            }
            "defapplication" => {
                self.options(&tail);
                for library in self.value(&tail, ":libraries").map_or(Vec::new(), |list| self.children(list)) {
                    self.add(Role::Library, library);
                }
                for agent in self.value(&tail, ":agents").map_or(Vec::new(), |list| self.children(list)) {
                    let items = self.tail(agent);
                    self.options(&items);
                    self.value(&items, ":initial-task").into_iter().for_each(|task| self.goal(task));
                }
            }
            "require-apex-library" => self.add(Role::Library, tail[0]),
            _ => {}
        }
    }

    fn value(&self, items: &[usize], option: &str) -> Option<usize> {
        let at = items.iter().position(|item| self.word(*item) == option)?;
        items.get(at + 1).copied()
    }

    fn options(&mut self, items: &[usize]) {
        for (at, item) in items.iter().enumerate() {
            let word = self.word(*item);
            if word.starts_with(':') {
                self.add(Role::Option, *item);
            }
            match at.checked_sub(1).map(|before| self.word(items[before])) {
                Some(":unit") => self.add(Role::Unit, *item),
                Some(":type") => self.add(Role::TypeName, *item),
                _ => {}
            }
        }
    }

    fn clause(&mut self, item: usize) {
        if self.is(item, NodeKind::Atom) {
            return if self.word(item).starts_with(':') {
                self.add(Role::Option, item)
            };
        }
        self.head_site(Role::Clause, item);
        let tail = self.tail(item);
        match self.tree.head(item, self.text) {
            "index" => {
                self.goals.push(Goal { node: tail[0], is_index: true });
                self.words(tail[0], Role::IndexWord);
            }
            "step" => self.step(&tail),
            "profile" => self.words(item, Role::Resource),
            "on-failure" => self.activity(tail[0]),
            name if CONDITIONS.contains(&name) => tail.into_iter().for_each(|each| self.condition(each)),
            name if EXPRESSIONS.contains(&name) => {
                self.options(&tail);
                tail.into_iter().for_each(|each| self.expression(each));
            }
            _ => {}
        }
    }

    fn step(&mut self, tail: &[usize]) {
        let mut rest = tail;
        if self.is(rest[0], NodeKind::Atom) {
            self.add(Role::Tag, rest[0]);
            rest = &rest[1..];
        }
        self.activity(rest[0]);
        for item in &rest[1..] {
            self.clause(*item);
        }
    }

    fn activity(&mut self, list: usize) {
        let head = self.tree.head(list, self.text);
        if !ACTIVITIES.contains(&head) {
            return self.goal(list);
        }
        self.head_site(Role::Activity, list);
        let tail = self.tail(list);
        match head {
            "inform" => self.words(tail[0], Role::EventWord),
            "plan" => self.goal(tail[0]),
            _ => {}
        }
    }

    fn goal(&mut self, list: usize) {
        self.goals.push(Goal { node: list, is_index: false });
        self.words(list, Role::GoalWord);
    }

    /// A word that means itself.
    fn is_plain(&self, node: usize) -> bool {
        let word = self.word(node);
        self.is(node, NodeKind::Atom) && word.starts_with(|c: char| c.is_ascii_alphabetic())
    }

    fn words(&mut self, list: usize, role: Role) {
        let before = self.tree.nodes[list].children.iter().position(|item| self.word(*item) == "=>");
        let items = self.children(list);
        let from = usize::from(role == Role::Resource);
        for item in &items[from..before.unwrap_or(items.len())] {
            if self.is_plain(*item) {
                self.add(role, *item);
            }
        }
    }

    fn expression(&mut self, node: usize) {
        if self.tree.nodes[node].quoted {
            if self.attributes.iter().any(|name| name == self.word(node)) {
                self.add(Role::Attribute, node);
            }
            return;
        }
        if !self.is(node, NodeKind::List) {
            return;
        }
        if self.tree.head(node, self.text).starts_with(|c: char| c.is_ascii_alphabetic()) {
            self.head_site(Role::Function, node);
        }
        let tail = self.tail(node);
        match self.tree.head(node, self.text) {
            "command" => {}
            "inform" => self.words(tail[0], Role::EventWord),
            _ => tail.into_iter().for_each(|each| self.expression(each)),
        }
    }

    fn condition(&mut self, node: usize) {
        if !self.is(node, NodeKind::List) {
            return;
        }
        let tail = self.tail(node);
        match self.tree.head(node, self.text) {
            ":and" | ":or" | ":in-order" => {
                self.head_site(Role::Condition, node);
                tail.into_iter().for_each(|each| self.condition(each));
            }
            ":episode" | ":measurement" => {
                self.head_site(Role::Condition, node);
                tail.into_iter().for_each(|each| self.inside(each));
            }
            "end" | "start" => self.head_site(Role::Condition, node),
            head if self.attributes.iter().any(|name| name == head) => {
                self.head_site(Role::Attribute, node);
                tail.into_iter().for_each(|each| self.expression(each));
            }
            "task-state" => self.head_site(Role::Condition, node),
            _ => self.words(node, Role::EventWord),
        }
    }

    /// Parts of an episode: its state variable, keywords at any depth, predicates.
    fn inside(&mut self, node: usize) {
        if self.word(node).starts_with(':') {
            return self.add(Role::Option, node);
        }
        let head = self.tree.head(node, self.text);
        if self.attributes.iter().any(|name| name == head) {
            return self.head_site(Role::Attribute, node);
        }
        if head.starts_with(|c: char| c.is_ascii_alphabetic()) {
            return self.expression(node);
        }
        self.children(node).into_iter().for_each(|each| self.inside(each));
    }

    /// Variables and indexicals, at any place.
    fn anywhere(&mut self, form: usize) {
        let range = self.tree.nodes[form].range.clone();
        let tags: Vec<String> = self
            .sites
            .iter()
            .filter(|site| site.form == form && site.role == Role::Tag)
            .map(|site| self.word(site.node).to_string())
            .collect();
        let is_definition = self.tree.head(form, self.text) == "defindexical";
        for node in 0..self.tree.nodes.len() {
            let inside = range.contains(&self.tree.nodes[node].range.start);
            if !inside || !self.is(node, NodeKind::Atom) {
                continue;
            }
            let word = self.word(node);
            let defined = is_definition && self.tree.nodes[form].children.get(1) == Some(&node);
            if let Some(name) = word.strip_prefix('?').filter(|name| !name.is_empty()) {
                let role = if tags.iter().any(|tag| tag == name) { Role::TagUse } else { Role::Variable };
                self.add(role, node);
            } else if word.len() > 2 && word.starts_with('+') && word.ends_with('+') && !defined {
                self.add(Role::Indexical, node);
            }
        }
    }
}
