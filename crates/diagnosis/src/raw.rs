//! A model file as written, before its checks.

use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use std::fmt;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawModel {
    pub(crate) format: String,
    pub(crate) name: String,
    pub(crate) components: Vec<RawComponent>,
    #[serde(default)]
    pub(crate) signals: Vec<RawSignal>,
    pub(crate) tests: Vec<RawTest>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawComponent {
    pub(crate) name: String,
    pub(crate) title: Option<String>,
    pub(crate) probability_per_hour: Option<f64>,
    #[serde(default)]
    pub(crate) intermittent: bool,
    pub(crate) modes: Option<Vec<RawMode>>,
    pub(crate) response: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawMode {
    pub(crate) name: String,
    pub(crate) title: Option<String>,
    pub(crate) probability_per_hour: f64,
    pub(crate) affects: Option<Vec<String>>,
    #[serde(default)]
    pub(crate) intermittent: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawSignal {
    pub(crate) name: String,
    #[serde(rename = "title")]
    pub(crate) _title: Option<String>,
    pub(crate) needs: Vec<RawNeed>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawTest {
    pub(crate) name: String,
    pub(crate) title: Option<String>,
    pub(crate) needs: Vec<RawNeed>,
    pub(crate) monitor: Option<RawMonitor>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawMonitor {
    pub(crate) fails: String,
    pub(crate) passes: String,
}

/// A need of a signal or test: one component or signal, or any one of several.
pub(crate) enum RawNeed {
    One(String),
    AnyOf(Vec<String>),
}

impl<'de> Deserialize<'de> for RawNeed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<RawNeed, D::Error> {
        deserializer.deserialize_any(NeedVisitor)
    }
}

struct NeedVisitor;

impl<'de> Visitor<'de> for NeedVisitor {
    type Value = RawNeed;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a component or signal, or {\"any_of\": [names]}")
    }

    fn visit_str<E>(self, name: &str) -> Result<RawNeed, E> {
        Ok(RawNeed::One(name.to_owned()))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<RawNeed, A::Error> {
        let mut names = None;
        while let Some(key) = access.next_key::<String>()? {
            if key != "any_of" {
                return Err(A::Error::unknown_field(&key, &["any_of"]));
            }
            if names.is_some() {
                return Err(A::Error::duplicate_field("any_of"));
            }
            names = Some(access.next_value()?);
        }
        names.map(RawNeed::AnyOf).ok_or_else(|| A::Error::missing_field("any_of"))
    }
}
