//! Tokens and certificate of `apex serve`: from files, or made for this run where other machines are let in.

use crate::error::{CliError, CliResult, read_text};
use crate::options::ServeOptions;
use apex_runtime::authority::{Actor, ActorRole};
use apex_server::{AccessOptions, AccessToken, TlsIdentity};
use std::net::IpAddr;
use std::path::Path;

/// Returns the access to a server on `address` by the options, and the lines that the user needs to enter.
///
/// # Errors
/// A file cannot be read or is not what it should be.
pub fn access(options: &ServeOptions, address: IpAddr) -> CliResult<(AccessOptions, Vec<String>)> {
    let (mut said, is_open) = (Vec::new(), !address.is_loopback());
    let tokens = match &options.tokens {
        Some(path) => tokens_of(path)?,
        None if is_open => ActorRole::ALL.into_iter().map(|role| made(role, &mut said)).collect::<CliResult<_>>()?,
        None => Vec::new(),
    };
    let tls = match (&options.tls_cert, &options.tls_key) {
        (Some(certificate), Some(key)) => Some(TlsIdentity::read(certificate, key).map_err(unusable)?),
        _ if is_open => Some(made_identity(options, address, &mut said)?),
        _ => None,
    };
    Ok((AccessOptions { tokens, names: options.host_name.clone(), tls }, said))
}

fn tokens_of(path: &Path) -> CliResult<Vec<AccessToken>> {
    let fault = |reason: String| CliError::user(format!("{} is not a file of tokens", path.display())).because(reason);
    let text = read_text(path)?;
    check_secrecy(path)?;
    let tokens = AccessToken::read_all(&text).map_err(|error| fault(error.to_string()))?;
    if tokens.is_empty() {
        return Err(fault("it holds no token".into()).help("write lines `ROLE NAME SECRET`"));
    }
    Ok(tokens)
}

/// Refuses a file of secrets that other users of the machine can read.
#[cfg(unix)]
fn check_secrecy(path: &Path) -> CliResult {
    use std::os::unix::fs::PermissionsExt;
    let mode = std::fs::metadata(path).map_or(0, |metadata| metadata.permissions().mode());
    if mode & 0o077 == 0 {
        return Ok(());
    }
    Err(CliError::user(format!("other users of this machine can read the tokens in {}", path.display()))
        .help(format!("keep them to yourself: chmod 600 {}", path.display())))
}

#[cfg(not(unix))]
fn check_secrecy(_: &Path) -> CliResult {
    Ok(())
}

/// Returns a token of this run, called like its role.
fn made(role: ActorRole, said: &mut Vec<String>) -> CliResult<AccessToken> {
    let generated = AccessToken::generate(Actor { name: role.word().into(), role });
    let (token, secret) = generated.map_err(|error| CliError::failure("no tokens can be made").because(error))?;
    if said.is_empty() {
        said.push("Tokens of this run (`--tokens FILE` has lasting ones):".into());
    }
    said.push(format!("  {:<16}  {secret}", role.word()));
    Ok(token)
}

fn made_identity(options: &ServeOptions, address: IpAddr, said: &mut Vec<String>) -> CliResult<TlsIdentity> {
    let mut names = vec!["localhost".into(), "127.0.0.1".into()];
    names.extend((!address.is_unspecified()).then(|| address.to_string()));
    names.extend(options.host_name.iter().cloned());
    let identity = TlsIdentity::generate(names).map_err(unusable)?;
    said.push("Certificate of this run (`--tls-cert FILE --tls-key FILE` has a lasting one), SHA-256:".into());
    said.push(format!("  {}", identity.fingerprint()));
    Ok(identity)
}

fn unusable(error: apex_server::TlsError) -> CliError {
    CliError::user("connections cannot be encrypted").because(error)
}
