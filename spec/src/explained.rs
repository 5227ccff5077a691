//! Compares the text and the data of an explanation. Both are parsed again: every name, instant, cause and place in the data must be at
//! its place in the text, and every task and instant in the text must be in the data.

use apex_model::time::Time;
use serde_json::Value;

/// Maximum number of moments in a text; longer histories omit the middle.
const MOMENTS_MAX: usize = 40;

/// Returns the statements that are in only one form of the answer to `why` or `why-not`. `data` is its JSON.
pub fn disagreements(data: &Value, text: &str) -> Vec<String> {
    let mut told = Vec::new();
    let sections = sections(text);
    let first = sections.first().map(|(_, lines)| lines.join("\n")).unwrap_or_default();
    let task = if data.get("question").and_then(Value::as_str) == Some("why-not") {
        needs(&mut told, &first, &[word(data, "answer")]);
        missing(&mut told, data, &sections);
        targets(&mut told, data, &sections);
        data.get("task").filter(|task| task.is_object())
    } else if data.get("holders").is_some() {
        holders(&mut told, data, &sections);
        None
    } else if data.get("form").is_some() {
        needs(&mut told, &first, &[word(data, "form")]);
        Some(data)
    } else {
        head(&mut told, data, &first);
        history(&mut told, data, &sections);
        Some(data)
    };
    if let Some(task) = task {
        chain(&mut told, task.get("because"), section(&sections, "Why:"));
        waiting(&mut told, task, text, &sections);
    }
    only_in_text(&mut told, data, text);
    told
}

type Section<'t> = (&'t str, Vec<&'t str>);

/// Sections separated by empty lines: a title with a final colon, and the lines below it. The first section has no title.
fn sections(text: &str) -> Vec<Section<'_>> {
    let parts = text.trim_end().split("\n\n").enumerate();
    parts
        .map(|(number, part)| {
            let lines: Vec<&str> = part.lines().collect();
            match lines.split_first() {
                Some((title, rest)) if number > 0 && title.ends_with(':') => (*title, rest.to_vec()),
                _ => ("", lines),
            }
        })
        .collect()
}

fn section<'s, 't>(sections: &'s [Section<'t>], title: &str) -> &'s [&'t str] {
    sections.iter().find(|(known, _)| *known == title).map(|(_, lines)| lines.as_slice()).unwrap_or_default()
}

fn word(data: &Value, member: &str) -> String {
    data.get(member).and_then(Value::as_str).unwrap_or_default().to_string()
}

fn list<'v>(data: &'v Value, member: &str) -> &'v [Value] {
    data.get(member).and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default()
}

/// Returns the instant that a member holds, in human-readable form.
fn instant(data: &Value, member: &str) -> String {
    data.get(member).and_then(Value::as_f64).map(|t| Time::from_seconds(t).to_string()).unwrap_or_default()
}

/// Adds every fact that `line` does not contain.
fn needs(told: &mut Vec<String>, line: &str, facts: &[String]) {
    told.extend(facts.iter().filter(|fact| !line.contains(*fact)).map(|fact| format!("`{fact}` is not in `{line}`")));
}

fn same_count(told: &mut Vec<String>, what: &str, in_data: usize, in_text: usize) {
    if in_data != in_text {
        told.push(format!("{what}: {in_data} in the data, {in_text} lines in the text"));
    }
}

fn head(told: &mut Vec<String>, data: &Value, first: &str) {
    let is =
        format!("{} {} is {} at {}.", word(data, "task"), word(data, "goal"), word(data, "state"), instant(data, "t"));
    let held = list(data, "holds").iter().filter_map(Value::as_str).map(str::to_string);
    let facts: Vec<String> = [is, word(data, "place"), word(data, "method")].into_iter().chain(held).collect();
    needs(told, first, &facts);
}

/// Checks that every link of the chain has one line, in order.
fn chain(told: &mut Vec<String>, link: Option<&Value>, lines: &[&str]) {
    let mut links = Vec::new();
    let mut cuts = 0;
    if let Some(link) = link.filter(|link| link.is_object()) {
        links_of(link, &mut links, &mut cuts);
    }
    let is_link = |line: &&&str| !line.trim().starts_with("(`--depth`") && line.trim() != "..";
    let shown: Vec<&&str> = lines.iter().filter(is_link).collect();
    same_count(told, "links", links.len(), shown.len());
    same_count(told, "links left out", cuts, lines.iter().filter(|line| line.trim() == "..").count());
    for (link, line) in links.into_iter().zip(shown) {
        let begins = format!("{}: {}", instant(link, "t"), word(link, "what"));
        needs(told, line, &[begins, word(link, "because")]);
    }
}

fn links_of<'v>(link: &'v Value, links: &mut Vec<&'v Value>, cuts: &mut usize) {
    links.push(link);
    list(link, "causes").iter().for_each(|cause| links_of(cause, links, cuts));
    *cuts += usize::from(link.get("more").and_then(Value::as_bool) == Some(true));
}

fn history(told: &mut Vec<String>, data: &Value, sections: &[Section<'_>]) {
    let moments = list(data, "history");
    let lines = section(sections, "What happened to it:");
    let is_remark = |line: &&&str| line.trim().starts_with("(and ");
    same_count(told, "moments", moments.len().min(MOMENTS_MAX), lines.iter().filter(|line| !is_remark(line)).count());
    let left_out = moments.len().saturating_sub(MOMENTS_MAX);
    let remark = lines.iter().find(|line| is_remark(line)).copied().unwrap_or_default();
    if left_out > 0 {
        needs(told, remark, &[format!("(and {left_out} more")]);
    }
    let first = lines.iter().take_while(|line| !is_remark(line)).count();
    let shown = moments.iter().take(first).chain(moments.iter().skip(first + left_out));
    for (moment, line) in shown.zip(lines.iter().filter(|line| !is_remark(line))) {
        let at = instant(moment, "t");
        needs(told, line, &[at, word(moment, "what"), word(moment, "because"), word(moment, "place")]);
    }
}

fn waiting(told: &mut Vec<String>, data: &Value, text: &str, sections: &[Section<'_>]) {
    let unmet = list(data, "waiting");
    let lines = section(sections, "What it waits for:");
    same_count(told, "what it waits for", unmet.len(), lines.len());
    unmet.iter().zip(lines).for_each(|(unmet, line)| waits(told, unmet, line));
    let subtasks = list(data, "subtasks");
    let lines = section(sections, "Its subtasks:");
    if !lines.is_empty() {
        same_count(told, "subtasks", subtasks.len(), lines.len());
    }
    for (subtask, line) in subtasks.iter().zip(lines) {
        let is = format!("{} {}: {}", word(subtask, "task"), word(subtask, "goal"), word(subtask, "state"));
        needs(told, line, &[is]);
    }
    if let Some(lost) = data.get("blocked").filter(|lost| lost.is_object()) {
        let by = format!(
            "It lost the conflict over {} to {} {}",
            word(lost, "resource"),
            word(lost, "by"),
            word(lost, "goal")
        );
        needs(told, text, &[by, instant(lost, "since"), word(lost, "strengths")]);
    }
}

fn waits(told: &mut Vec<String>, unmet: &Value, line: &str) {
    let since = instant(unmet, "since");
    let since = if since.is_empty() { since } else { format!(", since {since}") };
    needs(told, line, &[word(unmet, "what"), word(unmet, "now"), since, word(unmet, "place"), word(unmet, "task")]);
}

fn holders(told: &mut Vec<String>, data: &Value, sections: &[Section<'_>]) {
    for (member, title) in [("holders", "Tasks that hold it:"), ("waiting", "Tasks that wait for it:")] {
        let mut lines = section(sections, title).iter();
        for each in list(data, member) {
            let number = |member: &str| each.get(member).and_then(Value::as_f64).unwrap_or_default().to_string();
            let line = lines.next().copied().unwrap_or_default();
            let who = format!("{} {}:", word(each, "task"), word(each, "goal"));
            let cost = format!("priority {}, interrupt cost {}", number("priority"), number("interrupt_cost"));
            needs(told, line, &[who, cost, word(each, "amount")]);
            let below: Vec<&str> = lines.clone().take_while(|line| line.starts_with("    ")).copied().collect();
            lines.by_ref().take(below.len()).for_each(drop);
            let is_now = |line: &&str| line.trim().starts_with("now it waits for");
            let (now, links): (Vec<&str>, Vec<&str>) = below.into_iter().partition(is_now);
            chain(told, each.get("because"), &links);
            same_count(told, "what it waits for", list(each, "waits_for").len(), now.len());
            list(each, "waits_for").iter().zip(now).for_each(|(unmet, line)| waits(told, unmet, line));
        }
        same_count(told, title, 0, lines.count());
    }
}

fn missing(told: &mut Vec<String>, data: &Value, sections: &[Section<'_>]) {
    let lines = section(sections, "Where it would come from:");
    same_count(told, "missing steps", list(data, "missing").len(), lines.len());
    for (missing, line) in list(data, "missing").iter().zip(lines) {
        needs(told, line, &[word(missing, "step"), word(missing, "place"), word(missing, "because")]);
    }
}

fn targets(told: &mut Vec<String>, data: &Value, sections: &[Section<'_>]) {
    let lines = section(sections, "Outcome:");
    same_count(told, "moments of the target", list(data, "target").len(), lines.len());
    for (moment, line) in list(data, "target").iter().zip(lines) {
        needs(told, line, &[instant(moment, "t"), word(moment, "state"), word(moment, "detail")]);
    }
}

/// Adds the tasks and instants that the text names and the data do not contain.
fn only_in_text(told: &mut Vec<String>, data: &Value, text: &str) {
    let mut words = Vec::new();
    facts(data, "", &mut words);
    let known: std::collections::BTreeSet<&str> = words.iter().flat_map(|text| tokens(text)).collect();
    let is_task = |token: &str| token.strip_prefix('T').is_some_and(|rest| rest.parse::<u64>().is_ok());
    let is_time = |token: &str| token.strip_suffix('s').is_some_and(|rest| rest.parse::<f64>().is_ok());
    let strange = tokens(text).into_iter().filter(|token| (is_task(token) || is_time(token)) && !known.contains(token));
    told.extend(strange.map(|token| format!("`{token}` is in the text alone")));
}

fn tokens(text: &str) -> Vec<&str> {
    let parts = text.split(|each: char| each.is_whitespace() || "()[]{},;:/`\"'#<>=".contains(each));
    parts.map(|part| part.trim_end_matches('.')).filter(|part| !part.is_empty()).collect()
}

fn facts(data: &Value, member: &str, words: &mut Vec<String>) {
    match data {
        Value::String(text) => words.push(text.clone()),
        Value::Number(number) if matches!(member, "t" | "since" | "until") => {
            words.extend(number.as_f64().map(|t| Time::from_seconds(t).to_string()));
        }
        Value::Array(parts) => parts.iter().for_each(|part| facts(part, member, words)),
        Value::Object(members) => members.iter().for_each(|(name, part)| facts(part, name, words)),
        _ => {}
    }
}
