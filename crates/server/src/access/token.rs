//! Tokens: secrets, each with a name and a role. The server stores only digests.

use apex_runtime::authority::{Actor, ActorRole};
use sha2::{Digest, Sha256};
use std::fmt;

/// Minimum number of characters of a token: 16 characters of 64 kinds cannot be guessed.
const SECRET_MIN: usize = 16;
/// Number of bytes of a new secret.
const SECRET_BYTES: usize = 24;
/// Maximum number of characters of a name.
const NAME_MAX: usize = 64;

/// A token with its name and role. The secret itself is not kept.
#[derive(Clone, PartialEq, Eq)]
pub struct AccessToken {
    /// The name and the role that the token gives.
    pub actor: Actor,
    digest: [u8; 32],
}

/// A line of a file of tokens that is not a token.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line} is not a token: {fault}; write `ROLE NAME SECRET`, for example `operator tower {example}`")]
pub struct TokenError {
    line: usize,
    fault: String,
    example: String,
}

impl AccessToken {
    /// Returns the token with this secret.
    ///
    /// # Errors
    /// The secret is too short, or the name is invalid.
    pub fn new(actor: Actor, secret: &str) -> Result<AccessToken, String> {
        if secret.chars().count() < SECRET_MIN {
            return Err(format!("the secret of {} has fewer than {SECRET_MIN} characters", actor.name.escape_debug()));
        }
        check_name(&actor.name)?;
        Ok(AccessToken { actor, digest: digest(secret) })
    }

    /// Reads a file of tokens: lines `ROLE NAME SECRET`; empty lines and lines that begin with `#` are skipped.
    ///
    /// # Errors
    /// The first line that is not a token, or a repeated secret.
    pub fn read_all(text: &str) -> Result<Vec<AccessToken>, TokenError> {
        let mut tokens: Vec<AccessToken> = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let line = line.trim().trim_start_matches('\u{feff}');
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let token = AccessToken::read(line).and_then(|token| {
                let same = tokens.iter().find(|known| known.digest == token.digest);
                let other_role =
                    |known: &&AccessToken| known.actor.name == token.actor.name && known.actor.role != token.actor.role;
                match (same, tokens.iter().find(other_role)) {
                    (Some(known), _) => Err(format!("its secret is that of {}", known.actor)),
                    // Authority is held by names.
                    (None, Some(known)) => Err(format!("its name has another role: {}", known.actor)),
                    (None, None) => Ok(token),
                }
            });
            let example = new_secret().unwrap_or_default();
            tokens.push(token.map_err(|fault| TokenError { line: index + 1, fault, example })?);
        }
        Ok(tokens)
    }

    fn read(line: &str) -> Result<AccessToken, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [role, name, secret] = words.as_slice() else {
            return Err(format!("it has {} words", words.len()));
        };
        let role = ActorRole::of_word(role).ok_or_else(|| {
            let words: Vec<&str> = ActorRole::ALL.into_iter().map(ActorRole::word).collect();
            format!("unknown role `{}`: expected one of {}", role.escape_debug(), words.join(", "))
        })?;
        AccessToken::new(Actor { name: (*name).into(), role }, secret)
    }

    /// Returns a new token for `actor`, and its secret.
    ///
    /// # Errors
    /// If the system provides no random bytes.
    pub fn generate(actor: Actor) -> Result<(AccessToken, String), String> {
        let secret = new_secret()?;
        Ok((AccessToken { actor, digest: digest(&secret) }, secret))
    }

    /// Returns true if `secret` is the digest of the token's secret. The comparison takes the same time for every digest.
    pub(crate) fn fits(&self, secret: &[u8; 32]) -> bool {
        let differences =
            self.digest.iter().zip(secret).fold(0, |differences, (ours, theirs)| differences | (ours ^ theirs));
        differences == 0
    }
}

impl fmt::Debug for AccessToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AccessToken").field("actor", &self.actor).finish_non_exhaustive()
    }
}

/// Checks the name of an operator or program.
pub(crate) fn check_name(name: &str) -> Result<(), String> {
    let allowed = |each: char| each.is_alphanumeric() || ['-', '_', '.'].contains(&each);
    if !name.is_empty() && name.chars().count() <= NAME_MAX && name.chars().all(allowed) {
        return Ok(());
    }
    Err(format!("the name `{}` is not 1 to {NAME_MAX} letters, digits, `-`, `_` and `.`", name.escape_debug()))
}

/// Returns the digest of a secret.
pub(crate) fn digest(secret: &str) -> [u8; 32] {
    Sha256::digest(secret.as_bytes()).into()
}

/// Returns a secret from the random numbers of the system.
pub(crate) fn new_secret() -> Result<String, String> {
    let mut bytes = [0; SECRET_BYTES];
    getrandom::fill(&mut bytes).map_err(|error| format!("the operating system provides no random numbers: {error}"))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_read_and_bad_lines_are_named() {
        let text = "# the tower\noperator tower 0123456789abcdef\n\nobserver guest fedcba9876543210\n";
        let tokens = AccessToken::read_all(text).unwrap();
        assert_eq!(tokens.len(), 2);
        assert_eq!(tokens[0].actor, Actor { name: "tower".into(), role: ActorRole::Operator });
        assert!(tokens[0].fits(&digest("0123456789abcdef")) && !tokens[0].fits(&digest("fedcba9876543210")));
        for (text, fault) in [
            ("operator tower short", "fewer than 16"),
            ("captain tower 0123456789abcdef", "expected one of observer, operator, pilot-in-command"),
            ("operator 0123456789abcdef", "it has 2 words"),
            (
                "observer a 0123456789abcdef\noperator a fedcba9876543210",
                "line 2 is not a token: its name has another role",
            ),
            ("operator a\u{7f}b 0123456789abcdef", "the name `a\\u{7f}b` is not"),
            (
                "operator a 0123456789abcdef\nobserver b 0123456789abcdef",
                "line 2 is not a token: its secret is that of a",
            ),
        ] {
            let error = AccessToken::read_all(text).unwrap_err().to_string();
            assert!(error.contains(fault) && !error.contains("0123456789abcdef"), "{text:?}: {error}");
        }
        let (token, secret) = AccessToken::generate(Actor { name: "a".into(), role: ActorRole::Observer }).unwrap();
        assert!(token.fits(&digest(&secret)) && secret.len() == 48);
        assert!(!format!("{token:?}").contains("digest"));
    }
}
