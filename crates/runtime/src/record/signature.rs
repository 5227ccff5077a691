//! Signatures of closed records: Ed25519 (RFC 8032) over the seal of the file, in a file next to the record.
//!
//! A seal reveals accidental changes, and changes by programs that do not know it; a program that knows the seal can compute another one.
//! A signature reveals every change to readers who know the public key. The record names the key that will sign it (fact `signed_by`), so
//! that a missing signature is noticed.

use super::file_seal::{self, FileSeal};
use super::schema::sibling;
use ed25519_compact::{KeyPair, PublicKey, Seed, Signature};
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// First line of a signature's file, and beginning of the signed text.
const MARK: &str = "apex record signature 1";
/// Maximum number of bytes of a key file or signature file that are read.
const FILE_BYTES_MAX: u64 = 4_096;

/// A secret key.
#[derive(Clone)]
pub struct SigningKey(KeyPair);

impl fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SigningKey(public {})", self.public())
    }
}

impl SigningKey {
    /// Reads a key file: 64 hexadecimal digits, in the format of `openssl rand -hex 32`.
    ///
    /// # Errors
    /// Why the file is not a key.
    pub fn read(path: &Path) -> Result<SigningKey, String> {
        let text = read_text(path).map_err(|error| format!("it cannot be read: {error}"))?;
        let bytes: Option<[u8; 32]> = from_hex(text.trim()).and_then(|bytes| bytes.try_into().ok());
        let bytes = bytes.ok_or("expected 64 hexadecimal digits")?;
        Ok(SigningKey(KeyPair::from_seed(Seed::new(bytes))))
    }

    /// Returns the public key, as hexadecimal digits.
    pub fn public(&self) -> String {
        to_hex(&*self.0.pk)
    }
}

/// State of the signature of a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SignatureState {
    /// The record names no key.
    Unsigned,
    /// The record is the one that the holder of this key signed.
    SignedBy(String),
    /// The reason if the record was changed after it was signed, or lacks the signature of the key that it names.
    Broken(String),
}

/// Returns the file of the signature of the record at `path`.
pub fn signature_path(path: &Path) -> PathBuf {
    sibling(path, ".sig")
}

/// Signs the closed record at `path`.
pub(super) fn sign(path: &Path, key: &SigningKey) -> io::Result<()> {
    let seal = file_seal::bytes(&mut File::open(path)?)?.ok_or_else(|| {
        io::Error::other("the file has no seal, because another program reads it; close that program")
    })?;
    let signature = key.0.sk.sign(message(&seal), None);
    let text = format!("{MARK}\npublic {}\nsignature {}\n", key.public(), to_hex(&*signature));
    std::fs::write(signature_path(path), text)
}

/// Checks the signature of the record at `path`, which names the key `signed_by`. `seal` is the result of comparing the file with its seal:
/// the signature is over the seal alone.
pub fn check_signature(path: &Path, signed_by: Option<&str>, seal: FileSeal) -> SignatureState {
    let Some(signed_by) = signed_by else { return SignatureState::Unsigned };
    match checked(path, signed_by, seal) {
        Ok(()) => SignatureState::SignedBy(signed_by.to_string()),
        Err(why) => SignatureState::Broken(why),
    }
}

fn checked(path: &Path, signed_by: &str, seal: FileSeal) -> Result<(), String> {
    match seal {
        FileSeal::Intact => {}
        FileSeal::Broken => return Err("the file was changed after it was closed".into()),
        FileSeal::None => return Err("the file has no seal".into()),
    }
    let file = signature_path(path);
    let name = file.display();
    let text = read_text(&file).map_err(|error| format!("its signature {name} cannot be read: {error}"))?;
    let mut lines = text.lines();
    let (mark, public, signature) = (lines.next(), lines.next(), lines.next());
    let garbled = || format!("{name} is not the signature of a record");
    if mark != Some(MARK) {
        return Err(garbled());
    }
    let public = public.and_then(|line| line.strip_prefix("public ")).ok_or_else(garbled)?;
    if public != signed_by {
        return Err(format!("the record names the key {}, and {name} is of another key", signed_by.escape_debug()));
    }
    let key = from_hex(public).and_then(|bytes| PublicKey::from_slice(&bytes).ok()).ok_or_else(garbled)?;
    let signature = signature.and_then(|line| line.strip_prefix("signature ")).and_then(from_hex);
    let signature = signature.and_then(|bytes| Signature::from_slice(&bytes).ok()).ok_or_else(garbled)?;
    let seal = File::open(path).and_then(|mut file| file_seal::bytes(&mut file));
    let seal = seal.map_err(|error| error.to_string())?.ok_or("the file has no seal")?;
    key.verify(message(&seal), &signature).map_err(|_| "the record is not as it was signed".to_string())
}

fn message(seal: &[u8]) -> Vec<u8> {
    let mut message = Vec::from(MARK.as_bytes());
    message.push(0);
    message.extend_from_slice(seal);
    message
}

fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(FILE_BYTES_MAX).read_to_string(&mut text)?;
    Ok(text)
}

fn to_hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn from_hex(text: &str) -> Option<Vec<u8>> {
    if !text.len().is_multiple_of(2) || !text.is_ascii() {
        return None;
    }
    let digit = |byte: u8| char::from(byte).to_digit(16);
    let pair = |pair: &[u8]| match pair {
        [high, low] => u8::try_from(digit(*high)? * 16 + digit(*low)?).ok(),
        _ => None,
    };
    text.as_bytes().chunks(2).map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signed() -> (tempfile::TempDir, PathBuf, SigningKey) {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("flight.apex");
        std::fs::write(&path, vec![7; 3000]).unwrap();
        file_seal::append(&mut File::options().read(true).write(true).open(&path).unwrap()).unwrap();
        let key = folder.path().join("key");
        std::fs::write(&key, format!("{}\n", "0b".repeat(32))).unwrap();
        let key = SigningKey::read(&key).unwrap();
        sign(&path, &key).unwrap();
        (folder, path, key)
    }

    #[test]
    fn a_signature_holds_until_the_seal_changes() {
        let (_folder, path, key) = signed();
        let public = key.public();
        assert_eq!(check_signature(&path, Some(&public), FileSeal::Intact), SignatureState::SignedBy(public.clone()));
        assert_eq!(check_signature(&path, None, FileSeal::Intact), SignatureState::Unsigned);
        for (seal, why) in [(FileSeal::Broken, "changed after it was closed"), (FileSeal::None, "has no seal")] {
            let SignatureState::Broken(told) = check_signature(&path, Some(&public), seal) else { panic!("{seal:?}") };
            assert!(told.contains(why), "{told}");
        }
        // A forger changes the file and seals it again.
        let mut file = File::options().read(true).write(true).open(&path).unwrap();
        io::Write::write_all(&mut file, b"forged").unwrap();
        file_seal::append(&mut file).unwrap();
        let SignatureState::Broken(why) = check_signature(&path, Some(&public), FileSeal::Intact) else {
            panic!("forged")
        };
        assert!(why.contains("not as it was signed"), "{why}");
    }

    #[test]
    fn a_signature_that_is_missing_garbled_or_of_another_key_is_reported() {
        let (_folder, path, key) = signed();
        let public = key.public();
        let broken = |signed_by: &str| match check_signature(&path, Some(signed_by), FileSeal::Intact) {
            SignatureState::Broken(why) => why,
            other => panic!("{other:?}"),
        };
        assert!(broken(&"ab".repeat(32)).contains("of another key"));
        let file = signature_path(&path);
        let text = std::fs::read_to_string(&file).unwrap();
        for (changed, why) in [
            (text.replace("signature 1", "signature 2"), "is not the signature"),
            (text.replacen("signature ", "sig ", 2), "is not the signature"),
            (text.get(..150).unwrap().to_string(), "is not the signature"),
            (String::new(), "is not the signature"),
        ] {
            std::fs::write(&file, changed).unwrap();
            assert!(broken(&public).contains(why), "{}", broken(&public));
        }
        std::fs::remove_file(&file).unwrap();
        assert!(broken(&public).contains("cannot be read"));
    }

    #[test]
    fn a_key_file_holds_64_digits() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("key");
        for text in ["", "zz", &"0b".repeat(31), &"0b".repeat(33), &"é".repeat(32)] {
            std::fs::write(&path, text).unwrap();
            assert!(SigningKey::read(&path).unwrap_err().contains("64 hexadecimal digits"), "{text}");
        }
        let shown = format!("{:?}", signed().2);
        assert!(!shown.contains(&"0b".repeat(32)) && shown.contains("public"), "{shown}");
    }
}
