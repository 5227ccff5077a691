//! Encryption by rustls: with the user's certificate, or with one that is made for this run.

use rcgen::{CertificateParams, KeyPair};
use rustls::ServerConfig;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A certificate chain with its key.
pub struct TlsIdentity {
    chain: Vec<CertificateDer<'static>>,
    key: PrivateKeyDer<'static>,
}

/// Reason for which connections cannot be encrypted.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file has invalid contents.
    #[error("cannot read {what} from {}: {reason}; give a file in PEM format", .path.display())]
    File {
        /// The content that was expected.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// The fault.
        reason: String,
    },
    /// Certificate and key do not work together, or none can be made.
    #[error("the certificate cannot be used: {0}; give a certificate and the key that belongs to it")]
    Unusable(String),
}

impl TlsIdentity {
    /// Reads a certificate chain and its key from PEM files.
    ///
    /// # Errors
    /// A file cannot be read, or holds none.
    pub fn read(certificate: &Path, key: &Path) -> Result<TlsIdentity, TlsError> {
        let fail = |what, path: &Path, reason: String| TlsError::File { what, path: path.into(), reason };
        let chain: Result<Vec<_>, _> =
            CertificateDer::pem_file_iter(certificate).and_then(|certificates| certificates.collect());
        let chain = chain.map_err(|error| fail("a certificate", certificate, error.to_string()))?;
        if chain.is_empty() {
            return Err(fail("a certificate", certificate, "it holds none".into()));
        }
        let key = PrivateKeyDer::from_pem_file(key).map_err(|error| fail("a private key", key, error.to_string()))?;
        Ok(TlsIdentity { chain, key })
    }

    /// Makes a self-signed certificate for these names and addresses.
    ///
    /// # Errors
    /// If the system provides no random numbers, or a name is invalid.
    pub fn generate(names: Vec<String>) -> Result<TlsIdentity, TlsError> {
        let fail = |error: rcgen::Error| TlsError::Unusable(error.to_string());
        let key = KeyPair::generate().map_err(fail)?;
        let certificate = CertificateParams::new(names).and_then(|params| params.self_signed(&key)).map_err(fail)?;
        let key = PrivateKeyDer::try_from(key.serialize_der()).map_err(|error| TlsError::Unusable(error.into()))?;
        Ok(TlsIdentity { chain: vec![certificate.der().clone()], key })
    }

    /// Returns the SHA-256 digest of the certificate, in the form that browsers show.
    pub fn fingerprint(&self) -> String {
        let pairs: Vec<String> = Sha256::digest(self.certificate()).iter().map(|byte| format!("{byte:02X}")).collect();
        pairs.join(":")
    }

    /// Returns the certificate of the server, in DER.
    pub fn certificate(&self) -> &[u8] {
        self.chain.first().map_or(&[], |certificate| certificate)
    }

    /// Returns the configuration that encrypts connections.
    pub(crate) fn config(&self) -> Result<Arc<ServerConfig>, TlsError> {
        let fail = |error: rustls::Error| TlsError::Unusable(error.to_string());
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let builder =
            ServerConfig::builder_with_provider(provider).with_safe_default_protocol_versions().map_err(fail)?;
        let mut config =
            builder.with_no_client_auth().with_single_cert(self.chain.clone(), self.key.clone_key()).map_err(fail)?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Arc::new(config))
    }
}
