//! `apex-fuzz TARGET FILE..` runs a target on files, to reproduce a finding of the fuzzer. With the feature `libfuzzer` the program is
//! libFuzzer, and the environment variable `APEX_FUZZ_TARGET` names the target.

#![cfg_attr(feature = "libfuzzer", no_main)]

#[cfg(feature = "libfuzzer")]
mod under_libfuzzer {
    use std::sync::LazyLock;

    static RUN: LazyLock<fn(&[u8])> = LazyLock::new(|| {
        let name = std::env::var("APEX_FUZZ_TARGET").unwrap_or_default();
        match apex_fuzz::find(&name) {
            Some(target) => target.run,
            None => {
                eprintln!("error: APEX_FUZZ_TARGET is `{name}`; the targets are {}", names());
                std::process::exit(2)
            }
        }
    });

    fn names() -> String {
        apex_fuzz::TARGETS.iter().map(|target| target.name).collect::<Vec<_>>().join(", ")
    }

    libfuzzer_sys::fuzz_target!(|bytes: &[u8]| RUN(bytes));
}

#[cfg(not(feature = "libfuzzer"))]
fn main() -> std::process::ExitCode {
    use std::process::ExitCode;

    let mut arguments = std::env::args().skip(1);
    let names = || apex_fuzz::TARGETS.iter().map(|target| target.name).collect::<Vec<_>>().join(", ");
    let Some(target) = arguments.next().as_deref().and_then(apex_fuzz::find) else {
        eprintln!("usage: apex-fuzz TARGET FILE..\ntargets: {}", names());
        return ExitCode::from(2);
    };
    for file in arguments {
        match std::fs::read(&file) {
            Ok(bytes) => (target.run)(&bytes),
            Err(error) => {
                eprintln!("error: cannot read {file}: {error}");
                return ExitCode::from(2);
            }
        }
        println!("{file}: no violation");
    }
    ExitCode::SUCCESS
}
