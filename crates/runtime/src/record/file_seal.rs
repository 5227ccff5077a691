//! The seal of a whole file: 64 bytes after SQLite's last page, with SHA-256 over everything before. SQLite ignores them.
//!
//! It makes the check of a closed record as fast as reading the file, and covers what the seals of rows do not: indexes, header, unused
//! pages.

use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

const MARK: &[u8; 24] = b"apex record file seal 1\n";
const SEAL_BYTES: u64 = 64;
/// Number of bytes read at one time.
const CHUNK_BYTES: usize = 1 << 20;

/// State of the seal at the end of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileSeal {
    /// The file has no seal: its flight continues, or was cut off.
    None,
    /// The file is byte for byte the sealed one.
    Intact,
    /// The file has a seal, but was changed afterwards.
    Broken,
}

/// Appends the seal of everything before it, in place of an older one. On a full disk the file is left without a seal.
pub(super) fn append(file: &mut File) -> io::Result<()> {
    if seal_at_end(file)?.is_some() {
        let length = file.metadata()?.len();
        file.set_len(length.saturating_sub(SEAL_BYTES))?;
    }
    let length = file.metadata()?.len();
    let digest = digest(file, length)?;
    let mut seal = Vec::with_capacity(64);
    seal.extend_from_slice(MARK);
    seal.extend_from_slice(&length.to_le_bytes());
    seal.extend_from_slice(&digest);
    file.seek(SeekFrom::Start(length))?;
    let written = file.write_all(&seal);
    if written.is_err() {
        file.set_len(length)?;
    }
    written
}

/// Compares a file with its seal.
pub(super) fn check(file: &mut File) -> io::Result<FileSeal> {
    let Some((sealed_length, sealed)) = seal_at_end(file)? else { return Ok(FileSeal::None) };
    let length = file.metadata()?.len().saturating_sub(SEAL_BYTES);
    let intact = sealed_length == length && digest(file, length)? == sealed;
    Ok(if intact { FileSeal::Intact } else { FileSeal::Broken })
}

/// Returns the seal at the end of the file, if there is one.
pub(super) fn bytes(file: &mut File) -> io::Result<Option<Vec<u8>>> {
    if seal_at_end(file)?.is_none() {
        return Ok(None);
    }
    let start = file.metadata()?.len().saturating_sub(SEAL_BYTES);
    file.seek(SeekFrom::Start(start))?;
    let mut seal = Vec::new();
    file.read_to_end(&mut seal)?;
    Ok(Some(seal))
}

/// Returns the length and digest that the seal at the end of the file states.
fn seal_at_end(file: &mut File) -> io::Result<Option<(u64, [u8; 32])>> {
    let length = file.metadata()?.len();
    let Some(start) = length.checked_sub(SEAL_BYTES) else { return Ok(None) };
    let mut seal = [0; SEAL_BYTES as usize];
    file.seek(SeekFrom::Start(start))?;
    file.read_exact(&mut seal)?;
    let Some(rest) = seal.strip_prefix(MARK) else { return Ok(None) };
    let sealed = rest.split_first_chunk::<8>().and_then(|(length, rest)| {
        let (digest, _) = rest.split_first_chunk::<32>()?;
        Some((u64::from_le_bytes(*length), *digest))
    });
    Ok(sealed)
}

fn digest(file: &mut File, length: u64) -> io::Result<[u8; 32]> {
    file.seek(SeekFrom::Start(0))?;
    let mut rest = file.take(length);
    let mut digest = Sha256::new();
    let mut chunk = vec![0; CHUNK_BYTES];
    loop {
        let read = rest.read(&mut chunk)?;
        match chunk.get(..read).filter(|bytes| !bytes.is_empty()) {
            Some(bytes) => digest.update(bytes),
            None => return Ok(digest.finalize().into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_changed_byte_breaks_the_seal() {
        let path = tempfile::NamedTempFile::new().unwrap().into_temp_path();
        std::fs::write(&path, vec![7; 3000]).unwrap();
        let open = || File::options().read(true).write(true).open(&path).unwrap();
        assert_eq!(check(&mut open()).unwrap(), FileSeal::None);
        append(&mut open()).unwrap();
        append(&mut open()).unwrap();
        let whole = std::fs::read(&path).unwrap();
        assert_eq!((whole.len(), check(&mut open()).unwrap()), (3064, FileSeal::Intact));
        for at in (0..whole.len()).step_by(97) {
            let mut bytes = whole.clone();
            bytes[at] ^= 4;
            std::fs::write(&path, bytes).unwrap();
            assert_ne!(check(&mut open()).unwrap(), FileSeal::Intact, "byte {at}");
        }
        std::fs::write(&path, &whole[64..]).unwrap();
        assert_eq!(check(&mut open()).unwrap(), FileSeal::Broken, "cut at the front");
    }
}
