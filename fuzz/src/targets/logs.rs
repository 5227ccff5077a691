//! Logs: all formats that `apex monitor` reads. The first byte of the input chooses the format.
//!
//! Properties: a message belongs to a topic that the reader lists; there are at most as many messages as bytes.

use crate::planted;
use apex_logs::{Format, Message, open};

const FORMATS: &[Format] =
    &[Format::ULog, Format::DataFlashBinary, Format::DataFlashText, Format::TelemetryLog, Format::Mcap, Format::Csv];
const EXTENSIONS: &[&str] = &["ulg", "bin", "log", "tlog", "mcap", "csv"];

/// Runs the target.
pub(crate) fn run(bytes: &[u8]) {
    let Some((choice, body)) = bytes.split_first() else { return };
    if body.len() > 65_536 {
        return;
    }
    let number = usize::from(*choice) % FORMATS.len();
    let (Some(format), Some(extension)) = (FORMATS.get(number), EXTENSIONS.get(number)) else { return };
    let _ = open(body, extension);
    let mut reader = format.reader(body, None);
    let (mut message, mut count, mut newest) = (Message::default(), 0_usize, None);
    while let Ok(true) = reader.next(&mut message) {
        count += 1;
        assert!(message.topic < reader.topics().len(), "a message without a topic");
        assert!(count <= body.len(), "more messages than bytes");
        if planted::ARE_IN {
            // The bug: messages of a log are taken to be in order of time.
            assert!(newest.is_none_or(|newest| newest <= message.at), "a message is older than the one before it");
        }
        newest = Some(message.at);
    }
    let _ = reader.damages();
}
