//! Planning problems as JSON: an object with the kind of problem and the version of its interpretation.
//!
//! In version 2 a target's windows include both ends; in version 1, the default, they exclude the end. Times are kept to a microsecond,
//! so a window of version 1 is read as one that ends a microsecond earlier.

use apex_model::problem::{FOREVER_S, Problem, SingleVisitProblem, SurveillanceProblem};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use std::fmt;

/// The version that is written.
const VERSION: f64 = 2.0;
/// The version of problems that state none.
const FIRST: f64 = 1.0;
/// Members of the object.
const MEMBERS: &[&str] = &["version", "Surveillance", "SingleVisit"];
/// Time between the last instant of a half-open window and its end: plans and benchmarks have microseconds.
const INSTANT_S: f64 = 1e-6;

/// Reads a problem in either version.
///
/// # Errors
/// The text is not JSON, or not a problem; the error has line and column.
pub(super) fn read(text: &str) -> Result<Problem, serde_json::Error> {
    let File { version, mut problem } = serde_json::from_str(text)?;
    if let (Problem::SingleVisit(problem), true) = (&mut problem, version == FIRST) {
        let windows = problem.targets.iter_mut().flat_map(|target| &mut target.windows);
        windows.filter(|window| window.until_s < FOREVER_S).for_each(|window| window.until_s -= INSTANT_S);
    }
    Ok(problem)
}

/// Returns the problem as JSON of the present version.
pub fn write(problem: &Problem) -> String {
    match problem {
        Problem::Surveillance(problem) => serde_json::json!({ "version": 2, "Surveillance": problem }),
        Problem::SingleVisit(problem) => serde_json::json!({ "version": 2, "SingleVisit": problem }),
    }
    .to_string()
}

struct File {
    version: f64,
    problem: Problem,
}

impl<'de> Deserialize<'de> for File {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<File, D::Error> {
        deserializer.deserialize_map(FileVisitor)
    }
}

struct FileVisitor;

impl<'de> Visitor<'de> for FileVisitor {
    type Value = File;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with the member `Surveillance` or `SingleVisit`, and `version`")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<File, A::Error> {
        let (mut version, mut problem) = (None, None);
        while let Some(member) = map.next_key::<String>()? {
            let is_problem = member != "version";
            if (is_problem && problem.is_some()) || (!is_problem && version.is_some()) {
                return Err(Error::custom(format!(
                    "a second problem or version, `{member}`; a file holds one of each"
                )));
            }
            match member.as_str() {
                "version" => version = Some(known(map.next_value()?)?),
                "Surveillance" => problem = Some(Problem::Surveillance(map.next_value::<SurveillanceProblem>()?)),
                "SingleVisit" => problem = Some(Problem::SingleVisit(map.next_value::<SingleVisitProblem>()?)),
                other => return Err(Error::unknown_field(other, MEMBERS)),
            }
        }
        let problem = problem.ok_or_else(|| Error::custom("expected the member `Surveillance` or `SingleVisit`"))?;
        Ok(File { version: version.unwrap_or(FIRST), problem })
    }
}

/// Refuses an unknown version.
fn known<E: Error>(version: f64) -> Result<f64, E> {
    match version == FIRST || version == VERSION {
        true => Ok(version),
        false => Err(E::custom(format!("version {version} is not known; expected 2, or 1 with half-open windows"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::{SingleVisitTarget, TimeWindow};

    fn until_s(problem: &Problem) -> f64 {
        let Problem::SingleVisit(problem) = problem else { return f64::NAN };
        problem.targets[0].windows[0].until_s
    }

    #[test]
    fn windows_end_as_their_version_says() {
        let window = TimeWindow { from_s: 5.0, until_s: 9.0 };
        let target = SingleVisitTarget { windows: vec![window], ..SingleVisitTarget::default() };
        let problem =
            Problem::SingleVisit(SingleVisitProblem { targets: vec![target], ..SingleVisitProblem::default() });
        let written = write(&problem);
        assert_eq!(read(&written).unwrap(), problem);
        let stated = |version: &str| until_s(&read(&written.replace("\"version\":2", version)).unwrap());
        assert_eq!((stated("\"version\":2.0"), stated("\"version\":1")), (9.0, 9.0 - 1e-6));
        let first = serde_json::to_string(&problem).unwrap();
        assert_eq!(until_s(&read(&first).unwrap()), 9.0 - 1e-6, "no version is the first");
        let why = |text: &str| read(text).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(why(&written.replace("\"version\":2", "\"version\":3")).contains("version 3 is not known"));
        assert!(why("{}").contains("expected the member `Surveillance` or `SingleVisit`"));
        assert!(why(r#"{"version": 2, "Tour": {}}"#).contains("unknown field `Tour`"));
        assert!(why(r#"{"version": 2, "version": 2}"#).contains("a second problem or version"));
        assert!(why("[1]").contains("an object with the member"));
    }
}
