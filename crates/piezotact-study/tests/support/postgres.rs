//! A PostgreSQL server of its own for tests, in a temporary folder: it ends with the program that started it, however that ends.
#![allow(dead_code, reason = "each test program uses a part of it")]
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::io::{BufRead as _, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Makes and starts a server, says so, and ends it when its input ends. `$1`: the programs; `$2`: folder; `$3`: port; `$4`: settings.
const SCRIPT: &str = r#"
set -e
chmod 700 "$2"
cd "$2"
"$1/initdb" -D data -U lab -A trust -E UTF8 --no-locale --no-sync >made 2>&1
printf '%s\n' "listen_addresses = '127.0.0.1'" "port = $3" "unix_socket_directories = '$2'" >>data/postgresql.conf
printf '%b' "$4" >>data/postgresql.conf
"$1/pg_ctl" -D data -s -w -l log start >made 2>&1
echo started
cat >/dev/null
"$1/pg_ctl" -D data -s -w -m immediate stop >made 2>&1 || true
cd /
rm -rf "$2"
"#;

/// A running server. Its user is `lab`, who needs no password.
pub(crate) struct Server {
    port: u16,
    folder: PathBuf,
    programs: PathBuf,
    /// Ends the server when it is closed.
    input: Option<ChildStdin>,
    script: Child,
}

impl Drop for Server {
    fn drop(&mut self) {
        drop(self.input.take());
        let _ended = self.script.wait();
        let _removed = std::fs::remove_dir_all(&self.folder);
    }
}

/// The server that the tests of this program share; each has a database of its own.
pub(crate) fn server() -> &'static Server {
    static SERVER: OnceLock<Server> = OnceLock::new();
    SERVER.get_or_init(|| Server::start(""))
}

impl Server {
    /// A server with `settings` in its configuration, each in a line that ends with `\n`.
    pub(crate) fn start(settings: &str) -> Self {
        let programs = programs();
        let folder = tempfile::Builder::new().prefix("pz-pg").tempdir();
        let folder = folder.unwrap().keep();
        let free = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = free.local_addr().unwrap().port();
        drop(free);
        let mut command = as_user(&folder, "sh");
        command
            .args(["-c", SCRIPT, "sh"])
            .args([&programs, &folder]);
        command.args([&port.to_string(), settings]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut script = command.spawn().unwrap();
        let mut said = String::new();
        let out = script.stdout.take().unwrap();
        BufReader::new(out).read_line(&mut said).unwrap();
        let made = std::fs::read_to_string(folder.join("made")).unwrap_or_default();
        assert_eq!(said, "started\n", "PostgreSQL did not start: {made}");
        Self {
            port,
            folder,
            programs,
            input: script.stdin.take(),
            script,
        }
    }

    /// The URL of a new, empty database.
    pub(crate) fn database(&self) -> String {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let name = format!("touch{}", NUMBER.fetch_add(1, Ordering::Relaxed));
        let url = self.url(&name);
        self.sql(&self.url("postgres"), &format!("CREATE DATABASE {name}"));
        url
    }

    /// The URL of a database called `name`.
    pub(crate) fn url(&self, name: &str) -> String {
        format!("postgres://lab@127.0.0.1:{}/{name}", self.port)
    }

    /// What `statement` gives in the database at `url`, one row a line.
    pub(crate) fn sql(&self, url: &str, statement: &str) -> String {
        self.try_sql(url, statement)
            .unwrap_or_else(|error| panic!("{statement}: {error}"))
    }

    /// As [`Self::sql`]; what the server says against it is the error.
    pub(crate) fn try_sql(&self, url: &str, statement: &str) -> Result<String, String> {
        let mut command = Command::new(self.programs.join("psql"));
        command.args([
            "-X",
            "-qAt",
            "-v",
            "ON_ERROR_STOP=1",
            "-d",
            url,
            "-c",
            statement,
        ]);
        let done = command.output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
        match done.status.success() {
            true => Ok(text(&done.stdout)),
            false => Err(text(&done.stderr)),
        }
    }

    /// Stops it as a crash does: nothing is written any more.
    pub(crate) fn crash(&self) {
        self.control(&["-m", "immediate", "stop"]);
    }

    /// Starts it again.
    pub(crate) fn start_again(&self) {
        self.control(&["-l", "log", "start"]);
    }

    /// Reads its configuration again, with `setting` added.
    pub(crate) fn set(&self, setting: &str) {
        let words = "printf '%s\\n' \"$1\" >>data/postgresql.conf";
        let mut command = as_user(&self.folder, "sh");
        let done = command.args(["-c", words, "sh", setting]).status();
        assert!(done.unwrap().success());
        self.control(&["reload"]);
    }

    /// Lets in whom `lines` say, in the form of `pg_hba.conf`.
    pub(crate) fn allow(&self, lines: &str) {
        self.write("pg_hba.conf", lines);
        self.control(&["reload"]);
        std::thread::sleep(std::time::Duration::from_millis(300));
    }

    /// Writes a file of the server, for its user alone.
    pub(crate) fn write(&self, name: &str, text: &str) {
        let words = "umask 077; printf '%s' \"$2\" >\"data/$1\"";
        let mut command = as_user(&self.folder, "sh");
        let done = command.args(["-c", words, "sh", name, text]).status();
        assert!(done.unwrap().success());
    }

    fn control(&self, words: &[&str]) {
        let mut command = as_user(&self.folder, self.programs.join("pg_ctl"));
        command.args(["-D", "data", "-s", "-w"]).args(words);
        let done = command.stdout(Stdio::null()).stderr(Stdio::null());
        assert!(done.status().unwrap().success(), "{words:?}");
    }

    /// Copies the files of the stopped server to a place of that name, or back.
    pub(crate) fn copy(&self, from: &str, to: &str) {
        let mut command = as_user(&self.folder, "sh");
        let words = "rm -rf \"$2\" && cp -a \"$1\" \"$2\"";
        let done = command.args(["-c", words, "sh", from, to]).status();
        assert!(done.unwrap().success());
    }
}

/// A command in `folder`, as a user who may run a server: PostgreSQL refuses root.
fn as_user(folder: &Path, program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = match is_root() {
        false => Command::new(program),
        true => {
            let user = match has_user("postgres") {
                true => "postgres",
                false => "nobody",
            };
            let given = Command::new("chown").arg(user).arg(folder).status();
            assert!(given.unwrap().success());
            let mut command = Command::new("runuser");
            command.args(["-u", user, "--"]).arg(program);
            command
        }
    };
    command.current_dir(folder);
    command
}

fn is_root() -> bool {
    let id = Command::new("id").arg("-u").output().unwrap();
    id.stdout == b"0\n"
}

fn has_user(name: &str) -> bool {
    let id = Command::new("id").arg(name).output().unwrap();
    id.status.success()
}

/// The folder of initdb, `pg_ctl` and psql.
fn programs() -> PathBuf {
    let mut found: Vec<PathBuf> = Vec::new();
    for version in std::fs::read_dir("/usr/lib/postgresql")
        .into_iter()
        .flatten()
    {
        found.push(version.unwrap().path().join("bin"));
    }
    found.sort();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut all = found.into_iter().rev().chain(std::env::split_paths(&path));
    let has_all = |folder: &PathBuf| {
        let programs = ["initdb", "pg_ctl", "psql"];
        programs.iter().all(|name| folder.join(name).is_file())
    };
    all.find(has_all).unwrap_or_else(|| {
        panic!(
            "expected PostgreSQL (initdb, pg_ctl, psql), found none; install it: sudo apt-get install postgresql, \
             or the package of your system that has the server"
        )
    })
}
