//! Random models, diagnosed by trying all fault sets, from the JSON text alone.

use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A set of failure modes as bits.
pub(crate) type Faults = u32;

/// Outcome of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Said {
    Nothing,
    Pass,
    Fail,
    Both,
}

/// Makes small numbers from bytes; fewer bytes give simpler cases.
pub(crate) struct Choices {
    bytes: std::vec::IntoIter<u8>,
}

impl Choices {
    pub(crate) fn new(bytes: Vec<u8>) -> Choices {
        Choices { bytes: bytes.into_iter() }
    }

    pub(crate) fn below(&mut self, bound: u32) -> u32 {
        let mut number = 0;
        let mut span = 1;
        while span < bound {
            number = number * 256 + u32::from(self.bytes.next().unwrap_or(0));
            span *= 256;
        }
        number % bound
    }
}

/// Returns the text of a model with up to nine failure modes and seven tests.
pub(crate) fn random_model(choices: &mut Choices) -> String {
    let components = 2 + choices.below(5) as usize;
    let signals = choices.below(5) as usize;
    let tests = 1 + choices.below(7) as usize;
    let name =
        |number: usize| if number < components { format!("c{number}") } else { format!("s{}", number - components) };
    let mut needs = |before: usize| -> Vec<Value> {
        let count = 1 + choices.below(3);
        let mut one = || name(choices.below(before as u32) as usize);
        let mut list = Vec::new();
        for _ in 0..count {
            let (first, second) = (one(), one());
            list.push(if first < second { json!({ "any_of": [first, second, one()] }) } else { json!(first) });
        }
        list
    };
    let signal_needs: Vec<Vec<Value>> = (0..signals).map(|signal| needs(components + signal)).collect();
    let test_needs: Vec<Vec<Value>> = (0..tests).map(|_| needs(components + signals)).collect();
    let mut modes_left = 9;
    let component = |number: usize| {
        let mut probability = || f64::from(1 + choices.below(200)) * 1e-4;
        let plain = json!({ "name": name(number), "probability_per_hour": probability() });
        if modes_left < components - number + 2 || choices.below(3) > 0 {
            modes_left -= 1;
            let mut plain = plain;
            plain["intermittent"] = json!(choices.below(6) == 0);
            return plain;
        }
        modes_left -= 2;
        // The general mode ensures that every need has a failure mode; the other mode affects only users that name the component.
        let users = signal_needs.iter().enumerate().map(|(user, needs)| (format!("s{user}"), needs));
        let users = users.chain(test_needs.iter().enumerate().map(|(user, needs)| (format!("t{user}"), needs)));
        let naming =
            |needs: &Vec<Value>| Value::from(needs.clone()).to_string().contains(&format!("\"{}\"", name(number)));
        let users: Vec<String> = users.filter(|(_, needs)| naming(needs)).map(|(user, _)| user).collect();
        let mut partial =
            json!({ "name": "partial", "probability_per_hour": 2e-3, "intermittent": choices.below(6) == 0 });
        if let Some(user) = users.get(choices.below(4) as usize) {
            partial["affects"] = json!([user]);
        }
        json!({ "name": name(number), "modes": [{ "name": "general", "probability_per_hour": 1e-3 }, partial] })
    };
    let list: Vec<Value> = (0..components).map(component).collect();
    let signals: Vec<Value> = signal_needs
        .iter()
        .enumerate()
        .map(|(at, needs)| json!({ "name": format!("s{at}"), "needs": needs }))
        .collect();
    let tests: Vec<Value> =
        test_needs.iter().enumerate().map(|(at, needs)| json!({ "name": format!("t{at}"), "needs": needs })).collect();
    json!({ "format": "apex-diagnosis-1", "name": "random", "components": list, "signals": signals, "tests": tests })
        .to_string()
}

/// A failure mode as read from the text.
pub(crate) struct Mode {
    component: String,
    affects: Option<Vec<String>>,
    is_intermittent: bool,
    pub(crate) probability: f64,
}

/// A model as read from the text.
pub(crate) struct Witness {
    pub(crate) modes: Vec<Mode>,
    components: Vec<String>,
    signals: Vec<(String, Vec<Value>)>,
    pub(crate) tests: Vec<(String, Vec<Value>)>,
}

impl Witness {
    pub(crate) fn read(text: &str) -> Witness {
        let model: Value = serde_json::from_str(text).unwrap();
        let named = |item: &Value| item["name"].as_str().unwrap().to_string();
        let mode = |component: &str, item: &Value| Mode {
            component: component.to_string(),
            affects: item["affects"]
                .as_array()
                .map(|names| names.iter().map(|name| name.as_str().unwrap().to_string()).collect()),
            is_intermittent: item["intermittent"].as_bool().unwrap_or(false),
            probability: item["probability_per_hour"].as_f64().unwrap(),
        };
        let mut modes = Vec::new();
        for component in model["components"].as_array().unwrap() {
            match component["modes"].as_array() {
                Some(list) => modes.extend(list.iter().map(|item| mode(&named(component), item))),
                None => modes.push(mode(&named(component), component)),
            }
        }
        let nodes = |key: &str| -> Vec<(String, Vec<Value>)> {
            let list = model[key].as_array().unwrap();
            list.iter().map(|item| (named(item), item["needs"].as_array().unwrap().clone())).collect()
        };
        let components = model["components"].as_array().unwrap().iter().map(named).collect();
        Witness { modes, components, signals: nodes("signals"), tests: nodes("tests") }
    }

    /// Returns true if the test fails with exactly these faults present.
    pub(crate) fn fails(&self, test: usize, present: Faults) -> bool {
        let (name, needs) = &self.tests[test];
        self.is_lost(name, needs, present)
    }

    fn is_lost(&self, whose: &str, needs: &[Value], present: Faults) -> bool {
        needs.iter().any(|need| match need.as_str() {
            Some(name) => self.is_down(name, whose, present),
            None => need["any_of"]
                .as_array()
                .unwrap()
                .iter()
                .all(|name| self.is_down(name.as_str().unwrap(), whose, present)),
        })
    }

    fn is_down(&self, name: &str, whose: &str, present: Faults) -> bool {
        if let Some((signal, needs)) = self.signals.iter().find(|(signal, _)| signal == name) {
            return self.is_lost(signal, needs, present);
        }
        self.modes.iter().enumerate().any(|(index, mode)| {
            let reaches = mode.affects.as_ref().is_none_or(|names| names.iter().any(|name| name == whose));
            mode.component == name && reaches && present >> index & 1 == 1
        })
    }

    /// Returns the faults without the intermittent ones, which may have been absent when a test passed.
    fn lasting(&self, present: Faults) -> Faults {
        let comes_and_goes = self.modes.iter().enumerate().filter(|(_, mode)| mode.is_intermittent);
        comes_and_goes.fold(present, |present, (index, _)| present & !(1 << index))
    }

    fn explains(&self, present: Faults, said: &[Said]) -> bool {
        said.iter().enumerate().all(|(test, said)| match said {
            Said::Nothing => true,
            Said::Pass => !self.fails(test, self.lasting(present)),
            Said::Fail | Said::Both => self.fails(test, present),
        })
    }

    /// Returns the minimal sets among all fault sets that explain the outcomes.
    pub(crate) fn candidates(&self, said: &[Said]) -> BTreeSet<Faults> {
        let all: Vec<Faults> = (0..1 << self.modes.len()).filter(|present| self.explains(*present, said)).collect();
        let is_minimal = |set: &Faults| !all.iter().any(|other| other != set && other & set == *other);
        all.iter().copied().filter(is_minimal).collect()
    }

    /// Returns the failure modes that alone would have made a passed test fail.
    pub(crate) fn good(&self, said: &[Said]) -> Faults {
        let cleared = |mode: &usize| {
            let alone = self.lasting(1 << mode);
            said.iter().enumerate().any(|(test, said)| *said == Said::Pass && self.fails(test, alone))
        };
        (0..self.modes.len()).filter(cleared).map(|mode| 1 << mode).sum()
    }

    /// Returns the failure modes of each component.
    pub(crate) fn components(&self) -> Vec<Faults> {
        let of = |name: &String| {
            let own = self.modes.iter().enumerate().filter(|(_, mode)| mode.component == *name);
            own.map(|(index, _)| 1 << index).sum()
        };
        self.components.iter().map(of).collect()
    }

    pub(crate) fn odds(&self, set: Faults) -> f64 {
        let present = self.modes.iter().enumerate().filter(|(index, _)| set >> index & 1 == 1);
        present.map(|(_, mode)| mode.probability / (1.0 - mode.probability)).product()
    }
}
