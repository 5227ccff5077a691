//! The testability report.

use super::{mode_names, percent, test_names};
use crate::bits::Bits;
use crate::model::Model;
use crate::testability::Testability;
use serde_json::{Value, json};
use std::fmt::Write;

/// Tests up to which the D-matrix is printed as text.
const COLUMNS_MAX: usize = 80;

impl Testability {
    /// Returns the report as text, with one figure on each line.
    pub fn text(&self, model: &Model) -> String {
        let mut text = format!(
            "{}: {} components, {} failure modes, {} tests\n\n",
            model.name,
            model.components.len(),
            model.modes.len(),
            model.tests.len()
        );
        self.matrix(model, &mut text);
        for (name, value) in self.figures(model) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name:<42} {value}");
        }
        text
    }

    fn matrix(&self, model: &Model, text: &mut String) {
        if model.tests.len() > COLUMNS_MAX {
            let _ = writeln!(text, "D-matrix: too wide to print; `--json` prints it\n");
            return;
        }
        let width = model.modes.iter().map(|mode| mode.name.len()).max().unwrap_or(0);
        let _ = writeln!(
            text,
            "D-matrix (columns: tests in the order of the file; 1: the failure alone makes the test fail)"
        );
        for (row, mode) in self.rows.iter().zip(&model.modes) {
            let cells: String = (0..model.tests.len()).map(|test| if row.contains(test) { '1' } else { '.' }).collect();
            let _ = writeln!(text, "  {:<width$}  {cells}  {:e}/h", mode.name, mode.probability_per_hour);
        }
        text.push('\n');
    }

    fn figures(&self, model: &Model) -> Vec<(String, String)> {
        let modes = |modes: &[usize]| mode_names(model, modes.iter().copied());
        let groups = |groups: &[Vec<usize>], names: &dyn Fn(&[usize]) -> String| {
            let groups: Vec<String> = groups.iter().map(|group| format!("{{{}}}", names(group))).collect();
            if groups.is_empty() { "-".to_string() } else { groups.join(" ") }
        };
        let tests = |tests: &[usize]| test_names(model, tests.iter().copied());
        let count = format!("({}/{})", self.detected.len(), self.rows.len());
        let mut figures = vec![
            ("failures detected".to_string(), format!("{} {count}", percent(self.detection))),
            ("  weighted by probability".to_string(), format!("{:.2} %", 100.0 * self.detection_weighted)),
        ];
        for (index, (share, by_component)) in self.isolation.iter().zip(self.isolation_components).enumerate() {
            let value = format!("{} of the detected; components {}", percent(*share), percent(by_component));
            figures.push((format!("isolated to {} or fewer", index + 1), value));
        }
        let pair = |(hider, hidden): &(usize, usize)| {
            format!("{} hides {}", model.mode_name(*hider), model.mode_name(*hidden))
        };
        let hidden: Vec<String> = self.hidden.iter().map(pair).collect();
        let masks: Vec<String> = self
            .masks
            .iter()
            .map(|mask| {
                let (one, other) = (model.mode_name(mask.pair.0), model.mode_name(mask.pair.1));
                format!("{one} + {other} = {}", model.mode_name(mask.looks_like))
            })
            .collect();
        let unless_none = |items: &[String]| if items.is_empty() { "-".to_string() } else { items.join("; ") };
        let smallest = match self.test_set.is_smallest {
            true => "smallest set of tests as good as all",
            false => "a small set of tests as good as all",
        };
        let needed = Bits::of(model.tests.len(), self.test_set.tests.iter().copied());
        let beyond = (0..model.tests.len()).filter(|test| !needed.contains(*test));
        figures.extend([
            ("undetected failures".to_string(), modes(&self.undetected)),
            ("ambiguity groups".to_string(), groups(&self.ambiguity_groups, &modes)),
            ("equivalent tests".to_string(), groups(&self.equal_tests, &tests)),
            ("tests that no single failure makes fail".to_string(), tests(&self.silent_tests)),
            (format!("{smallest} ({})", self.test_set.tests.len()), tests(&self.test_set.tests)),
            ("redundant given them".to_string(), test_names(model, beyond)),
            ("hidden failures".to_string(), unless_none(&hidden)),
            (format!("masking pairs of failures ({})", self.masks_count), unless_none(&masks)),
        ]);
        if !model.unused_signals.is_empty() {
            figures.push(("signals that no test depends on".to_string(), model.unused_signals.join(", ")));
        }
        figures
    }

    /// Returns the report as JSON.
    pub fn json(&self, model: &Model) -> Value {
        let modes = |modes: &[usize]| modes.iter().map(|mode| model.mode_name(*mode)).collect::<Vec<_>>();
        let tests = |tests: &[usize]| tests.iter().map(|test| model.test_name(*test)).collect::<Vec<_>>();
        let row = |(row, mode): (&Bits, &crate::model::FailureMode)| {
            let fails: Vec<usize> = row.iter().collect();
            json!({
                "failure_mode": mode.name,
                "probability_per_hour": mode.probability_per_hour,
                "fails": tests(&fails),
            })
        };
        let masks = self.masks.iter().map(|mask| {
            json!({ "pair": modes(&[mask.pair.0, mask.pair.1]), "looks_like": model.mode_name(mask.looks_like) })
        });
        json!({
            "model": model.name,
            "components": model.components.len(),
            "failure_modes": model.modes.len(),
            "tests": model.tests.len(),
            "d_matrix": self.rows.iter().zip(&model.modes).map(row).collect::<Vec<_>>(),
            "detection": self.detection,
            "detection_weighted": self.detection_weighted,
            "isolation": self.isolation,
            "isolation_components": self.isolation_components,
            "undetected": modes(&self.undetected),
            "ambiguity_groups": self.ambiguity_groups.iter().map(|group| modes(group)).collect::<Vec<_>>(),
            "equal_tests": self.equal_tests.iter().map(|group| tests(group)).collect::<Vec<_>>(),
            "silent_tests": tests(&self.silent_tests),
            "test_set": { "tests": tests(&self.test_set.tests), "is_smallest": self.test_set.is_smallest },
            "hidden": self.hidden.iter().map(|(hider, hidden)| modes(&[*hider, *hidden])).collect::<Vec<_>>(),
            "masks": masks.collect::<Vec<_>>(),
            "masks_count": self.masks_count,
            "unused_signals": model.unused_signals,
        })
    }
}
