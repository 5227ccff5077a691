//! A small finished flight record and the program behind it, made once per process.

use apex_spec::question::{Recorded, recorded};
use apex_spec::scenario::Scenario;
use std::sync::LazyLock;

/// The program of the sample.
pub(crate) const PROGRAM: &str = r#"
(procedure (index (do-domain))
  (step first (greet pilot) (waitfor (ready pilot)))
  (step second (print "bye") (waitfor ?first))
  (step third (watch-level) (priority 2)))
(procedure (index (greet ?who)) (step say (print ?who)))
(procedure (index (watch-level)) (step wait (print "high") (waitfor (level tank-1 > 3))))
"#;

const INPUTS: &str = concat!(
    "{\"t\": 1, \"event\": \"(ready pilot)\"}\n",
    "{\"t\": 2, \"measurement\": \"(level tank-1)\", \"value\": 2}\n",
    "{\"t\": 3, \"measurement\": \"(level tank-1)\", \"value\": 4}\n"
);

static RECORD: LazyLock<Result<(Vec<u8>, tempfile::TempDir), String>> = LazyLock::new(|| {
    let scenario = Scenario { pdl: PROGRAM.into(), inputs: INPUTS.into(), ..Scenario::default() };
    let Recorded { reader, .. } = &recorded(&scenario)?;
    let bytes = std::fs::read(reader.path()).map_err(|error| error.to_string())?;
    let folder = folder()?;
    std::fs::write(folder.path().join("sample.apex"), &bytes).map_err(|error| error.to_string())?;
    Ok((bytes, folder))
});

/// Returns the bytes of the record.
pub(crate) fn record() -> &'static [u8] {
    match &*RECORD {
        Ok((bytes, _)) => bytes,
        Err(error) => panic!("the sample record cannot be made: {error}"),
    }
}

/// Returns the path of the record.
pub(crate) fn record_path() -> std::path::PathBuf {
    match &*RECORD {
        Ok((_, folder)) => folder.path().join("sample.apex"),
        Err(error) => panic!("the sample record cannot be made: {error}"),
    }
}

/// Makes a folder in memory, if the system supports that, because the fuzzer writes thousands of files.
pub(crate) fn folder() -> Result<tempfile::TempDir, String> {
    let memory = std::path::Path::new("/dev/shm");
    let made = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    made.map_err(|error| error.to_string())
}
