//! Tokens and certificate of a server: from files, or made for this run if other machines have access.

use crate::access::AccessToken;
use crate::listening::{TlsError, TlsIdentity};
use crate::serve::AccessOptions;
use apex_mission::error::{MissionError, MissionResult};
use apex_mission::files::read_text;
use apex_runtime::authority::{Actor, ActorRole};
use std::net::IpAddr;
use std::path::Path;

/// Files and names from which the access to a server is prepared.
pub struct AccessFiles<'a> {
    /// The file of tokens; `None` makes one for each role if other machines have access.
    pub tokens: Option<&'a Path>,
    /// The files of the certificate and of its key; `None` makes both if other machines have access.
    pub certificate: Option<(&'a Path, &'a Path)>,
    /// Names of hosts by which the server is reached.
    pub host_names: &'a [String],
}

impl AccessFiles<'_> {
    /// Returns the access to a server on `address`, and the lines that the user needs to enter.
    ///
    /// # Errors
    /// If a file cannot be read or has invalid contents.
    pub fn prepare(&self, address: IpAddr) -> MissionResult<(AccessOptions, Vec<String>)> {
        let (mut said, is_open) = (Vec::new(), !address.is_loopback());
        let tokens = match self.tokens {
            Some(path) => tokens_of(path)?,
            None if is_open => {
                ActorRole::ALL.into_iter().map(|role| made(role, &mut said)).collect::<MissionResult<_>>()?
            }
            None => Vec::new(),
        };
        let tls = match self.certificate {
            Some((certificate, key)) => Some(TlsIdentity::read(certificate, key).map_err(unusable)?),
            None if is_open => Some(self.made_identity(address, &mut said)?),
            None => None,
        };
        Ok((AccessOptions { tokens, names: self.host_names.to_vec(), tls }, said))
    }

    fn made_identity(&self, address: IpAddr, said: &mut Vec<String>) -> MissionResult<TlsIdentity> {
        let mut names = vec!["localhost".into(), "127.0.0.1".into()];
        names.extend((!address.is_unspecified()).then(|| address.to_string()));
        names.extend(self.host_names.iter().cloned());
        let identity = TlsIdentity::generate(names).map_err(unusable)?;
        said.push(
            "Certificate, valid for this run only (use `--tls-cert FILE --tls-key FILE` for a permanent one), SHA-256:"
                .into(),
        );
        said.push(format!("  {}", identity.fingerprint()));
        Ok(identity)
    }
}

fn tokens_of(path: &Path) -> MissionResult<Vec<AccessToken>> {
    let fault =
        |reason: String| MissionError::setting(format!("{} is not a file of tokens", path.display())).because(reason);
    let text = read_text(path)?;
    check_secrecy(path)?;
    let tokens = AccessToken::read_all(&text).map_err(|error| fault(error.to_string()))?;
    if tokens.is_empty() {
        return Err(fault("it holds no token".into()).help("write lines `ROLE NAME SECRET`"));
    }
    Ok(tokens)
}

/// Refuses a file of tokens that other users of the machine can read.
#[cfg(unix)]
fn check_secrecy(path: &Path) -> MissionResult {
    use std::os::unix::fs::PermissionsExt;
    let mode = std::fs::metadata(path).map_or(0, |metadata| metadata.permissions().mode());
    if mode & 0o077 == 0 {
        return Ok(());
    }
    Err(MissionError::setting(format!("other users of this machine can read the tokens in {}", path.display()))
        .help(format!("keep them to yourself: chmod 600 {}", path.display())))
}

#[cfg(not(unix))]
fn check_secrecy(_: &Path) -> MissionResult {
    Ok(())
}

/// Returns a token for this run, named after its role, and adds its secret to the lines for the user.
fn made(role: ActorRole, said: &mut Vec<String>) -> MissionResult<AccessToken> {
    let generated = AccessToken::generate(Actor { name: role.word().into(), role });
    let (token, secret) = generated.map_err(|error| MissionError::flight("no tokens can be made").because(error))?;
    if said.is_empty() {
        said.push("Tokens, valid for this run only (use `--tokens FILE` for permanent ones):".into());
    }
    said.push(format!("  {:<16}  {secret}", role.word()));
    Ok(token)
}

fn unusable(error: TlsError) -> MissionError {
    MissionError::setting("connections cannot be encrypted").because(error)
}
