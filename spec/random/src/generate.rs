//! Random programs and inputs. The permitted contents of a program are drawn first, so that programs differ in kind and rare constructs
//! often occur together.

use crate::rng::TestRng;
use crate::steps;
use apex_reference::program::{
    Clauses, Condition, Expr, Form, Hooks, Kind, Need, Primitive, Procedure, Program, Relation, Resource, SECOND, Span,
    Term,
};
use apex_reference::{Input, Said, Value};

/// A program with its inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The program.
    pub program: Program,
    /// Inputs in order of arrival.
    pub inputs: Vec<Input>,
}

/// The last instant of a run.
pub const UNTIL: Span = 24 * SECOND;
/// Attributes of state variables.
const ATTRIBUTES: &[&str] = &["x", "y"];
const OBJECTS: &[&str] = &["v", "w"];
/// First words of messages.
const MESSAGES: &[&str] = &["e1", "e2", "e3"];
/// Subjects of messages.
const ABOUT: &[&str] = &["a", "b"];

/// Probability of each kind of construct, in percent of opportunities; 0 if the program does not use it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Taste {
    pub(crate) waitfor: usize,
    pub(crate) composites: usize,
    pub(crate) task_conditions: usize,
    pub(crate) measurements: usize,
    pub(crate) delays: usize,
    pub(crate) resources: usize,
    pub(crate) shared: usize,
    pub(crate) priorities: usize,
    pub(crate) urgency: usize,
    pub(crate) ranks: usize,
    pub(crate) costs: usize,
    pub(crate) clauses: usize,
    pub(crate) hooks: usize,
    pub(crate) repeating: usize,
    pub(crate) responding: usize,
    pub(crate) forall: usize,
    pub(crate) built_ins: usize,
    pub(crate) failures: usize,
    pub(crate) values: usize,
    pub(crate) updates: usize,
    pub(crate) hold: usize,
    pub(crate) nesting: usize,
    pub(crate) late: usize,
    pub(crate) crowds: usize,
    pub(crate) execution: usize,
    pub(crate) outcomes: usize,
}

fn taste(rng: &mut TestRng) -> Taste {
    let mut liking = |percent: usize| if rng.chance(50) { percent } else { 0 };
    Taste {
        waitfor: 30 + liking(40),
        composites: liking(35),
        task_conditions: liking(30),
        measurements: liking(40),
        delays: liking(25),
        resources: liking(80),
        shared: liking(50),
        priorities: liking(60),
        urgency: liking(10),
        ranks: liking(30),
        costs: liking(30),
        clauses: liking(25),
        hooks: liking(30),
        repeating: liking(30),
        responding: liking(20),
        forall: liking(20),
        built_ins: liking(40),
        failures: liking(35),
        values: liking(40),
        updates: liking(35),
        hold: liking(30),
        nesting: liking(60),
        // The effect of late inputs depends on when the agent was last stepped, so they are not compared yet.
        late: 0,
        crowds: liking(10),
        execution: liking(12),
        outcomes: liking(35),
    }
}

/// A goal that a step may name, with the kind of its argument.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    pub(crate) head: String,
    pub(crate) argument: Argument,
    /// True if the primitive takes time.
    pub(crate) lasts: bool,
    pub(crate) returns: bool,
}

/// The argument of a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Argument {
    None,
    Span,
    Word,
}

/// State of the generator while it makes a program.
pub(crate) struct Maker<'d> {
    pub(crate) rng: &'d mut TestRng,
    pub(crate) taste: Taste,
    pub(crate) resources: Vec<Resource>,
    /// Goals of primitives.
    pub(crate) primitives: Vec<Goal>,
    /// Goals of later procedures.
    pub(crate) procedures: Vec<Goal>,
}

/// Returns the case of a seed.
pub fn case(seed: u64) -> Case {
    let mut rng = TestRng::new(seed);
    let taste = taste(&mut rng);
    let mut maker =
        Maker { rng: &mut rng, taste, resources: Vec::new(), primitives: Vec::new(), procedures: Vec::new() };
    let program = maker.program();
    let inputs = maker.inputs();
    Case { program, inputs }
}

pub(crate) fn word(text: &str) -> Term {
    Term::Is(Value::Word(text.into()))
}

pub(crate) fn number(value: usize) -> Expr {
    Expr::Is(Value::Number(value as f64))
}

impl Maker<'_> {
    fn program(&mut self) -> Program {
        if self.rng.chance(self.taste.shared) {
            let amount = self.rng.between(2, 3) as f64;
            self.resources.push(Resource { name: "shared".into(), amount, depletable: false, part_of: None });
        }
        // With this second resource, tasks need amounts of two resources at once.
        if self.rng.chance(self.taste.shared / 2) {
            // A step and its method need at most four units; the checker rejects a need above the capacity.
            let amount = self.rng.between(4, 5) as f64;
            self.resources.push(Resource { name: "lanes".into(), amount, depletable: false, part_of: None });
        }
        if self.rng.chance(self.taste.shared / 2) {
            let amount = self.rng.between(3, 9) as f64;
            self.resources.push(Resource { name: "fuel".into(), amount, depletable: true, part_of: None });
        }
        if self.rng.chance(self.taste.shared / 2) {
            let whole = |name: &str| Resource { name: name.into(), amount: 1.0, depletable: false, part_of: None };
            let part = self.rng.pick(&["r2", "r3"]).unwrap_or("r2");
            self.resources.push(whole("r1"));
            self.resources.push(Resource { part_of: Some("r1".into()), ..whole(part) });
        }
        let primitives: Vec<Primitive> = (0..self.rng.between(2, 4)).flat_map(|n| self.primitive(n)).collect();
        let count = if self.taste.nesting > 0 { self.rng.between(1, 3) } else { 0 };
        let mut procedures = Vec::new();
        for number in (0..=count).rev() {
            let procedure = self.procedure(number);
            procedures.insert(0, procedure);
        }
        Program { resources: self.resources.clone(), procedures, primitives }
    }

    /// Returns a span of a few half seconds. The same spans are frequent, so that instants coincide.
    pub(crate) fn span(&mut self) -> Span {
        self.rng.pick(&[1, 2, 2, 2, 3, 4, 4, 6, 10]).unwrap_or(2) * (SECOND / 2)
    }

    fn duration(&mut self) -> Span {
        if self.rng.chance(12) { 0 } else { self.span() }
    }

    /// Returns a primitive, or sometimes two, where one of them serves a single word.
    fn primitive(&mut self, number: usize) -> Vec<Primitive> {
        let head = format!("p{number}");
        let argument = self.rng.pick(&[Argument::None, Argument::Span, Argument::Word]).unwrap_or(Argument::None);
        let mut made = Primitive { index: vec![word(&head)], ..Primitive::default() };
        match argument {
            Argument::None => {}
            Argument::Span => made.index.push(Term::Variable("d".into())),
            Argument::Word if self.rng.chance(self.taste.failures) => made.index.push(word("a")),
            Argument::Word => made.index.push(Term::Variable("w".into())),
        }
        made.profile = self.profile(true);
        let span = self.duration();
        made.duration = match argument {
            Argument::Span => Some(Expr::Variable("d".into())),
            _ => self.rng.maybe(80, |_| Expr::Is(Value::Span(span))),
        };
        let about = (argument == Argument::Word && made.index.iter().any(|term| matches!(term, Term::Variable(_))))
            .then_some("w");
        if self.rng.chance(self.taste.updates) {
            self.updates(&mut made);
        }
        let locals = made.locals.clone();
        made.hooks = self.hooks(about);
        if self.rng.chance(self.taste.hooks) {
            made.on_completion = vec![self.form(about)];
        }
        made.returns = self.rng.maybe(self.taste.values, |rng| match (rng.below(3), about, locals.first()) {
            (0, Some(name), _) => Expr::Variable(name.into()),
            (_, _, Some((name, _))) => Expr::Variable(name.clone()),
            _ => Expr::Is(Value::Word("a".into())),
        });
        let lasts =
            made.duration.as_ref().is_some_and(|expr| *expr != Expr::Is(Value::Span(0))) || made.update.is_some();
        self.primitives.push(Goal { head: head.clone(), argument, lasts, returns: made.returns.is_some() });
        let mut both = vec![made.clone()];
        if argument == Argument::Word && self.rng.chance(30) {
            let index = if about.is_some() { vec![word(&head), word("a")] } else { vec![word(&head), word("b")] };
            let duration = Some(Expr::Is(Value::Span(self.span())));
            both.push(Primitive { index, duration, ..Primitive::default() });
        }
        both
    }

    /// Adds updates that count, and may complete the primitive or publish the count.
    fn updates(&mut self, made: &mut Primitive) {
        let local = || Expr::Variable("n".into());
        made.locals = vec![("n".into(), number(0))];
        let mut forms = vec![Form::Set("n".into(), Expr::Sum(Box::new(local()), Box::new(number(1))))];
        if self.rng.chance(50) {
            forms.push(Form::Publish("x".into(), "v".into(), local()));
        }
        let last = self.rng.between(1, 4);
        let test = Expr::Compare(Relation::Equal, Box::new(local()), Box::new(number(last)));
        let value = self.rng.maybe(50, |_| local());
        forms.push(Form::When(test, Box::new(Form::Complete(value))));
        let interval = self.span();
        made.update = Some((interval, forms));
        if self.rng.chance(60) {
            made.duration = made.duration.take().filter(|expr| matches!(expr, Expr::Variable(_)));
        }
    }

    fn procedure(&mut self, number: usize) -> Procedure {
        let kinds = [Kind::Concurrent, Kind::Concurrent, Kind::Sequential, Kind::Ranked, Kind::SoftSequential];
        let kind = self.rng.pick(&kinds).unwrap_or(Kind::Concurrent);
        let head = if number == 0 { "do-domain".to_string() } else { format!("g{number}") };
        let mut index = vec![word(&head)];
        let about = (number > 0 && self.rng.chance(50)).then_some("p");
        index.extend(about.map(|name| Term::Variable(name.into())));
        let steps = self.steps(kind, about, number == 0);
        let tags: Vec<String> = steps.iter().map(|step| step.tag.clone()).collect();
        let clauses = if number == 0 { Clauses::default() } else { self.clauses(&tags, about, true) };
        let interrupt_cost = self.rng.maybe(self.taste.costs / 2, steps::small_number);
        let expected = self.rng.maybe(self.taste.costs / 2, |rng| rng.between(1, 6) as Span * SECOND);
        let profile = if number == 0 { Vec::new() } else { self.profile(false) };
        let hooks = if number == 0 { Hooks::default() } else { self.hooks(about) };
        let argument = if about.is_some() { Argument::Word } else { Argument::None };
        let lasts = !clauses_empty(&clauses);
        self.procedures.push(Goal { head, argument, lasts, returns: true });
        Procedure { kind, index, profile, interrupt_cost, expected, clauses, hooks, steps }
    }

    /// Returns the required resources; shares only at the leaves.
    pub(crate) fn profile(&mut self, leaf: bool) -> Vec<Need> {
        let mut needs: Vec<Need> = Vec::new();
        let wanted = if leaf { self.taste.resources } else { self.taste.resources / 3 };
        let refuse_if_busy = self.rng.chance(self.taste.execution / 3);
        for name in ["r1", "r2", "r3"] {
            if (name != "r3" || self.resources.iter().any(|each| each.name == "r3")) && self.rng.chance(wanted * 2 / 3)
            {
                needs.push(Need { resource: word(name), amount: None, refuse_if_busy });
            }
        }
        for resource in self.resources.clone().into_iter().filter(|each| !each.name.starts_with('r')) {
            if leaf && self.rng.chance(40) {
                let amount = Some(self.rng.between(1, 2) as f64);
                needs.push(Need { resource: word(&resource.name), amount, refuse_if_busy });
            }
        }
        needs
    }

    pub(crate) fn hooks(&mut self, about: Option<&str>) -> Hooks {
        let percent = self.taste.hooks;
        let mut some = || if self.rng.chance(percent) { vec![self.form(about)] } else { Vec::new() };
        Hooks { on_start: some(), on_end: some(), on_suspend: some(), on_resume: some() }
    }

    /// Returns a form that any hook may contain.
    fn form(&mut self, about: Option<&str>) -> Form {
        match self.rng.below(6) {
            0 => Form::Publish("x".into(), "v".into(), number(self.rng.below(6))),
            1 => Form::Print(Expr::MissionTime).with(self.rng),
            2 if about.is_some() => Form::Print(Expr::Variable(about.unwrap_or_default().into())),
            3 if about == Some("p") => Form::Set("p".into(), Expr::Is(Value::Word("b".into()))),
            _ => Form::Inform(self.message(about)),
        }
    }

    /// Returns a message without unbound variables.
    pub(crate) fn message(&mut self, about: Option<&str>) -> Vec<Term> {
        let mut words = vec![word(self.rng.pick(MESSAGES).unwrap_or("e1"))];
        if self.rng.chance(50) {
            words.push(match about {
                Some(name) if self.rng.chance(60) => Term::Variable(name.into()),
                _ => word(self.rng.pick(ABOUT).unwrap_or("a")),
            });
        }
        words
    }

    fn inputs(&mut self) -> Vec<Input> {
        let mut inputs: Vec<Input> = Vec::new();
        for _ in 0..self.rng.between(0, 14) {
            let arrives = self.rng.below(24) as Span * (SECOND / 2);
            // Several inputs often arrive at once.
            for _ in 0..self.rng.pick(&[1, 1, 1, 2, 3]).unwrap_or(1) {
                let late = if self.rng.chance(self.taste.late) { self.span().min(arrives) } else { 0 };
                let said = self.said();
                inputs.push(Input { arrives, at: arrives - late, said });
            }
        }
        inputs.sort_by_key(|input| input.arrives);
        inputs
    }

    fn said(&mut self) -> Said {
        if self.rng.chance(self.taste.measurements) {
            let attribute = self.rng.pick(ATTRIBUTES).unwrap_or("x").to_string();
            let object = self.rng.pick(OBJECTS).unwrap_or("v").to_string();
            return Said::Sample(attribute, object, Value::Number(self.rng.below(6) as f64));
        }
        let words = self.message(None);
        Said::Message(
            words
                .into_iter()
                .filter_map(|term| match term {
                    Term::Is(value) => Some(value),
                    _ => None,
                })
                .collect(),
        )
    }

    /// Returns a message that is waited for; a variable that is new is added to `bound`.
    pub(crate) fn event(&mut self, about: Option<&str>, bound: &mut Vec<String>, fresh: &str) -> Condition {
        let mut words = vec![word(self.rng.pick(MESSAGES).unwrap_or("e1"))];
        match self.rng.below(8) {
            0..3 => {}
            3..5 => words.push(word(self.rng.pick(ABOUT).unwrap_or("a"))),
            5 if about.is_some() => words.push(Term::Variable(about.unwrap_or_default().into())),
            6 => words.push(Term::Anything),
            _ => {
                words.push(Term::Variable(fresh.into()));
                bound.push(fresh.into());
            }
        }
        Condition::Event(words)
    }

    pub(crate) fn measurement(&mut self) -> Condition {
        let relations = [Relation::Less, Relation::AtMost, Relation::More, Relation::AtLeast];
        let relation = self.rng.pick(&relations).unwrap_or(Relation::Less);
        let attribute = self.rng.pick(ATTRIBUTES).unwrap_or("x").to_string();
        let object = word(self.rng.pick(OBJECTS).unwrap_or("v"));
        Condition::Measurement(attribute, object, relation, self.rng.below(6) as f64)
    }
}

trait With {
    fn with(self, rng: &mut TestRng) -> Self;
}

impl With for Form {
    /// Returns a form that prints a number instead of the form's own value, because executive and reference print spans differently.
    fn with(self, rng: &mut TestRng) -> Form {
        Form::Print(number(rng.below(9)))
    }
}

fn clauses_empty(clauses: &Clauses) -> bool {
    *clauses == Clauses::default()
}
