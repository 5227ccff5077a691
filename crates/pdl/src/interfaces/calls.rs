//! Collects every goal, message and command of a program with its arguments, which are compared with declared types.

use crate::analysis::methods::{Method, Methods};
use crate::analysis::walk;
use crate::diagnostic::Span;
use crate::locate::{Locator, each};
use crate::matching::View;
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::interface::InterfaceDeclaration;
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, BuiltInActivity, Step};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// The receiver of arguments.
pub(super) enum Receiver<'l> {
    /// A goal, with the methods that may serve it.
    Goal(Vec<Method>),
    /// A declared message or command.
    Declared(&'l InterfaceDeclaration),
    /// A message that nothing declares.
    Message,
}

/// One goal, message or command.
pub(super) struct Call<'l> {
    /// The procedure or primitive that contains it.
    pub(super) owner: Option<Method>,
    /// The receiver of its arguments.
    pub(super) receiver: Receiver<'l>,
    /// Its parts, the head first, as far as their positions are known: up to the first splice.
    pub(super) items: Vec<View<'l>>,
    /// True if no further parts follow.
    pub(super) is_complete: bool,
    /// The form itself.
    pub(super) view: View<'l>,
    /// True for a message.
    pub(super) is_message: bool,
    /// The step whose goal or message this is; `None` for a form in a hook or a function.
    pub(super) step: Option<&'l Step>,
    /// The place of the form.
    pub(super) place: Place,
}

impl<'l> Call<'l> {
    /// Returns the first word.
    pub(super) fn head(&self) -> Option<&'l Symbol> {
        self.items.first().and_then(|item| item.value()).and_then(Value::as_symbol)
    }

    /// Returns the range of the argument with this number, otherwise of the form.
    pub(super) fn argument_span(&self, locator: &mut Locator<'_>, number: usize) -> Span {
        let mut found = None;
        if let (Some(datum), Some(head)) = (locator.datum(self.place), self.head()) {
            each(&datum, &mut |part| {
                let items = part.as_list().unwrap_or_default();
                let fits = items.len() == self.items.len() || !self.is_complete && items.len() > self.items.len();
                if found.is_none() && fits && part.head() == Some(head) {
                    found = items.get(number).map(|item| item.span);
                }
            });
        }
        found.unwrap_or_else(|| locator.span(self.place))
    }
}

/// All calls of a library.
pub(super) struct Calls<'l> {
    /// In order of the library.
    pub(super) all: Vec<Call<'l>>,
    /// True if a message is computed: any message may then be sent.
    pub(super) is_wild: bool,
    /// Variables of goals whose values are sent as messages.
    forwarded: Vec<(Method, &'l Symbol)>,
}

impl<'l> Calls<'l> {
    pub(super) fn new(library: &'l Library, methods: &Methods<'l>) -> Calls<'l> {
        let mut calls = Calls { all: Vec::new(), is_wild: false, forwarded: Vec::new() };
        for (number, procedure) in library.procedures.iter().enumerate() {
            let owner = Some(Method::Procedure(number));
            for step in &procedure.steps {
                let before = calls.all.len();
                for activity in walk::activities(step) {
                    match activity {
                        Activity::Goal(goal) => calls.goal(owner, goal, step.place, methods),
                        Activity::BuiltIn(BuiltInActivity::Inform | BuiltInActivity::Cogevent, arguments) => {
                            calls.message(library, owner, arguments.first(), step.place);
                        }
                        Activity::Terminate { .. } | Activity::BuiltIn(..) => {}
                    }
                }
                calls.all.iter_mut().skip(before).for_each(|call| call.step = Some(step));
            }
            walk::procedure(procedure, &mut |expr| calls.form(library, owner, expr));
        }
        for (number, primitive) in library.primitives.iter().enumerate() {
            let owner = Some(Method::Primitive(number));
            walk::primitive(primitive, &mut |expr| calls.form(library, owner, expr));
        }
        for function in library.functions.values() {
            walk::exprs(&function.body, &mut |expr| calls.form(library, None, expr));
        }
        for agent in &library.agents {
            let goal = View::Value(&agent.initial_task);
            let served = methods.serving(&Template::Constant(agent.initial_task.clone())).unwrap_or_default();
            calls.add(None, Receiver::Goal(served), goal, false, agent.place);
        }
        calls.follow(library, methods);
        calls
    }

    /// Follows messages that are passed as arguments of goals: the callers of those goals determine the messages.
    fn follow(&mut self, library: &'l Library, methods: &Methods<'l>) {
        let mut seen: BTreeSet<(Method, &'l Symbol)> = BTreeSet::new();
        let mut reaching: BTreeMap<Method, Vec<usize>> = BTreeMap::new();
        for (number, call) in self.all.iter().enumerate() {
            if let Receiver::Goal(serving) = &call.receiver {
                serving.iter().for_each(|method| reaching.entry(*method).or_default().push(number));
            }
        }
        while let Some((method, variable)) = self.forwarded.pop() {
            if !seen.insert((method, variable)) {
                continue;
            }
            let Some(position) = position(methods.index(method), variable) else {
                self.is_wild = true;
                return;
            };
            let callers = reaching.get(&method).into_iter().flatten().filter_map(|number| self.all.get(*number));
            let given: Vec<_> =
                callers.map(|call| (call.owner, call.items.get(position).copied(), call.place)).collect();
            for (owner, item, place) in given {
                match item {
                    Some(View::Template(Template::Hole(expr))) => self.message(library, owner, Some(expr), place),
                    Some(view) => self.message_view(library, owner, Some(view), place),
                    None => self.is_wild = true,
                }
            }
        }
    }

    fn add(&mut self, owner: Option<Method>, receiver: Receiver<'l>, view: View<'l>, is_message: bool, place: Place) {
        let (items, is_complete) = parts(view);
        if !items.is_empty() {
            self.all.push(Call { owner, receiver, items, is_complete, view, is_message, step: None, place });
        }
    }

    fn goal(&mut self, owner: Option<Method>, goal: &'l Template, place: Place, methods: &Methods<'l>) {
        let served = methods.serving(goal).unwrap_or_default();
        self.add(owner, Receiver::Goal(served), View::Template(goal), false, place);
    }

    /// Adds `(inform MESSAGE)`, `(cogevent MESSAGE)` or `(command COMMAND)` in a hook or a function.
    fn form(&mut self, library: &'l Library, owner: Option<Method>, expr: &'l Expr) {
        let ExprKind::Call { function, arguments } = &expr.kind else { return };
        match function.folded() {
            "inform" | "cogevent" => self.message(library, owner, arguments.first(), expr.place),
            "command" => {
                let Some(view) = arguments.first().and_then(view_of) else { return };
                let head = parts(view).0.first().and_then(|head| head.value()).and_then(Value::as_symbol);
                let declared = head.and_then(|head| library.commands.get(head));
                if let Some(declared) = declared {
                    self.add(owner, Receiver::Declared(declared), view, false, expr.place);
                }
            }
            _ => {}
        }
    }

    fn message(&mut self, library: &'l Library, owner: Option<Method>, form: Option<&'l Expr>, place: Place) {
        if let (Some(Expr { kind: ExprKind::Variable { name, .. }, .. }), Some(owner)) = (form, owner) {
            return self.forwarded.push((owner, name));
        }
        self.message_view(library, owner, form.and_then(view_of), place);
    }

    fn message_view(&mut self, library: &'l Library, owner: Option<Method>, view: Option<View<'l>>, place: Place) {
        let head = view.and_then(|view| parts(view).0.first()?.value()?.as_symbol());
        let Some((view, head)) = view.zip(head) else {
            self.is_wild = true;
            return;
        };
        let target = library.events.get(head).map_or(Receiver::Message, Receiver::Declared);
        self.add(owner, target, view, true, place);
    }
}

/// Returns the position of a variable in an index.
fn position(index: Option<&Pattern>, variable: &Symbol) -> Option<usize> {
    let Some(Pattern::List(parts)) = index else { return None };
    if parts.iter().any(|part| matches!(part, Pattern::Segment { .. } | Pattern::Guard(_))) {
        return None;
    }
    parts.iter().position(
        |part| matches!(part, Pattern::Variable(name) | Pattern::Is { variable: name, .. } if name == variable),
    )
}

/// Returns the parts of a form up to the first splice, and true if these are all.
fn parts(view: View<'_>) -> (Vec<View<'_>>, bool) {
    match view {
        View::Template(Template::List(parts)) => {
            let before = parts.iter().take_while(|part| !matches!(part, Template::Splice(_)));
            let items: Vec<View<'_>> = before.map(View::Template).collect();
            let is_complete = items.len() == parts.len();
            (items, is_complete)
        }
        _ => (view.items().unwrap_or_default(), true),
    }
}

/// Returns a literal form: `'(a b)` or `` `(a ,b) ``.
fn view_of(expr: &Expr) -> Option<View<'_>> {
    match &expr.kind {
        ExprKind::Constant(value) => Some(View::Value(value)),
        ExprKind::Template(template) => Some(View::Template(template)),
        _ => None,
    }
}
