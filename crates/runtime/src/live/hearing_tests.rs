//! Tests of lines and connections: nothing of a line that is refused is an input, and silent connections keep no operator out.

use super::*;
use std::time::Instant;

fn sources() -> (LiveSources, LineReader) {
    let read_value = |text: &str| match text.strip_prefix('(').and_then(|text| text.strip_suffix(')')) {
        Some(words) => Ok(Value::list(words.split(' ').map(Value::symbol))),
        None => Err(format!("not a form: {} characters", text.len())),
    };
    (LiveSources::new(|| ()), LineReader { open: OpenQuestions::default(), read_value, note: |_| () })
}

/// Returns the inputs that are taken, as text, without reports about sources.
fn taken(sources: &LiveSources) -> Vec<String> {
    let events = sources.take().into_iter().filter_map(|input| match input {
        LiveInput::Event(_, EventKind::Occurrence(form)) => Some(form.to_string()),
        _ => None,
    });
    events.filter(|form| !form.starts_with("(live-source ")).collect()
}

#[test]
fn the_rest_of_a_line_that_is_too_long_is_not_an_input() {
    let (sources, reader) = sources();
    let source = sources.admit(SourceClass::Operator).unwrap();
    for filling in ["x", " ", "#", "\u{e9}"] {
        let long = filling.repeat(INPUT_LINE_BYTES_MAX + 1);
        hear_lines(format!("(first)\n{long}(abort mission)\n(last)\n").as_bytes(), &source, &reader);
        assert_eq!(taken(&sources), ["(first)", "(last)"], "{filling:?}");
    }
    let longest = format!("(a {}", "b".repeat(INPUT_LINE_BYTES_MAX - 4));
    hear_lines(format!("{longest})\n").as_bytes(), &source, &reader);
    assert_eq!(taken(&sources).len(), 1, "a line of the greatest length is an input");
}

#[test]
fn text_that_is_not_utf_8_is_not_an_input() {
    let (sources, reader) = sources();
    let source = sources.admit(SourceClass::Operator).unwrap();
    hear_lines(b"(first)\n(a \xff)\n\xff\xfe\n(last)\n".as_slice(), &source, &reader);
    assert_eq!(taken(&sources), ["(first)", "(last)"]);
}

#[test]
fn a_source_says_only_what_its_class_may_say() {
    let said = |introduction: &str| {
        let (sources, reader) = sources();
        let source = sources.admit(SourceClass::Feed).unwrap();
        reader.open.opened(apex_model::symbol::Symbol::new("pilot"), apex_model::effect::QuestionId(0), "Land?");
        let lines = "{\"acknowledge\": 0}\nyes\nstop\n(go)\n";
        hear_lines(format!("{introduction}\n{lines}").as_bytes(), &source, &reader);
        let mut words: Vec<&str> = Vec::new();
        for input in sources.take() {
            words.push(match input {
                LiveInput::Stop => "stop",
                LiveInput::Event(_, EventKind::CommandAcknowledged(..)) => "acknowledge",
                LiveInput::Event(_, EventKind::OperatorAnswered(..)) => "answer",
                LiveInput::Event(_, EventKind::Occurrence(form)) if form.to_string() == "(go)" => "go",
                _ => continue,
            });
        }
        words.join(" ")
    };
    let class = |word: &str| said(&format!("{{\"source\": \"a\", \"class\": \"{word}\"}}"));
    assert_eq!(class("operator"), "answer stop go");
    assert_eq!(class("safing"), "stop go");
    assert_eq!(class("vehicle"), "acknowledge go");
    assert_eq!(class("feed"), "go");
    assert_eq!(said("# no introduction"), "acknowledge answer stop go");
}

#[test]
fn silent_connections_give_their_place_to_an_operator() {
    let (sources, reader) = sources();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    hear_connections(listener, &sources, &reader);
    let silent: Vec<TcpStream> = (0..CONNECTIONS_MAX + 4).map(|_| TcpStream::connect(address).unwrap()).collect();
    let mut operator = TcpStream::connect(address).unwrap();
    operator.write_all(b"{\"source\": \"tower\", \"class\": \"operator\"}\n(go)\n").unwrap();
    let mut answer = String::new();
    BufReader::new(&operator).read_line(&mut answer).unwrap();
    assert!(answer.contains("tower") && !answer.contains("error"), "{answer}");
    let began = Instant::now();
    let mut heard = Vec::new();
    while !heard.contains(&"(go)".to_string()) {
        assert!(began.elapsed().as_secs() < 20, "{heard:?}");
        std::thread::sleep(Duration::from_millis(1));
        heard.extend(taken(&sources));
    }
    let mut reason = String::new();
    BufReader::new(&silent[0]).read_line(&mut reason).unwrap();
    assert!(reason.contains("96 connections are open"), "{reason}");
}
