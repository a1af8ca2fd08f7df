//! Pages for other machines: the name of this one, the certificate, and the experimenter's password.

use std::io::{ErrorKind, Write as _};
use std::net::{IpAddr, Ipv4Addr, TcpListener, ToSocketAddrs as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::{Context as _, anyhow};
use clap::Args;
use piezotact_dataset::{read_input_text, reads};
use piezotact_web::{Access, Certificate, Password, Reach, VALIDITY};
use serde::{Deserialize, Serialize};

use crate::failure::{Failure, Outcome, usage};
use crate::output::say;

/// The hash of the experimenter's password, in the folder of what is served.
const PASSWORD: &str = "experimenter.password";
/// A certificate of our own is replaced so long before it ends.
const EARLIER: Duration = Duration::from_secs(30 * 24 * 3600);

#[derive(Debug, Args)]
pub(crate) struct Where {
    /// The port of the pages; 0 for any that is free.
    #[arg(long, default_value_t = 7700)]
    port: u16,
    /// Pages can be opened from other machines, encrypted: the address or name by which they reach this one, such as 192.168.1.10.
    #[arg(long, value_name = "HOST")]
    network: Option<String>,
    /// The experimenter's password for pages on a network, in the first line of a file; it is kept as a hash, and needed once.
    #[arg(long, value_name = "FILE", requires = "network")]
    password: Option<PathBuf>,
    /// The certificate of this machine (PEM); default: one of our own, made on first use.
    #[arg(long, value_name = "FILE", requires_all = ["network", "key"])]
    certificate: Option<PathBuf>,
    /// The private key of the certificate (PEM).
    #[arg(long, value_name = "FILE", requires = "certificate")]
    key: Option<PathBuf>,
}

/// Where pages are served, and from where they can be opened.
pub(super) struct Door {
    pub(super) listener: TcpListener,
    pub(super) reach: Reach,
    password: Option<PathBuf>,
}

impl Where {
    /// The door that is asked for. It is open to connections, and nobody answers them yet.
    pub(super) fn open(&self) -> Outcome<Door> {
        let Some(name) = self.network.as_deref() else {
            return Ok(Door {
                listener: self.listen(&[IpAddr::V4(Ipv4Addr::LOCALHOST)])?,
                reach: Reach::Machine,
                password: None,
            });
        };
        // An address of version 6 as browsers write it.
        let name = name
            .strip_prefix('[')
            .and_then(|six| six.strip_suffix(']'))
            .unwrap_or(name);
        let listener = self.listen(&addresses(name)?)?;
        let certificate = match (&self.certificate, &self.key) {
            (Some(chain), Some(key)) => given(name, chain, key)?,
            _ => own(name)?,
        };
        let name = name.to_owned();
        Ok(Door {
            listener,
            reach: Reach::Network { name, certificate },
            password: self.password.clone(),
        })
    }

    fn listen(&self, addresses: &[IpAddr]) -> Outcome<TcpListener> {
        let at: Vec<_> = addresses.iter().map(|ip| (*ip, self.port).into()).collect();
        let at: &[std::net::SocketAddr] = &at;
        TcpListener::bind(at).map_err(|error| {
            let addresses: Vec<String> = addresses.iter().map(ToString::to_string).collect();
            let at = format!("port {} of {}", self.port, addresses.join(", "));
            Failure::Data(match error.kind() {
                ErrorKind::AddrInUse => anyhow!(
                    "{at}: another program uses it; end that one, or state another --port (0 for any that is free)"
                ),
                ErrorKind::AddrNotAvailable => anyhow!(
                    "{at}: expected an address of this machine, found one of another; `ip address` or `ipconfig` lists those of this one"
                ),
                _ => anyhow!("{at}: {error}; state another --port (0 for any that is free)"),
            })
        })
    }
}

impl Door {
    /// Where it is, as a browser asks for it.
    fn address(&self) -> Outcome<String> {
        let at = self.listener.local_addr()?;
        Ok(match &self.reach {
            Reach::Machine => format!("http://{at}"),
            Reach::Network { name, .. } => match name.parse() {
                Ok(IpAddr::V6(six)) => format!("https://[{six}]:{}", at.port()),
                _ => format!("https://{}:{}", name.to_lowercase(), at.port()),
            },
        })
    }

    /// `access` with the password that a network asks for, which is kept in `folder`.
    pub(super) fn guard(&self, access: Access, folder: &Path) -> Outcome<Access> {
        match self.reach {
            Reach::Machine => Ok(access),
            Reach::Network { .. } => Ok(access.with_password(self.kept_password(folder)?)),
        }
    }

    fn kept_password(&self, folder: &Path) -> Outcome<Password> {
        let kept = folder.join(PASSWORD);
        let of_kept = |error| Failure::Data(anyhow!("{}: {error}", kept.display()));
        let Some(file) = &self.password else {
            if !reads::is_there(&kept) {
                return Err(usage(anyhow!(
                    "on a network the experimenter enters with a password: write one into the first line of a file, and name it once as --password"
                )));
            }
            let known = Password::of_hash(&read_input_text(&kept)?);
            return known.map_err(|error| of_kept(format!("{error} as --password FILE")));
        };
        let text = read_input_text(file)?;
        // Some editors begin a file with a mark of its encoding.
        let line = text.trim_start_matches('\u{feff}').lines().next();
        let line = line.unwrap_or_default();
        let password =
            Password::new(line).map_err(|error| usage(anyhow!("{}: {error}", file.display())))?;
        // The same one lets the pages in that it let in before; another one ends them.
        let before = reads::is_there(&kept).then(|| read_input_text(&kept).ok());
        if let Some(before) = before.flatten() {
            match Password::of_hash(&before) {
                Ok(before) if before.is(line) => return Ok(before),
                _ => say(
                    "the password is a new one: pages that entered with the old one enter again",
                ),
            }
        }
        write_for_user(&kept, password.hash()).map_err(|error| of_kept(error.to_string()))?;
        Ok(password)
    }

    /// What is said to whoever started the program: where pages are, by their codes, and `more`.
    pub(super) fn said(&self, codes: [Option<String>; 2], more: &str) -> Outcome<String> {
        let at = self.address()?;
        let [experimenter, viewer] = codes.map(|code| {
            let code = code.map(|code| format!("?code={code}"));
            format!("{at}/enter{}", code.unwrap_or_default())
        });
        let said = format!("experimenter:  {experimenter}\nto look on:    {viewer}\n{more}");
        let Reach::Network { certificate, .. } = &self.reach else {
            return Ok(said);
        };
        Ok(format!(
            "{said}\nThe experimenter enters with the password. Browsers warn of a certificate that they do not know; this one has the SHA-256\n{}",
            certificate.fingerprint().map_err(anyhow::Error::new)?
        ))
    }
}

/// The certificate of the machine called `name` in the files `chain` and `key`, which belong together.
fn given(name: &str, chain: &Path, key: &Path) -> Outcome<Certificate> {
    let certificate = Certificate {
        chain_pem: read_input_text(chain)?,
        key_pem: read_input_text(key)?,
    };
    // Before a session is begun.
    let checked = certificate.check(name, SystemTime::now());
    let warning = checked.map_err(|error| {
        usage(anyhow!(
            "{} with {}: {error}; name the certificate of this machine and its own key, or leave both out",
            chain.display(),
            key.display()
        ))
    })?;
    if let Some(warning) = warning {
        say(&format!("{}: {warning}", chain.display()));
    }
    Ok(certificate)
}

/// The addresses of this machine that `name` stands for.
fn addresses(name: &str) -> Outcome<Vec<IpAddr>> {
    if let Ok(address) = name.parse::<IpAddr>() {
        return match address.is_unspecified() || address.is_multicast() {
            true => Err(usage(anyhow!(
                "--network {name}: expected the address or name by which other machines reach this one, found one of many machines or addresses; give one, such as 192.168.1.10"
            ))),
            false => Ok(vec![address]),
        };
    }
    if name.is_empty() || name.contains([':', '/', ' ']) {
        return Err(usage(anyhow!(
            "--network {name}: expected an address or a name alone, such as 192.168.1.10; the port is given as --port, and https:// is always there"
        )));
    }
    let found = (name, 0).to_socket_addrs().map_err(|error| {
        usage(anyhow!(
            "--network {name}: {error}; give an address of this machine, such as 192.168.1.10"
        ))
    })?;
    let found: Vec<IpAddr> = found.map(|at| at.ip()).collect();
    // As Debian names a machine in its own file of hosts.
    match found.iter().all(IpAddr::is_loopback) {
        true => Err(usage(anyhow!(
            "--network {name}: this name leads to this machine from itself alone; give its address on the network, such as 192.168.1.10"
        ))),
        false => Ok(found),
    }
}

/// A certificate of our own that is kept.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    chain_pem: String,
    key_pem: String,
    /// Until when it is valid, in s since 1970-01-01 00:00 UTC.
    until_s: u64,
}

/// The certificate of our own for `name`: the one that was made before, so that browsers know it again, or a new one.
fn own(name: &str) -> Outcome<Certificate> {
    let folder = of_user()?;
    let file = format!("{}.json", name.to_lowercase().replace(':', "-"));
    let path = folder.join(file);
    let now = SystemTime::now();
    let known = reads::is_there(&path)
        .then(|| read_input_text(&path).ok())
        .flatten();
    let known = known.and_then(|text| serde_json::from_str::<Kept>(&text).ok());
    if known.is_none() && reads::is_there(&path) {
        say(&format!(
            "{}: expected the certificate of the pages, found something else; a new one takes its place, and devices that trusted the old one warn again",
            path.display()
        ));
    }
    let until_s = now.duration_since(UNIX_EPOCH).unwrap_or_default() + EARLIER;
    if let Some(known) = known.filter(|known| known.until_s > until_s.as_secs()) {
        return Ok(Certificate {
            chain_pem: known.chain_pem,
            key_pem: known.key_pem,
        });
    }
    let names = [name.to_owned()];
    let new = Certificate::own(&names, now)
        .with_context(|| format!("--network {name}"))
        .map_err(usage)?;
    let until = now.duration_since(UNIX_EPOCH).unwrap_or_default() + VALIDITY;
    let kept = Kept {
        chain_pem: new.chain_pem.clone(),
        key_pem: new.key_pem.clone(),
        until_s: until.as_secs(),
    };
    let json = serde_json::to_string(&kept)?;
    let written = std::fs::create_dir_all(&folder).and_then(|()| write_for_user(&path, &json));
    if let Err(error) = written {
        say(&format!(
            "{}: {error}; the certificate is not kept, and browsers will warn of another one at the next start",
            path.display()
        ));
    }
    Ok(new)
}

/// Where this user's programs keep what is theirs alone.
fn of_user() -> Outcome<PathBuf> {
    let of = |name: &str| {
        std::env::var_os(name)
            .filter(|value| !value.is_empty())
            .map(PathBuf::from)
    };
    let folder = match () {
        () if cfg!(windows) => of("LOCALAPPDATA"),
        () if cfg!(target_os = "macos") => {
            of("HOME").map(|home| home.join("Library/Application Support"))
        }
        () => of("XDG_DATA_HOME").or_else(|| of("HOME").map(|home| home.join(".local/share"))),
    };
    let folder = folder.ok_or_else(|| {
        usage(anyhow!(
            "expected a home folder, in which the certificate of the pages is kept, found none; give --certificate and --key"
        ))
    })?;
    Ok(folder.join("piezotact").join("certificates"))
}

/// Writes `text` to the side, for this user alone, flushes it, and renames it to `path`.
pub(super) fn write_for_user(path: &Path, text: &str) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}
