//! Reading a checked model from the text of a model file.

use crate::bits::Bits;
use crate::error::{DiagnosisError, FileName, nearest};
use crate::formula::{Formula, TooManyTerms};
use crate::limits::{MODES_MAX, TERMS_MAX, TESTS_MAX};
use crate::model::{Component, FailureMode, Model, Monitor, Test};
use crate::raw::{RawComponent, RawMode, RawModel, RawMonitor, RawNeed, RawTest};
use std::collections::BTreeMap;

/// The version of the format, the value of `format`.
const FORMAT: &str = "apex-diagnosis-1";
/// Maximum nesting of signals. Each level is one recursive call, and real systems are less deep.
const DEPTH_MAX: usize = 200;

type ModelResult<T> = Result<T, DiagnosisError>;

impl Model {
    /// Reads the text of a model file; `file` is its name in errors.
    ///
    /// # Errors
    /// Text that is not JSON; members that are unknown, repeated, missing or of the wrong type; no components or no tests; names that are
    /// declared twice or not at all; signals that need each other in a circle; signals and tests that depend on nothing; impossible
    /// probabilities; redundancy beyond [`TERMS_MAX`]; more than [`MODES_MAX`] failure modes or [`TESTS_MAX`] tests.
    pub fn parse(file: &str, text: &str) -> Result<Model, DiagnosisError> {
        let file = FileName(file);
        let raw: RawModel = serde_json::from_str(text).map_err(|error| file.unreadable(&error))?;
        if raw.format != FORMAT {
            let reason = format!("expected {FORMAT:?}, found {:?}", raw.format);
            return Err(file.error("format", reason, "write the version that this program reads"));
        }
        for (what, place, count) in
            [("components", "components", raw.components.len()), ("tests", "tests", raw.tests.len())]
        {
            if count == 0 {
                let reason = format!("the model has no {what}");
                return Err(file.error(place, reason, "describe at least one component and one test"));
            }
        }
        let mut reader = ModelReader::new(file, &raw);
        reader.declare()?;
        reader.modes()?;
        reader.model()
    }
}

/// Meaning of a name, by index.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Named {
    Component(usize),
    Signal(usize),
    Test(usize),
}

struct ModelReader<'a> {
    file: FileName<'a>,
    raw: &'a RawModel,
    names: BTreeMap<&'a str, Named>,
    components: Vec<Component>,
    modes: Vec<FailureMode>,
    /// Signals and tests that each failure mode affects; `None`: all that need its component.
    affects: Vec<Option<&'a [String]>>,
    formulas: BTreeMap<usize, Formula>,
    /// Signals that are being followed, outermost first.
    path: Vec<usize>,
}

impl<'a> ModelReader<'a> {
    fn new(file: FileName<'a>, raw: &'a RawModel) -> ModelReader<'a> {
        ModelReader {
            file,
            raw,
            names: BTreeMap::new(),
            components: Vec::new(),
            modes: Vec::new(),
            affects: Vec::new(),
            formulas: BTreeMap::new(),
            path: Vec::new(),
        }
    }

    /// Checks and registers all names.
    fn declare(&mut self) -> ModelResult<()> {
        let components = self.raw.components.iter().map(|component| component.name.as_str());
        let signals = self.raw.signals.iter().map(|signal| signal.name.as_str());
        let tests = self.raw.tests.iter().map(|test| test.name.as_str());
        let components = components.enumerate().map(|(index, name)| (name, Named::Component(index)));
        let signals = signals.enumerate().map(|(index, name)| (name, Named::Signal(index)));
        let tests = tests.enumerate().map(|(index, name)| (name, Named::Test(index)));
        for (name, named) in components.chain(signals).chain(tests) {
            let place = place_of(named, "name");
            self.check_name(name, &place)?;
            if let Some(first) = self.names.insert(name, named) {
                let reason = format!("`{name}` is declared twice, first as `{}`", place_of(first, "name"));
                return Err(self.file.error(place, reason, "give components, signals and tests different names"));
            }
        }
        self.check_count("tests", self.raw.tests.len(), TESTS_MAX)
    }

    fn check_name(&self, name: &str, place: &str) -> ModelResult<()> {
        let is_symbol = name.starts_with(|first: char| first.is_ascii_lowercase())
            && name.chars().all(|letter| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-');
        if is_symbol {
            return Ok(());
        }
        let help = "write a symbol of PDL: lower-case letters, digits and `-`, a letter first, as in `main-bus`";
        Err(self.file.error(place, format!("{name:?} is not a name"), help))
    }

    fn check_count(&self, place: &str, count: usize, most: usize) -> ModelResult<()> {
        if count <= most {
            return Ok(());
        }
        let reason = format!("found {count}, expected at most {most}");
        Err(self.file.error(place, reason, "split the system into several models"))
    }

    /// Reads the failure modes of all components.
    fn modes(&mut self) -> ModelResult<()> {
        for (index, raw) in self.raw.components.iter().enumerate() {
            let place = format!("components[{index}]");
            let first = self.modes.len();
            match (&raw.modes, raw.probability_per_hour) {
                (None, Some(probability)) => {
                    let title = raw.title.clone().unwrap_or_else(|| raw.name.clone());
                    let place = format!("{place}.probability_per_hour");
                    self.mode(raw.name.clone(), title, index, (probability, &place), raw.intermittent)?;
                    self.affects.push(None);
                }
                (Some(modes), None) if !raw.intermittent => self.named_modes(raw, modes, index)?,
                (None, None) => {
                    let reason = format!("`{}` cannot fail", raw.name);
                    let help = "state `probability_per_hour`, or `modes` with one for each";
                    return Err(self.file.error(place, reason, help));
                }
                (Some(_), _) => {
                    let reason = "`probability_per_hour` and `intermittent` belong to the failure modes here";
                    return Err(self.file.error(place, reason, "move them into `modes`"));
                }
            }
            self.components.push(Component {
                name: raw.name.clone(),
                title: raw.title.clone().unwrap_or_else(|| raw.name.clone()),
                modes: (first..self.modes.len()).collect(),
                response: raw.response.clone(),
            });
            self.check_form(raw.response.as_deref(), &format!("{place}.response"))?;
        }
        self.check_count("components", self.modes.len(), MODES_MAX)?;
        self.check_affected()
    }

    fn named_modes(&mut self, component: &'a RawComponent, modes: &'a [RawMode], index: usize) -> ModelResult<()> {
        let place = format!("components[{index}].modes");
        if modes.is_empty() {
            let help = "name its failure modes, or state `probability_per_hour` of the component";
            return Err(self.file.error(place, "the list is empty", help));
        }
        for (number, raw) in modes.iter().enumerate() {
            let place = format!("{place}[{number}]");
            self.check_name(&raw.name, &format!("{place}.name"))?;
            if let Some(first) = modes.iter().take(number).position(|other| other.name == raw.name) {
                let reason = format!("`{}` is also the name of mode {first}", raw.name);
                return Err(self.file.error(format!("{place}.name"), reason, "give the modes different names"));
            }
            let whole = component.title.as_ref().unwrap_or(&component.name);
            let title = raw.title.clone().unwrap_or_else(|| format!("{whole}: {}", raw.name));
            let name = format!("{}/{}", component.name, raw.name);
            let place = format!("{place}.probability_per_hour");
            self.mode(name, title, index, (raw.probability_per_hour, &place), raw.intermittent)?;
            self.affects.push(raw.affects.as_deref());
        }
        Ok(())
    }

    fn mode(
        &mut self,
        name: String,
        title: String,
        component: usize,
        (probability_per_hour, place): (f64, &str),
        is_intermittent: bool,
    ) -> ModelResult<()> {
        if !(probability_per_hour > 0.0 && probability_per_hour < 0.5) {
            let reason = format!("the probability {probability_per_hour} is not above 0 and below 0.5");
            let help = "state how probable this failure is in an hour of flight, such as 1e-4";
            return Err(self.file.error(place, reason, help));
        }
        self.modes.push(FailureMode { name, title, component, probability_per_hour, is_intermittent });
        Ok(())
    }

    /// Checks that a response is one form in parentheses, so that the generated PDL can be parsed.
    fn check_form(&self, text: Option<&str>, place: &str) -> ModelResult<()> {
        let Some(text) = text else { return Ok(()) };
        let mut depth = 0_i32;
        let mut ends = 0;
        for letter in text.chars() {
            depth += i32::from(letter == '(') - i32::from(letter == ')');
            ends += i32::from(letter == ')' && depth == 0);
        }
        let is_form = text.starts_with('(') && text.ends_with(')') && depth == 0 && ends == 1;
        if is_form && !text.contains([';', '"', '|']) {
            return Ok(());
        }
        let help = "write one form of PDL in parentheses, without strings and comments";
        Err(self.file.error(place, format!("{text:?} is not a form"), help))
    }

    /// Checks that everything that a failure mode affects exists and needs its component.
    fn check_affected(&self) -> ModelResult<()> {
        for (index, component) in self.raw.components.iter().enumerate() {
            for (number, mode) in component.modes.iter().flatten().enumerate() {
                for (at, affected) in mode.affects.iter().flatten().enumerate() {
                    let place = format!("components[{index}].modes[{number}].affects[{at}]");
                    let needs = match self.names.get(affected.as_str()) {
                        Some(Named::Signal(signal)) => self.raw.signals.get(*signal).map(|signal| &signal.needs),
                        Some(Named::Test(test)) => self.raw.tests.get(*test).map(|test| &test.needs),
                        Some(Named::Component(_)) | None => None,
                    };
                    let Some(needs) = needs else {
                        let reason = format!("`{affected}` is not a signal or test");
                        let known = self.names.iter().filter(|(_, named)| !matches!(named, Named::Component(_)));
                        return Err(self.file.error(place, reason, nearest(affected, known.map(|(name, _)| *name))));
                    };
                    if !names_of(needs).any(|need| *need == component.name) {
                        let reason = format!("`{affected}` does not need `{}` itself", component.name);
                        let help = "name signals and tests whose `needs` name the component";
                        return Err(self.file.error(place, reason, help));
                    }
                }
                if mode.affects.as_ref().is_some_and(Vec::is_empty) {
                    let place = format!("components[{index}].modes[{number}].affects");
                    let help = "name what it affects, or leave `affects` out: it then affects everything";
                    return Err(self.file.error(place, "the list is empty", help));
                }
            }
        }
        Ok(())
    }

    fn model(mut self) -> ModelResult<Model> {
        // Resolves all signals, including unused ones, so that every circle is found.
        for signal in 0..self.raw.signals.len() {
            self.signal(signal)?;
        }
        let mut tests = Vec::new();
        for (index, raw) in self.raw.tests.iter().enumerate() {
            let formula = self.formula(&raw.needs, Named::Test(index), &raw.name)?;
            let monitor = self.monitor(raw, index)?;
            let title = raw.title.clone().unwrap_or_else(|| raw.name.clone());
            tests.push(Test { name: raw.name.clone(), title, monitor, formula });
        }
        let unused_signals = self.unused_signals();
        Ok(Model { name: self.raw.name.clone(), components: self.components, modes: self.modes, tests, unused_signals })
    }

    fn monitor(&self, raw: &RawTest, index: usize) -> ModelResult<Option<Monitor>> {
        let Some(RawMonitor { fails, passes }) = &raw.monitor else { return Ok(None) };
        for (key, text) in [("fails", fails), ("passes", passes)] {
            self.check_form(Some(text), &format!("tests[{index}].monitor.{key}"))?;
        }
        Ok(Some(Monitor { fails: fails.clone(), passes: passes.clone() }))
    }

    /// Returns the formula of a signal, after resolving its needs.
    fn signal(&mut self, signal: usize) -> ModelResult<Formula> {
        if let Some(known) = self.formulas.get(&signal) {
            return Ok(known.clone());
        }
        let Some(raw) = self.raw.signals.get(signal) else { return Ok(Formula::never(self.modes.len())) };
        if let Some(start) = self.path.iter().position(|open| *open == signal) {
            let name = |index: &usize| self.raw.signals.get(*index).map_or("", |signal| signal.name.as_str());
            let circle: Vec<&str> = self.path.iter().skip(start).chain([&signal]).map(name).collect();
            let reason = format!("signals need each other in a circle: {}", circle.join(" -> "));
            let help = "remove the feedback: describe the loop as one signal that needs all of its components";
            return Err(self.file.error(place_of(Named::Signal(signal), "needs"), reason, help));
        }
        if self.path.len() >= DEPTH_MAX {
            let reason = format!("signals need each other {DEPTH_MAX} levels deep");
            return Err(self.file.error(place_of(Named::Signal(signal), "needs"), reason, "flatten the model"));
        }
        self.path.push(signal);
        let formula = self.formula(&raw.needs, Named::Signal(signal), &raw.name)?;
        self.path.pop();
        self.formulas.insert(signal, formula.clone());
        Ok(formula)
    }

    /// Returns the condition for the loss of a signal, or the failure of a test, that needs all of `needs`.
    fn formula(&mut self, needs: &'a [RawNeed], whose: Named, name: &str) -> ModelResult<Formula> {
        let place = place_of(whose, "needs");
        let modes = self.modes.len();
        let mut parts = Vec::new();
        for (index, need) in needs.iter().enumerate() {
            let place = format!("{place}[{index}]");
            parts.push(match need {
                RawNeed::One(need) => self.need(need, &place, name)?,
                RawNeed::AnyOf(names) if names.len() < 2 => {
                    let reason = "`any_of` names fewer than two";
                    return Err(self.file.error(
                        place,
                        reason,
                        "name what replaces each other, or the one thing needed",
                    ));
                }
                RawNeed::AnyOf(names) => {
                    let mut ways = Vec::new();
                    for (at, need) in names.iter().enumerate() {
                        ways.push(self.need(need, &format!("{place}.any_of[{at}]"), name)?);
                    }
                    Formula::all(modes, ways.iter()).map_err(|_| self.too_many(&place))?
                }
            });
        }
        let formula = Formula::any(modes, parts.iter()).map_err(|TooManyTerms| self.too_many(&place))?;
        if formula.implicants.is_empty() {
            let reason = format!("`{name}` depends on nothing that can fail");
            let help = "name the components and signals that it needs, or delete it";
            return Err(self.file.error(place, reason, help));
        }
        Ok(formula)
    }

    fn too_many(&self, place: &str) -> DiagnosisError {
        let reason = format!("its redundancy has more than {TERMS_MAX} combinations of failures");
        self.file.error(place, reason, "describe units that are replaced together as one component")
    }

    /// Returns the formula of one need of `whose`.
    fn need(&mut self, need: &str, place: &str, whose: &str) -> ModelResult<Formula> {
        match self.names.get(need) {
            Some(Named::Signal(signal)) => self.signal(*signal),
            Some(Named::Component(component)) => {
                let modes = self.components.get(*component).map_or(&[][..], |component| &component.modes);
                let reaches = |mode: &&usize| {
                    let affects = self.affects.get(**mode).copied().flatten();
                    affects.is_none_or(|names| names.iter().any(|name| name == whose))
                };
                let modes: Vec<usize> = modes.iter().filter(reaches).copied().collect();
                if modes.is_empty() {
                    let reason = format!("no failure mode of `{need}` affects `{whose}`");
                    let help = "delete the need, or add the name to `affects` of a failure mode";
                    return Err(self.file.error(place, reason, help));
                }
                Ok(Formula::one_of(self.modes.len(), &modes))
            }
            Some(Named::Test(_)) => {
                let reason = format!("`{need}` is a test");
                Err(self.file.error(place, reason, "name the components and signals that the test needs"))
            }
            None => {
                let reason = format!("`{need}` is not a component or signal");
                let known = self.names.iter().filter(|(_, named)| !matches!(named, Named::Test(_)));
                Err(self.file.error(place, reason, nearest(need, known.map(|(name, _)| *name))))
            }
        }
    }

    /// Returns the names of the signals that no test depends on, directly or through others.
    fn unused_signals(&self) -> Vec<String> {
        let mut used = Bits::new(self.raw.signals.len());
        let mut open: Vec<&RawNeed> = self.raw.tests.iter().flat_map(|test| &test.needs).collect();
        while let Some(need) = open.pop() {
            for name in names_of(std::slice::from_ref(need)) {
                if let Some(Named::Signal(signal)) = self.names.get(name.as_str())
                    && !used.contains(*signal)
                {
                    used.insert(*signal);
                    open.extend(self.raw.signals.get(*signal).iter().flat_map(|signal| &signal.needs));
                }
            }
        }
        let unused = self.raw.signals.iter().enumerate().filter(|(index, _)| !used.contains(*index));
        unused.map(|(_, signal)| signal.name.clone()).collect()
    }
}

fn names_of(needs: &[RawNeed]) -> impl Iterator<Item = &String> {
    needs.iter().flat_map(|need| match need {
        RawNeed::One(name) => std::slice::from_ref(name).iter(),
        RawNeed::AnyOf(names) => names.iter(),
    })
}

fn place_of(named: Named, field: &str) -> String {
    match named {
        Named::Component(index) => format!("components[{index}].{field}"),
        Named::Signal(index) => format!("signals[{index}].{field}"),
        Named::Test(index) => format!("tests[{index}].{field}"),
    }
}
