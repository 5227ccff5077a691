//! For build scripts: a fingerprint of source folders. Snapshots of states have the layout of the types in them, so a build reads only the
//! snapshots of builds with equal sources.

use std::path::{Path, PathBuf};

/// Sets the environment variable `name` of the compilation to the fingerprint of `folders`, relative to the package; to `unknown` if one of
/// them cannot be read.
pub(crate) fn set(name: &str, folders: &[&str]) {
    let package = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut hash: Option<u64> = Some(0xcbf2_9ce4_8422_2325);
    for folder in folders {
        println!("cargo:rerun-if-changed={folder}");
        hash = hash.and_then(|hash| add_folder(hash, &package.join(folder)).ok());
    }
    let text = hash.map_or_else(|| "unknown".to_owned(), |hash| format!("{hash:016x}"));
    println!("cargo:rustc-env={name}={text}");
}

/// Adds the names and contents of a folder's files, in the order of their names.
fn add_folder(mut hash: u64, folder: &Path) -> std::io::Result<u64> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    entries.sort();
    for entry in entries {
        hash = add(hash, entry.file_name().unwrap_or_default().as_encoded_bytes());
        hash = if entry.is_dir() { add_folder(hash, &entry)? } else { add(hash, &std::fs::read(&entry)?) };
    }
    Ok(hash)
}

/// Fowler-Noll-Vo hash (FNV-1a); the length comes first, so that parts do not run into each other.
fn add(hash: u64, bytes: &[u8]) -> u64 {
    let length = (bytes.len() as u64).to_le_bytes();
    length.iter().chain(bytes).fold(hash, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}
