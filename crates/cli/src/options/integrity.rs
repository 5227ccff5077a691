//! Options of `apex verify`, `apex recover` and `apex convert`.

use clap::Args;
use std::path::PathBuf;

/// `apex verify`
#[derive(Args)]
pub struct VerifyOptions {
    /// The flight record.
    pub record: PathBuf,
    /// Require a signature by this key: 64 hexadecimal digits, as `apex verify` prints for a signed record.
    #[arg(long, value_name = "KEY")]
    pub signer: Option<String>,
    /// Print the result as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `apex recover`
#[derive(Args)]
pub struct RecoverOptions {
    /// The flight record; it is not changed.
    pub record: PathBuf,
    /// The new record; default is the old name with `-recovered`.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// `apex convert`
#[derive(Args)]
pub struct ConvertOptions {
    /// The flight record of the preceding format version; it is not changed.
    pub record: PathBuf,
    /// The new record.
    pub out: PathBuf,
}
