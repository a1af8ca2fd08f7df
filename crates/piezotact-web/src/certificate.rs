//! The certificate with which pages are encrypted: one of our own, or one that was given.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use piezotact_people::campaign::chain::Sha;
use rcgen::{CertificateParams, DnType, ExtendedKeyUsagePurpose, KeyPair, date_time_ymd};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::client::{verify_server_cert_signed_by_trust_anchor, verify_server_name};
use tokio_rustls::rustls::pki_types::pem;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName, UnixTime};
use tokio_rustls::rustls::server::ParsedCertificate;
use tokio_rustls::rustls::{
    CertificateError as Invalid, Error as TlsError, RootCertStore, ServerConfig, crypto,
};

/// How long a certificate of our own is valid: browsers refuse longer ones.
pub const VALIDITY: Duration = Duration::from_secs(365 * 24 * 3600);
/// A clock that is late does not refuse a new one.
const BEFORE: Duration = Duration::from_secs(24 * 3600);

/// A certificate that cannot be made or used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CertificateError(String);

/// A certificate with its private key, both as PEM.
#[derive(Clone)]
pub struct Certificate {
    /// The certificate, with those that vouch for it after it.
    pub chain_pem: String,
    pub key_pem: String,
}

impl std::fmt::Debug for Certificate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // The key stays out of messages.
        f.debug_struct("Certificate").finish_non_exhaustive()
    }
}

impl Certificate {
    /// A new certificate for `names` (host names and addresses), which vouches for itself, valid for [`VALIDITY`] from `now` on.
    ///
    /// # Errors
    /// [`CertificateError`] for a name that is none, and without random numbers.
    pub fn own(names: &[String], now: SystemTime) -> Result<Self, CertificateError> {
        let failed = |error: rcgen::Error| CertificateError(error.to_string());
        let mut params = CertificateParams::new(names).map_err(failed)?;
        let since = now.duration_since(SystemTime::UNIX_EPOCH);
        let now = date_time_ymd(1970, 1, 1) + since.unwrap_or_default();
        params.not_before = now - BEFORE;
        params.not_after = now + VALIDITY;
        let name = &mut params.distinguished_name;
        name.push(DnType::CommonName, "Piezotact");
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
        let key = KeyPair::generate().map_err(failed)?;
        let certificate = params.self_signed(&key).map_err(failed)?;
        Ok(Self {
            chain_pem: certificate.pem(),
            key_pem: key.serialize_pem(),
        })
    }

    /// The SHA-256 of the certificate, as browsers show it: pairs of hexadecimal digits with colons.
    ///
    /// # Errors
    /// [`CertificateError`] where there is no certificate in the text.
    pub fn fingerprint(&self) -> Result<String, CertificateError> {
        let chain = self.chain()?;
        let sha = Sha::of(chain.first().map_or(&[], AsRef::as_ref)).to_string();
        let pairs: Vec<&str> = (0..sha.len() / 2).map(|i| &sha[2 * i..2 * i + 2]).collect();
        Ok(pairs.join(":").to_uppercase())
    }

    /// Whether connections to the machine called `name` can be encrypted with it at `now`; what browsers will complain of, where it is for
    /// other names.
    ///
    /// # Errors
    /// [`CertificateError`] where certificate or key cannot be read, or do not belong together, and for one that is not valid at that time.
    ///
    /// Source: RFC 5280, sections 4.1.2.5 and 4.2.1.6.
    pub fn check(&self, name: &str, now: SystemTime) -> Result<Option<String>, CertificateError> {
        self.acceptor()?;
        let chain = self.chain()?;
        let failed =
            |error: TlsError| CertificateError(format!("expected a certificate in PEM: {error}"));
        let first = chain.first().ok_or(TlsError::NoCertificatesPresented);
        let first = first
            .and_then(ParsedCertificate::try_from)
            .map_err(failed)?;
        let since = now.duration_since(SystemTime::UNIX_EPOCH);
        let now = UnixTime::since_unix_epoch(since.unwrap_or_default());
        let day = |at: UnixTime| {
            let at = date_time_ymd(1970, 1, 1) + Duration::from_secs(at.as_secs());
            at.date()
        };
        // Nobody is trusted, so a certificate within its time is one of an unknown issuer; the time is compared first.
        let nobody = RootCertStore::empty();
        match verify_server_cert_signed_by_trust_anchor(&first, &nobody, &[], now, &[]) {
            Err(TlsError::InvalidCertificate(Invalid::ExpiredContext { not_after, .. })) => {
                return Err(CertificateError(format!(
                    "the certificate was valid until {}: renew it",
                    day(not_after)
                )));
            }
            Err(TlsError::InvalidCertificate(Invalid::NotValidYetContext {
                not_before, ..
            })) => {
                return Err(CertificateError(format!(
                    "the certificate is valid from {} on, which is later than the clock of this machine",
                    day(not_before)
                )));
            }
            _ => {}
        }
        let is_named =
            ServerName::try_from(name).is_ok_and(|name| verify_server_name(&first, &name).is_ok());
        let warning = || format!("the certificate does not name {name}: browsers will warn of it");
        Ok((!is_named).then(warning))
    }

    fn chain(&self) -> Result<Vec<CertificateDer<'static>>, CertificateError> {
        let chain = CertificateDer::pem_slice_iter(self.chain_pem.as_bytes());
        let chain: Result<Vec<_>, _> = chain.collect();
        match chain {
            Ok(chain) if !chain.is_empty() => Ok(chain),
            Ok(_none) => Err(CertificateError(
                "expected a certificate in PEM, found none".into(),
            )),
            Err(error) => Err(CertificateError(format!(
                "expected a certificate in PEM: {error}"
            ))),
        }
    }

    /// What encrypts connections with it.
    ///
    /// # Errors
    /// [`CertificateError`] where certificate or key cannot be read, or do not belong together.
    pub(crate) fn acceptor(&self) -> Result<TlsAcceptor, CertificateError> {
        let key = PrivateKeyDer::from_pem_slice(self.key_pem.as_bytes()).map_err(|error| {
            CertificateError(match error {
                _ if self.key_pem.contains("ENCRYPTED") => {
                    "the private key is encrypted: expected one without a passphrase".into()
                }
                pem::Error::NoItemsFound => "expected a private key in PEM, found none".into(),
                error => format!("expected a private key in PEM: {error}"),
            })
        })?;
        let failed = |error: TlsError| {
            CertificateError(match error {
                TlsError::InconsistentKeys(_) => {
                    "the private key is that of another certificate".into()
                }
                error => format!("the certificate or its key cannot be used: {error}"),
            })
        };
        let config =
            ServerConfig::builder_with_provider(Arc::new(crypto::ring::default_provider()));
        let config = config
            .with_safe_default_protocol_versions()
            .map_err(failed)?;
        let config = config.with_no_client_auth();
        let mut config = config
            .with_single_cert(self.chain()?, key)
            .map_err(failed)?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(TlsAcceptor::from(Arc::new(config)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_own_certificate_is_usable_and_has_a_fingerprint() {
        let names = ["192.168.1.10".to_owned(), "bench.local".to_owned()];
        let own = Certificate::own(&names, SystemTime::now()).unwrap();
        assert!(own.acceptor().is_ok());
        let fingerprint = own.fingerprint().unwrap();
        assert_eq!(fingerprint.split(':').count(), 32, "{fingerprint}");
        let other = Certificate::own(&names, SystemTime::now()).unwrap();
        let mixed = Certificate {
            key_pem: other.key_pem,
            ..own.clone()
        };
        let mixed = mixed.acceptor().err().unwrap().to_string();
        assert!(mixed.contains("another certificate"), "{mixed}");
        for text in ["", "-----BEGIN CERTIFICATE-----\n", "x"] {
            let chain_pem = text.to_owned();
            let none = Certificate {
                chain_pem,
                ..own.clone()
            };
            assert!(none.fingerprint().is_err(), "{text}");
        }
    }

    #[test]
    fn other_times_and_names_are_found() {
        let now = SystemTime::now();
        let names = ["192.168.1.10", "bench.local", "::1", "*.lab.example"];
        let own = Certificate::own(&names.map(str::to_owned), now).unwrap();
        for name in ["192.168.1.10", "Bench.local", "::1", "touch.lab.example"] {
            assert_eq!(own.check(name, now), Ok(None), "{name}");
        }
        for name in ["192.168.1.11", "local", "lab.example", "a.b.lab.example"] {
            assert!(own.check(name, now).unwrap().is_some(), "{name}");
        }
        let old = own.check("::1", now + VALIDITY + BEFORE).unwrap_err();
        assert!(old.to_string().contains("valid until"), "{old}");
        let new = own.check("::1", now - 2 * BEFORE).unwrap_err();
        assert!(new.to_string().contains("valid from"), "{new}");
        let key_pem = "-----BEGIN ENCRYPTED PRIVATE KEY-----\n".into();
        let encrypted = Certificate { key_pem, ..own }
            .check("::1", now)
            .unwrap_err();
        assert!(encrypted.to_string().contains("passphrase"), "{encrypted}");
    }
}
