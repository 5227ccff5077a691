//! Random questions: a condition, its creation, and everything that arrives.

use crate::rng::TestRng;
use apex_definition::condition::{
    Allen, Condition, Constraint, Cyclic, Edge, Episode, Estimation, Kind, Measurement, Regression, Relation, Span,
    Statistic, Term, Test, Time, Trend, Variable,
};
use apex_definition::{Arrival, Question, Value, What};
use std::collections::BTreeMap;

/// A second.
pub const SECOND: Span = 1_000_000_000;
/// End of every comparison.
pub const UNTIL: Time = 16 * SECOND;
/// The grid of instants and spans, on which coincidences are frequent.
const STEP: Span = SECOND / 2;

/// Added to bounds of statistics and lines, so that no value equals a bound: the rounding of the last bit is not compared.
const BESIDE: f64 = 0.123;

/// Returns the question of a seed.
pub fn question(seed: u64) -> Question {
    let mut maker = Maker { rng: TestRng::new(seed), tags: 0, cycles: false };
    let created = if maker.rng.chance(40) { 0 } else { maker.steps(1, 8) };
    let depth = maker.rng.between(0, 2);
    let condition = maker.condition(depth);
    let lateness = if maker.rng.chance(25) { maker.steps(1, 6) } else { 0 };
    let lateness = [("x".to_string(), lateness)].into_iter().filter(|(_, span)| *span > 0).collect::<BTreeMap<_, _>>();
    let late = if maker.rng.chance(30) { 25 } else { 0 };
    let count = maker.rng.between(0, 12);
    let mut arrivals: Vec<Arrival> = (0..count).map(|_| maker.arrival(late)).collect();
    if maker.cycles {
        arrivals.extend((0..12).map(|_| maker.swing(late)));
    }
    arrivals.sort_by_key(|arrival| arrival.arrives);
    Question { condition, created, arrivals, lateness }
}

struct Maker {
    rng: TestRng,
    tags: usize,
    /// The condition has cycles, which need many samples.
    cycles: bool,
}

impl Maker {
    fn steps(&mut self, low: usize, high: usize) -> Span {
        self.rng.between(low, high) as Span * STEP
    }

    /// Returns a span of the grid, or rarely one that differs by a nanosecond.
    fn span(&mut self, low: usize, high: usize) -> Span {
        let span = self.steps(low, high);
        if self.rng.chance(6) { span + 1 } else { span }
    }

    fn pick<T: Clone>(&mut self, items: &[T], other: T) -> T {
        self.rng.pick(items).unwrap_or(other)
    }

    fn arrival(&mut self, late: usize) -> Arrival {
        let arrives = self.steps(0, 24);
        let back = if self.rng.chance(late) { self.steps(1, 8).min(arrives) } else { 0 };
        if self.rng.chance(20) {
            return Arrival { arrives, at: arrives, what: What::Message(self.message()) };
        }
        let (attribute, value) = match self.rng.below(10) {
            0..6 => ("x", self.number_or_worse()),
            6..9 => ("y", self.number_or_worse()),
            _ => ("m", Some(Value::Symbol(self.pick(&["up".into(), "down".into()], String::new())))),
        };
        let object = if self.rng.chance(80) { "a" } else { "b" };
        Arrival { arrives, at: arrives - back, what: What::Sample(attribute.into(), object.into(), value) }
    }

    /// Returns one of many samples of one variable, for cycles.
    fn swing(&mut self, late: usize) -> Arrival {
        let arrives = self.steps(0, 28);
        let back = if self.rng.chance(late) { self.steps(1, 4).min(arrives) } else { 0 };
        let value = Some(Value::Number(self.number()));
        Arrival { arrives, at: arrives - back, what: What::Sample("x".into(), "a".into(), value) }
    }

    fn message(&mut self) -> Vec<Value> {
        let word = |name: &str| Value::symbol(name);
        match self.rng.below(4) {
            0 => vec![word("go")],
            1 => vec![word("stop")],
            2 => vec![word("seen"), word("a")],
            _ => vec![word("seen"), word("b")],
        }
    }

    fn number_or_worse(&mut self) -> Option<Value> {
        match self.rng.below(40) {
            0 => None,
            1 => Some(Value::Number(f64::INFINITY)),
            2 => Some(Value::symbol("unknown")),
            3 => Some(Value::Number(self.number() + 0.5)),
            _ => Some(Value::Number(self.number())),
        }
    }

    fn number(&mut self) -> f64 {
        self.rng.below(6) as f64
    }

    fn condition(&mut self, depth: usize) -> Condition {
        if depth == 0 {
            return self.leaf();
        }
        let kind = match self.rng.below(12) {
            0..3 => {
                let parts = self.parts(depth, 2, 3);
                let tests = self.tests(&parts);
                Kind::And(parts, tests)
            }
            3..5 => Kind::Or(self.parts(depth, 2, 3)),
            5 => Kind::Not(Box::new(self.condition(depth - 1))),
            6 => Kind::Absent(Box::new(self.condition(depth - 1)), self.span(2, 8)),
            7..10 => self.in_order(depth),
            _ => self.allen(),
        };
        self.tagged(kind)
    }

    fn tagged(&mut self, kind: Kind) -> Condition {
        self.tags += 1;
        let can = !matches!(
            kind,
            Kind::Delay(..)
                | Kind::Timestamp(..)
                | Kind::Function(..)
                | Kind::TaskEnded(_)
                | Kind::TaskState(..)
                | Kind::Not(_)
                | Kind::Absent(..)
        );
        Condition { tag: can.then(|| format!("t{}", self.tags)), kind }
    }

    fn parts(&mut self, depth: usize, low: usize, high: usize) -> Vec<Condition> {
        (0..self.rng.between(low, high)).map(|_| self.condition(depth - 1)).collect()
    }

    fn in_order(&mut self, depth: usize) -> Kind {
        let mut parts = Vec::new();
        for index in 0..self.rng.between(2, 3) {
            if self.rng.chance(30) && (index > 0 || self.rng.chance(30)) {
                parts.push(self.delay());
            }
            let part = if self.rng.chance(80) { self.leaf_with_evidence() } else { self.condition(depth - 1) };
            // A part without an interval has no place in an order.
            let placed = !always_anew(&part);
            parts.push(if placed { part } else { self.leaf_with_evidence() });
        }
        if self.rng.chance(15) {
            parts.push(self.delay());
        }
        let tests = self.tests(&parts);
        Kind::InOrder(parts, tests)
    }

    fn delay(&mut self) -> Condition {
        let least = self.span(0, 6);
        let most = self.rng.maybe(40, |rng| least + rng.between(0, 6) as Span * STEP);
        Condition { tag: None, kind: Kind::Delay(least, most) }
    }

    fn allen(&mut self) -> Kind {
        use Allen::{
            After, Before, Contains, Cotemporal, During, FinishedBy, Finishes, Meets, MetBy, OverlappedBy, Overlaps,
            StartedBy, Starts,
        };
        let all = [
            Before,
            After,
            Meets,
            MetBy,
            Overlaps,
            OverlappedBy,
            Starts,
            StartedBy,
            Finishes,
            FinishedBy,
            During,
            Contains,
            Cotemporal,
        ];
        let relation = self.pick(&all, Before);
        let tolerance = if self.rng.chance(30) { self.steps(1, 3) } else { 0 };
        let mut parts: Vec<Condition> = (0..self.rng.between(2, 3)).map(|_| self.leaf_with_evidence()).collect();
        if self.rng.chance(15) {
            let place = self.rng.below(parts.len());
            let delay = self.delay();
            parts.splice(place..=place, [delay]);
        }
        for part in &mut parts {
            if let Kind::Episode(episode) = &mut part.kind {
                // Statistics are of runs or windows.
                episode.any = episode.stats.is_empty() && episode.trend.is_empty() && self.rng.chance(20);
            }
        }
        let tests = self.tests(&parts);
        Kind::Allen { relation, parts, tolerance, tests }
    }

    /// Tests of two parts' tags.
    fn tests(&mut self, parts: &[Condition]) -> Vec<Test> {
        let tags: Vec<String> = parts.iter().filter_map(|part| part.tag.clone()).collect();
        // A result that is renewed at every instant has no fixed time.
        if tags.len() < 2 || parts.iter().any(always_anew) || !self.rng.chance(30) {
            return Vec::new();
        }
        let edge = |maker: &mut Maker| {
            let tag = maker.pick(&tags, String::new());
            (maker.pick(&[Edge::Start, Edge::End], Edge::Start), tag)
        };
        let (left, right) = (edge(self), edge(self));
        vec![Test::Apart(self.relation(), left, right, self.span(0, 6))]
    }

    fn leaf(&mut self) -> Condition {
        match self.rng.below(20) {
            0 => self.delay(),
            1 => {
                let from = self.moment();
                let kind = Kind::Timestamp(from, self.rng.maybe(60, |rng| from + rng.between(0, 6) as Span * STEP));
                Condition { tag: None, kind }
            }
            2 => {
                let kind = Kind::Function("x".into(), "a".into(), self.relation(), self.number());
                Condition { tag: None, kind }
            }
            _ => self.leaf_with_evidence(),
        }
    }

    fn leaf_with_evidence(&mut self) -> Condition {
        let kind = match self.rng.below(10) {
            0..2 => self.event(),
            2..5 => Kind::Measurement(self.measurement()),
            5 if self.rng.chance(25) => Kind::Cyclic(self.cyclic()),
            _ => Kind::Episode(self.episode()),
        };
        self.tagged(kind)
    }

    fn event(&mut self) -> Kind {
        let mut pattern: Vec<Term> = self.message().into_iter().map(Term::Is).collect();
        if pattern.len() == 2 && self.rng.chance(60) {
            let open = self.open_term();
            pattern.pop();
            pattern.push(open);
        }
        let when = if self.rng.chance(20) { vec![(self.order(), self.moment())] } else { Vec::new() };
        Kind::Event(pattern, when)
    }

    fn open_term(&mut self) -> Term {
        if self.rng.chance(85) { Term::Variable("o".into()) } else { Term::Any }
    }

    fn moment(&mut self) -> Time {
        self.steps(0, 20)
    }

    fn variable(&mut self) -> Variable {
        let attribute = if self.rng.chance(65) { "x" } else { "y" };
        let object = if self.rng.chance(25) { self.open_term() } else { Term::Is(Value::symbol("a")) };
        let mut tests = Vec::new();
        if matches!(object, Term::Variable(_)) && self.rng.chance(30) {
            let relation = self.pick(&[Relation::Equal, Relation::Different], Relation::Equal);
            tests.push(Constraint::Compare(relation, Value::symbol("b"), None));
        }
        Variable { attribute: attribute.into(), object, tests }
    }

    fn relation(&mut self) -> Relation {
        use Relation::{Different, Equal, Greater, GreaterOrEqual, Less, LessOrEqual};
        self.pick(&[Greater, GreaterOrEqual, Less, LessOrEqual, Greater, Less, Equal, Different], Greater)
    }

    fn order(&mut self) -> Relation {
        use Relation::{Greater, GreaterOrEqual, Less, LessOrEqual};
        self.pick(&[Greater, GreaterOrEqual, Less, LessOrEqual], Less)
    }

    fn constraint(&mut self) -> Constraint {
        let number = self.number();
        match self.rng.below(12) {
            0 => Constraint::Compare(Relation::Equal, Value::Number(number), Some(self.rng.below(3) as f64 / 2.0)),
            1 => {
                let most = number + self.rng.below(4) as f64;
                match self.rng.below(3) {
                    0 => Constraint::Range(Some(number), Some(most)),
                    1 => Constraint::Range(Some(number), None),
                    _ => Constraint::Range(None, Some(number)),
                }
            }
            _ => Constraint::Compare(self.relation(), Value::Number(number), None),
        }
    }

    fn measurement(&mut self) -> Measurement {
        if self.rng.chance(12) {
            return self.mode();
        }
        let variable = self.variable();
        let mut value = vec![self.constraint()];
        if self.rng.chance(15) {
            value.push(self.constraint());
        }
        let estimation = match self.rng.below(20) {
            0..4 => Some(Estimation::Persist(self.rng.maybe(60, |rng| rng.between(1, 8) as Span * STEP))),
            4 => Some(Estimation::Regression(self.regression())),
            _ => None,
        };
        if estimation.is_none() && self.rng.chance(10) {
            value = vec![Constraint::Bind("v".into())];
        }
        if matches!(estimation, Some(Estimation::Regression(_))) {
            value = vec![Constraint::Compare(self.order(), Value::Number(self.number() + BESIDE), None)];
        }
        let timestamp = if self.rng.chance(15) { vec![(self.order(), self.moment())] } else { Vec::new() };
        Measurement { variable, value, timestamp, estimation }
    }

    fn mode(&mut self) -> Measurement {
        let word = self.pick(&["up", "down"], "up");
        let relation = self.pick(&[Relation::Equal, Relation::Different], Relation::Equal);
        let value = vec![Constraint::Compare(relation, Value::symbol(word), None)];
        let variable = Variable { attribute: "m".into(), object: self.open_term(), tests: Vec::new() };
        Measurement { variable, value, timestamp: Vec::new(), estimation: None }
    }

    fn regression(&mut self) -> Regression {
        Regression {
            points_min: self.rng.maybe(50, |rng| rng.between(2, 4)),
            error_max: self.rng.maybe(30, |rng| rng.below(4) as f64 / 2.0 + BESIDE),
            difference_max: self.rng.maybe(30, |rng| rng.below(6) as f64 + 2.0 * BESIDE),
            gap_max: self.rng.maybe(30, |rng| rng.between(1, 8) as Span * STEP),
            start: None,
            end: None,
        }
    }

    fn episode(&mut self) -> Episode {
        let variable = self.variable();
        let mut episode = Episode {
            variable,
            any: false,
            value: if self.rng.chance(85) { vec![self.constraint()] } else { Vec::new() },
            first_value: if self.rng.chance(12) { vec![self.constraint()] } else { Vec::new() },
            last_value: if self.rng.chance(12) { vec![self.constraint()] } else { Vec::new() },
            gap: self.rng.maybe(55, |rng| rng.between(1, 8) as Span * STEP),
            start: Vec::new(),
            end: Vec::new(),
            duration: Vec::new(),
            stats: Vec::new(),
            trend: Vec::new(),
        };
        if self.rng.chance(75) {
            let relation = if self.rng.chance(80) {
                self.pick(&[Relation::Greater, Relation::GreaterOrEqual], Relation::Greater)
            } else {
                self.relation()
            };
            episode.duration.push((relation, self.span(0, 8)));
        }
        if self.rng.chance(8) {
            episode.start.push((self.order(), self.moment()));
        }
        if self.rng.chance(8) {
            episode.end.push((self.order(), self.moment()));
        }
        if self.rng.chance(15) {
            episode.stats.push(self.statistic());
        }
        if self.rng.chance(15) {
            let (trend, bound) = match self.rng.below(4) {
                0 => (Trend::Step, self.rng.below(3) as f64 - 1.0),
                1 => (Trend::Frequency, self.rng.between(1, 3) as f64),
                _ => (Trend::Rate, self.rng.below(3) as f64 - 1.0),
            };
            episode.trend.push((trend, self.order(), bound + BESIDE));
        }
        if !episode.stats.is_empty() || !episode.trend.is_empty() {
            // A window has only a least length.
            for (relation, length) in &mut episode.duration {
                (*relation, *length) = (Relation::GreaterOrEqual, (*length).max(STEP));
            }
            // A window that slides has a first and a last value.
            let slides = episode.value.is_empty() && !episode.duration.is_empty();
            let ends = |constraints: Vec<Constraint>| if slides { constraints } else { Vec::new() };
            episode = Episode {
                first_value: ends(std::mem::take(&mut episode.first_value)),
                last_value: ends(std::mem::take(&mut episode.last_value)),
                start: Vec::new(),
                end: Vec::new(),
                ..episode
            };
        }
        episode
    }

    fn cyclic(&mut self) -> Cyclic {
        self.cycles = true;
        let tests = Vec::new();
        let object = if self.rng.chance(20) { self.open_term() } else { Term::Is(Value::symbol("a")) };
        let variable = Variable { attribute: "x".into(), object, tests };
        let period = (self.order(), self.span(2, 8));
        let amplitude = self.rng.maybe(30, |rng| (rng.below(3) as f64 / 2.0 + BESIDE, rng.chance(70)));
        let relation = |greater: bool| if greater { Relation::Greater } else { Relation::Less };
        let cycles = self.rng.maybe(60, |rng| (Relation::GreaterOrEqual, rng.between(1, 3) as i64));
        Cyclic {
            variable,
            period: vec![period],
            amplitude: amplitude.into_iter().map(|(bound, greater)| (relation(greater), bound)).collect(),
            cycles: cycles.into_iter().collect(),
            hysteresis: self.rng.maybe(30, |rng| rng.between(1, 2) as f64),
        }
    }

    fn statistic(&mut self) -> (Statistic, Relation, f64) {
        use Statistic::{
            Count, Difference, Max, Mean, Median, Min, StandardDeviation, Sum, TimeWeightedDeviation, TimeWeightedMean,
            TimeWeightedVariance, Variance,
        };
        let plain = [Count, Mean, Sum, Min, Max, Median, Difference, Variance, StandardDeviation];
        let weighted = [TimeWeightedMean, TimeWeightedVariance, TimeWeightedDeviation];
        let statistics = if self.rng.chance(20) { weighted.as_slice() } else { &plain };
        (self.pick(statistics, Count), self.order(), self.number() + BESIDE)
    }
}

fn always_anew(condition: &Condition) -> bool {
    match &condition.kind {
        Kind::Not(_) | Kind::Function(..) => true,
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => {
            parts.iter().any(always_anew)
        }
        _ => false,
    }
}
