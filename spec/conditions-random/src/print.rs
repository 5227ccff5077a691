//! Conversion of a random question (a condition with its samples) to the PDL of a specification page.

use apex_definition::condition::{
    Allen, Condition, Constraint, Cyclic, Edge, Episode, Estimation, Kind, Measurement, Relation, Span, Statistic,
    Term, Test, Time, Trend, Variable,
};
use apex_definition::{Question, Value, What};
use std::fmt::Write;

/// Returns the declarations of the question's state variables.
pub fn declarations(question: &Question) -> String {
    let late = question.lateness.iter();
    late.map(|(attribute, late)| format!("(state-variable ({attribute} ?o) :lateness {})\n", span(*late))).collect()
}

/// Returns a condition as PDL.
pub fn condition(condition: &Condition) -> String {
    let tag = condition.tag.as_ref().map(|tag| format!("{tag} ")).unwrap_or_default();
    match &condition.kind {
        Kind::Measurement(measurement) => format!("(:measurement {tag}{})", self::measurement(measurement)),
        Kind::Episode(episode) => format!("(:episode {tag}{})", self::episode(episode)),
        Kind::Cyclic(cyclic) => format!("(:cyclic {tag}{})", self::cyclic(cyclic)),
        Kind::And(parts, tests) => format!("(:and {tag}{}{})", joined(parts), self::tests(tests)),
        Kind::Or(parts) => format!("(:or {tag}{})", conditions(parts)),
        Kind::Not(part) => format!("(:not {})", self::condition(part)),
        Kind::Absent(part, length) => format!("(:absent {} :for {})", self::condition(part), span(*length)),
        Kind::InOrder(parts, tests) => format!("(:in-order {tag}{}{})", joined(parts), self::tests(tests)),
        Kind::Allen { relation, parts, tolerance, tests } => {
            let near = if *tolerance == 0 { String::new() } else { format!(" :tolerance {}", span(*tolerance)) };
            format!("(:{} {tag}{}{near}{})", allen(*relation), joined(parts), self::tests(tests))
        }
        Kind::Delay(least, most) => {
            format!("(:delay {}{})", span(*least), most.map(|most| format!(" {}", span(most))).unwrap_or_default())
        }
        Kind::Timestamp(from, to) => {
            format!("(:timestamp {}{})", instant(*from), to.map(|to| format!(" {}", instant(to))).unwrap_or_default())
        }
        Kind::Event(pattern, when) => {
            let when = optional(":timing", times(when).map(|when| format!("(:start {when})")));
            format!("(:atomic-episode {tag}({}){when})", pattern.iter().map(term).collect::<Vec<_>>().join(" "))
        }
        Kind::Function(attribute, object, relation, number) => {
            format!("(:function ({} (current-value '{attribute} '{object}) {number}))", word(*relation))
        }
        Kind::TaskEnded(task) => format!("(end ?{task})"),
        Kind::TaskState(task, state) => format!("(state ?{task} = {state})"),
    }
}

fn conditions(parts: &[Condition]) -> String {
    parts.iter().map(condition).collect::<Vec<_>>().join(" ")
}

/// Returns the parts of a conjunction. A variable that an earlier part certainly binds is written `<?x>` in later parts; this
/// means the same as `?x`.
fn joined(parts: &[Condition]) -> String {
    let mut bound: Vec<&str> = Vec::new();
    let mut texts = Vec::new();
    for part in parts {
        let mut text = condition(part);
        for name in &bound {
            let (open, marked) = (format!("?{name}"), format!("<?{name}>"));
            text = text.replace(&marked, &open).replace(&open, &marked);
        }
        let leaf = matches!(part.kind, Kind::Measurement(_) | Kind::Event(..) | Kind::Episode(_) | Kind::Cyclic(_));
        let binds = |name: &&&str| leaf && !bound.contains(*name) && text.contains(&format!("?{name}"));
        let new: Vec<&str> = ["o", "v"].iter().filter(binds).copied().collect();
        bound.extend(new);
        texts.push(text);
    }
    texts.join(" ")
}

fn measurement(measurement: &Measurement) -> String {
    let estimation = measurement.estimation.as_ref().map(|estimation| match estimation {
        Estimation::Persist(None) => ":persist".to_string(),
        Estimation::Persist(Some(timeout)) => format!("(:persist :with-timeout {})", span(*timeout)),
        Estimation::Regression(options) => {
            let mut text = "(:linear-regression".to_string();
            let _ = options.points_min.map(|number| write!(text, " :minimum-points {number}"));
            let _ = options.error_max.map(|number| write!(text, " :maximum-error {number}"));
            let _ = options.difference_max.map(|number| write!(text, " :maximum-difference {number}"));
            let _ = options.gap_max.map(|gap| write!(text, " :minimum-frequency {}", span(gap)));
            let _ = options.start.map(|start| write!(text, " :start {}", instant(start)));
            let _ = options.end.map(|end| write!(text, " :end {}", instant(end)));
            text + ")"
        }
    });
    format!(
        "{}{}{}{}{}",
        variable(&measurement.variable),
        optional(":value", constraints(&measurement.value)),
        optional(":object", constraints(&measurement.variable.tests)),
        optional(":timestamp", times(&measurement.timestamp)),
        optional(":estimation", estimation)
    )
}

fn cyclic(cyclic: &Cyclic) -> String {
    let tests = |tests: Vec<String>| (!tests.is_empty()).then(|| tests.join(" "));
    let period = cyclic.period.iter().map(|(relation, length)| format!("({} {})", word(*relation), span(*length)));
    let amplitude = cyclic.amplitude.iter().map(|(relation, number)| format!("({} {number})", word(*relation)));
    let cycles = cyclic.cycles.iter().map(|(relation, number)| format!("({} {number})", word(*relation)));
    format!(
        "{}{}{}{}{}",
        variable(&cyclic.variable),
        optional(":period", tests(period.collect())),
        optional(":amplitude", tests(amplitude.collect())),
        optional(":cycles", tests(cycles.collect())),
        optional(":hysteresis", cyclic.hysteresis.map(|number| number.to_string()))
    )
}

fn episode(episode: &Episode) -> String {
    let gap = episode.gap.map_or("(:no-constraints)".to_string(), |gap| format!("(:max-gap {})", span(gap)));
    let group = |name: &str, body: Option<String>| body.map(|body| format!(" (:{name} {body})")).unwrap_or_default();
    let spans: Vec<String> =
        episode.duration.iter().map(|(relation, length)| format!("({} {})", word(*relation), span(*length))).collect();
    let timing = group("start", times(&episode.start))
        + &group("end", times(&episode.end))
        + &group("duration", (!spans.is_empty()).then(|| spans.join(" ")));
    let stats: Vec<String> = episode
        .stats
        .iter()
        .map(|(name, relation, number)| format!("({} ({} {number}))", statistic(*name), word(*relation)))
        .collect();
    let trend: Vec<String> = episode
        .trend
        .iter()
        .map(|(trend, relation, number)| match trend {
            Trend::Rate => format!("(:rate ({} ({number} P1S)))", word(*relation)),
            Trend::Step => format!("(:step ({} {number}))", word(*relation)),
            Trend::Frequency => format!("(:frequency ({} {number}Hz))", word(*relation)),
        })
        .collect();
    format!(
        "{}{} :quality {gap}{}{}{}{}{}{}{}",
        variable(&episode.variable),
        if episode.any { " :any" } else { "" },
        optional(":value", constraints(&episode.value)),
        optional(":first-value", constraints(&episode.first_value)),
        optional(":last-value", constraints(&episode.last_value)),
        optional(":object", constraints(&episode.variable.tests)),
        optional(":timing", (!timing.is_empty()).then(|| timing.trim().to_string())),
        optional(":stats", (!stats.is_empty()).then(|| stats.join(" "))),
        optional(":trend", (!trend.is_empty()).then(|| trend.join(" ")))
    )
}

fn optional(name: &str, body: Option<String>) -> String {
    body.map(|body| format!(" {name} {body}")).unwrap_or_default()
}

fn variable(variable: &Variable) -> String {
    format!("({} {})", variable.attribute, term(&variable.object))
}

fn constraints(constraints: &[Constraint]) -> Option<String> {
    let texts: Vec<String> = constraints.iter().map(constraint).collect();
    (!texts.is_empty()).then(|| texts.join(" "))
}

fn constraint(constraint: &Constraint) -> String {
    match constraint {
        Constraint::Compare(Relation::Equal, right, Some(tolerance)) => format!("(= {} +/- {tolerance})", value(right)),
        Constraint::Compare(relation, right @ Value::Symbol(_), _) => {
            format!("({} '{})", word(*relation), value(right))
        }
        Constraint::Compare(relation, right, _) => format!("({} {})", word(*relation), value(right)),
        Constraint::Bind(name) => format!("(= ?{name})"),
        Constraint::Range(Some(least), Some(most)) => format!("(:range {least} {most})"),
        Constraint::Range(Some(least), None) => format!("(:min {least})"),
        Constraint::Range(None, most) => format!("(:max {})", most.unwrap_or_default()),
        Constraint::Odd => "(oddp)".into(),
    }
}

fn times(tests: &[(Relation, Time)]) -> Option<String> {
    let texts: Vec<String> =
        tests.iter().map(|(relation, at)| format!("({} {})", word(*relation), instant(*at))).collect();
    (!texts.is_empty()).then(|| texts.join(" "))
}

fn tests(tests: &[Test]) -> String {
    let texts: Vec<String> = tests
        .iter()
        .map(|test| match test {
            Test::Apart(relation, left, right, length) => {
                format!("({} (- {} {}) {})", word(*relation), edge(left), edge(right), span(*length))
            }
            Test::Number(relation, name, number) => format!("({} ?{name} {number})", word(*relation)),
        })
        .collect();
    optional(":constraint", (!texts.is_empty()).then(|| texts.join(" ")))
}

fn edge((edge, tag): &(Edge, String)) -> String {
    match edge {
        Edge::Start => format!("(start-of ?{tag})"),
        Edge::End => format!("(end-of ?{tag})"),
    }
}

/// Returns an instant as PDL.
fn instant(at: Time) -> String {
    format!("(+ (- +now+ +met+) {})", span(at))
}

fn term(term: &Term) -> String {
    match term {
        Term::Is(is) => value(is),
        Term::Variable(name) => format!("?{name}"),
        Term::Any => "?".into(),
    }
}

/// Returns a value as PDL: `2.5`, `up`, `"text"`.
pub fn value(value: &Value) -> String {
    match value {
        Value::Number(number) => number.to_string(),
        Value::Symbol(name) => name.clone(),
        Value::Text(text) => format!("\"{text}\""),
    }
}

/// Returns a duration as PDL: `2500ms`, or nanoseconds if it is not a whole number of milliseconds.
pub fn span(length: Span) -> String {
    if length % 1_000_000 == 0 { format!("{}ms", length / 1_000_000) } else { format!("{length}ns") }
}

fn word(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::Different => "/=",
        Relation::Less => "<",
        Relation::LessOrEqual => "<=",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => ">=",
    }
}

fn statistic(statistic: Statistic) -> &'static str {
    match statistic {
        Statistic::Count => ":count",
        Statistic::Mean => ":mean",
        Statistic::Sum => ":sum",
        Statistic::Min => ":min",
        Statistic::Max => ":max",
        Statistic::Median => ":median",
        Statistic::Difference => ":difference",
        Statistic::Variance => ":variance",
        Statistic::StandardDeviation => ":stddev",
        Statistic::TimeWeightedMean => ":mean :time-weighted",
        Statistic::TimeWeightedVariance => ":variance :time-weighted",
        Statistic::TimeWeightedDeviation => ":stddev :time-weighted",
    }
}

fn allen(relation: Allen) -> &'static str {
    match relation {
        Allen::Before => "before",
        Allen::After => "after",
        Allen::Meets => "meets",
        Allen::MetBy => "met-by",
        Allen::Overlaps => "overlaps",
        Allen::OverlappedBy => "overlapped-by",
        Allen::Starts => "starts",
        Allen::StartedBy => "started-by",
        Allen::Finishes => "finishes",
        Allen::FinishedBy => "finished-by",
        Allen::During => "during",
        Allen::Contains => "contains",
        Allen::Cotemporal => "cotemporal",
    }
}

/// Returns the arrivals of samples as input lines of a page; late samples state both instants.
pub fn inputs(question: &Question) -> String {
    let mut text = String::new();
    for arrival in &question.arrivals {
        let late = if arrival.at < arrival.arrives {
            format!(", \"came\": {}", seconds(arrival.arrives))
        } else {
            String::new()
        };
        let at = seconds(arrival.at);
        let _ = match &arrival.what {
            What::Sample(attribute, object, sample) => {
                let shown = match sample {
                    Some(Value::Number(number)) if number.is_finite() => number.to_string(),
                    Some(Value::Number(_)) => "{\"pdl\": \"1e999\"}".into(),
                    Some(other) => format!("{{\"pdl\": \"{}\"}}", value(other)),
                    None => "\"NaN\"".into(),
                };
                writeln!(text, "{{\"t\": {at}, \"measurement\": \"({attribute} {object})\", \"value\": {shown}{late}}}")
            }
            What::Message(words) => {
                let words = words.iter().map(value).collect::<Vec<_>>().join(" ");
                writeln!(text, "{{\"t\": {at}, \"event\": \"({words})\"{late}}}")
            }
            What::Moved(..) => Ok(()),
        };
    }
    text
}

fn seconds(at: i64) -> f64 {
    at as f64 / 1e9
}
