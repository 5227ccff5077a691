//! Warnings about a record that can be read: it is incomplete, was changed, lacks its signature, or is of another version of Apex.

use super::file_seal::FileSeal;
use super::open::Trust;
use super::reader::RecordReader;
use super::signature::{SignatureState, check_signature};
use super::writer::SIGNED_BY;
use crate::error::RecordError;

impl RecordReader {
    /// Returns warnings to print before anything else: the record is incomplete, was changed, is not as it was signed, or is of another
    /// version of Apex. Every reader of a record shows them.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn warning(&self) -> Result<Option<String>, RecordError> {
        let mut warnings = Vec::new();
        let name = self.path.display();
        let seal = match &*self.trust.borrow() {
            Trust::File(_) => FileSeal::Intact,
            Trust::Groups(_, seal, _) => *seal,
        };
        if !self.is_complete()? {
            let end = self.span()?.map_or_else(|| "nothing".to_owned(), |(_, end)| format!("everything up to {end}"));
            warnings.push(format!(
                "The flight record {name} is incomplete: its flight continues, or was cut off. It holds {end}."
            ));
        }
        if seal == FileSeal::Broken {
            warnings.push(format!(
                "The file {name} was changed after it was closed, but not what was recorded: all groups of rows fit their seals."
            ));
        }
        warnings.extend(self.signature_warning(seal)?);
        if let Some(earlier) = &self.missing {
            warnings.push(format!(
                "The flight record {name} continues {}, which is not there; put it back, or into the folder of this record.",
                earlier.display()
            ));
        }
        for gap in self.gaps()? {
            let reason = match &self.missing {
                Some(_) if gap.first_batch == 1 => "the file that it continues is not there",
                _ => "its disk took no steps",
            };
            warnings.push(format!("The flight record {name} has a gap, because {reason}: {gap}."));
        }
        let version = self.meta("apex_version")?.unwrap_or_else(|| "of unknown version".into());
        let ours = env!("CARGO_PKG_VERSION");
        if version != ours {
            let version = version.escape_debug();
            warnings.push(format!(
                "The flight record {name} was written by Apex {version}, this is Apex {ours}, which may read parts of it differently."
            ));
        }
        Ok((!warnings.is_empty()).then(|| warnings.join("\nwarning: ")))
    }

    /// Returns the warning about a record that names a key without the signature of that key.
    fn signature_warning(&self, seal: FileSeal) -> Result<Option<String>, RecordError> {
        let signed_by = self.meta(SIGNED_BY)?;
        let name = self.path.display();
        if signed_by.is_some() && !self.is_complete()? {
            return Ok(Some(format!(
                "The flight record {name} names a key, and is not signed: it is signed when it is closed."
            )));
        }
        let SignatureState::Broken(why) = check_signature(&self.path, signed_by.as_deref(), seal) else {
            return Ok(None);
        };
        Ok(Some(format!(
            "The signature of the flight record {name} is invalid: {why}. What follows may not be what was recorded; `apex verify` decides."
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::{place_for_record, record_samples};
    use crate::record::{SigningKey, check_integrity, seal_rows, signature_path};
    use apex_model::time::Time;
    use rusqlite::Connection;

    #[test]
    fn every_reader_of_a_signed_record_is_warned_unless_it_is_as_it_was_signed() {
        let (folder, path) = place_for_record();
        let key = folder.path().join("key");
        std::fs::write(&key, "0b".repeat(32)).unwrap();
        let mut recorder = record_samples(&path);
        recorder.sign_with(SigningKey::read(&key).unwrap()).unwrap();
        recorder.commit().unwrap();
        let warning = || RecordReader::open(&path).unwrap().warning().unwrap().unwrap_or_default();
        assert!(warning().contains("is not signed: it is signed when it is closed"), "{}", warning());
        recorder.finish(Time::ZERO, "stopped").unwrap();
        drop(recorder);
        assert_eq!(warning(), "");
        let signature = std::fs::read(signature_path(&path)).unwrap();
        std::fs::remove_file(signature_path(&path)).unwrap();
        assert!(warning().contains("flight.apex.sig cannot be read"), "{}", warning());
        std::fs::write(signature_path(&path), signature).unwrap();
        assert_eq!(warning(), "");
        // A forger makes the seals of the rows again; the seal of the file, which is what was signed, is left as it was.
        let connection = Connection::open(&path).unwrap();
        connection.execute_batch("UPDATE meta SET value = 'moon' WHERE key = 'end_reason'; DELETE FROM seal").unwrap();
        seal_rows(&connection).unwrap();
        connection.close().unwrap();
        let integrity = check_integrity(&path).unwrap();
        assert!(integrity.is_intact(), "{integrity}");
        assert!(warning().contains("is invalid: the file was changed after it was closed"), "{}", warning());
    }
}
