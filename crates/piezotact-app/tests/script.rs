//! The script `x` on tiny checkouts made on the spot: each gets its own program, and none compiles the dependency again.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, SystemTime};

/// The script that is tested.
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../x");

/// Checkouts beside each other, with a cache and a dependency outside of them.
struct Checkouts(tempfile::TempDir);

impl Checkouts {
    fn new() -> Self {
        let checkouts = Self(tempfile::tempdir().unwrap());
        checkouts.write(
            "dependency/Cargo.toml",
            "[package]\nname = \"dependency\"\nversion = \"1.0.0\"\nedition = \"2024\"\n",
        );
        checkouts.write("dependency/src/lib.rs", "pub fn one() -> i32 { 1 }\n");
        checkouts
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file that seems to be an hour old, as a clone that was made an hour ago.
    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        let file = std::fs::File::options().write(true).open(&path).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_secs(3600))
            .unwrap();
    }

    /// A checkout whose program says `help` and where it was compiled.
    fn checkout(&self, name: &str, help: &str) {
        let file = |path: &str, text: &str| self.write(&format!("{name}/{path}"), text);
        file(
            "Cargo.toml",
            "[workspace]\nresolver = \"3\"\nmembers = [\"crates/*\"]\n\n[workspace.package]\nrust-version = \"1.85\"\n",
        );
        file(
            "Cargo.lock",
            "version = 4\n\n[[package]]\nname = \"dependency\"\nversion = \"1.0.0\"\n\n\
             [[package]]\nname = \"piezotact\"\nversion = \"0.1.0\"\n\n\
             [[package]]\nname = \"piezotact-app\"\nversion = \"0.1.0\"\n\
             dependencies = [\n \"dependency\",\n \"piezotact\",\n]\n",
        );
        file(
            "crates/piezotact/Cargo.toml",
            "[package]\nname = \"piezotact\"\nversion = \"0.1.0\"\nedition = \"2024\"\n",
        );
        file(
            "crates/piezotact/src/lib.rs",
            &format!(
                "pub const HELP: &str = \"{help}\";\n\
                 #[test] #[ignore] fn soak_kills() {{}}\n\
                 #[test] #[ignore] fn soak_fails() {{ panic!() }}\n\
                 #[test] #[ignore] fn of_another_issue() {{ panic!() }}\n"
            ),
        );
        file(
            "crates/piezotact-app/Cargo.toml",
            "[package]\nname = \"piezotact-app\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
             [dependencies]\npiezotact = { path = \"../piezotact\" }\n\
             dependency = { path = \"../../../dependency\" }\n\n\
             [features]\nfull = []\n\n\
             [[bin]]\nname = \"piezotact\"\npath = \"src/main.rs\"\n",
        );
        file(
            "crates/piezotact-app/src/main.rs",
            "fn main() {\n\
             if std::env::args().nth(1).as_deref() == Some(\"manual\") {\n\
             let to = std::path::PathBuf::from(std::env::args().nth(2).unwrap());\n\
             for name in [\"completions/piezotact.bash\", \"completions/piezotact.fish\", \"completions/_piezotact\", \"man/piezotact.1\"] {\n\
             std::fs::create_dir_all(to.join(name).parent().unwrap()).unwrap();\n\
             std::fs::write(to.join(name), name).unwrap();\n\
             }\n\
             return;\n\
             }\n\
             println!(\"{} {} {}\", piezotact::HELP, env!(\"CARGO_MANIFEST_DIR\"), dependency::one());\n\
             }\n",
        );
        std::fs::copy(SCRIPT, self.path(&format!("{name}/x"))).unwrap();
    }

    /// `./x build` in a checkout, begun.
    fn build(&self, name: &str, target: Option<&Path>) -> Child {
        self.begin(name, &["build"], target)
    }

    /// The script in a checkout, begun.
    fn begin(&self, name: &str, arguments: &[&str], target: Option<&Path>) -> Child {
        let mut command = Command::new("bash");
        command
            .arg("./x")
            .args(arguments)
            .current_dir(self.path(name))
            .env("XDG_CACHE_HOME", self.path("cache"))
            .env("CARGO_TERM_COLOR", "never")
            .env_remove("CARGO_TARGET_DIR")
            .env_remove("CARGO_BUILD_TARGET_DIR")
            .env_remove("PIEZOTACT_OWN_DEPENDENCIES")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        if let Some(target) = target {
            command.env("CARGO_TARGET_DIR", target);
        }
        command.spawn().unwrap()
    }

    /// The program that a build handed out says `help` and its checkout; and what cargo compiled.
    #[track_caller]
    fn expect(&self, building: Child, name: &str, help: &str) -> Vec<String> {
        let output = building.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{name}: {said}");
        let printed = String::from_utf8(output.stdout).unwrap();
        let program = printed.lines().last().unwrap();
        let found = Command::new(program).output().unwrap().stdout;
        let place = self.path(name).join("crates/piezotact-app");
        assert_eq!(
            String::from_utf8(found).unwrap(),
            format!("{help} {} 1\n", place.display()),
            "{name}: {said}"
        );
        let compiled = said.lines().filter_map(|line| {
            let (_, rest) = line.split_once("Compiling ")?;
            Some(rest.split(' ').next()?.to_owned())
        });
        let mut compiled: Vec<String> = compiled.collect();
        compiled.sort();
        compiled
    }
}

const OWN: [&str; 2] = ["piezotact", "piezotact-app"];
const ALL: [&str; 3] = ["dependency", "piezotact", "piezotact-app"];

#[test]
fn checkouts_built_in_turn_get_their_own_programs() {
    let checkouts = Checkouts::new();
    checkouts.checkout("one", "first");
    checkouts.checkout("two", "second");
    let built = |name, help| checkouts.expect(checkouts.build(name, None), name, help);
    assert_eq!(built("one", "first"), ALL);
    // The second never compiles the dependency, and either of them nothing twice.
    assert_eq!(built("two", "second"), OWN);
    assert_eq!(built("one", "first"), [""; 0]);
    assert_eq!(built("two", "second"), [""; 0]);

    // Another checkout takes the place of the first, with its files and what was compiled of it.
    std::fs::rename(checkouts.path("one"), checkouts.path("away")).unwrap();
    std::fs::rename(checkouts.path("two"), checkouts.path("one")).unwrap();
    assert_eq!(built("one", "second"), OWN);
    assert_eq!(built("away", "first"), OWN);
}

#[test]
fn checkouts_that_share_a_target_folder_get_their_own_programs() {
    let checkouts = Checkouts::new();
    checkouts.checkout("one", "first");
    checkouts.checkout("two", "second");
    let target = checkouts.path("target");
    let begin = |name| checkouts.build(name, Some(&target));
    assert_eq!(checkouts.expect(begin("one"), "one", "first"), ALL);
    assert_eq!(checkouts.expect(begin("two"), "two", "second"), OWN);
    assert_eq!(checkouts.expect(begin("one"), "one", "first"), OWN);
}

#[test]
fn checkouts_built_at_the_same_time_get_their_own_programs() {
    let checkouts = Checkouts::new();
    let names = ["one", "two", "three"];
    for name in names {
        checkouts.checkout(name, name);
    }
    let building = names.map(|name| checkouts.build(name, None));
    for (building, name) in building.into_iter().zip(names) {
        checkouts.expect(building, name, name);
    }
}

/// `./x soak` runs the ignored tests of its names and no others, fails where one fails, and says how long its steps took.
#[test]
fn soak_runs_the_ignored_tests_of_its_names() {
    let checkouts = Checkouts::new();
    checkouts.checkout("one", "first");
    let soak = |arguments: &[&str]| {
        let output = checkouts.begin("one", arguments, None);
        let output = output.wait_with_output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.success(), String::from_utf8(said).unwrap())
    };
    let (done, said) = soak(&["soak", "kill"]);
    assert!(done && said.contains("test soak_kills ... ok"), "{said}");
    assert!(
        said.contains("time of each step") && said.contains(" s  soak kill\n"),
        "{said}"
    );
    assert!(!said.contains("of_another_issue"), "{said}");
    let (done, said) = soak(&["soak"]);
    assert!(!done && said.contains(" s  soak numbers: failed"), "{said}");
    assert!(
        said.contains("soak_fails") && !said.contains("of_another_issue"),
        "{said}"
    );
    let (_, list) = soak(&["soak", "--list"]);
    for part in ["kill  passed", "numbers  failed", "house  failed"] {
        assert!(list.contains(part), "{part}: {list}");
    }
}

/// `./x install` puts program, completions and man pages below a folder, says where, and replaces what it installed before.
#[test]
fn install_puts_the_program_where_shells_and_man_look() {
    let checkouts = Checkouts::new();
    checkouts.checkout("one", "first");
    let install = |arguments: &[&str]| {
        let output = checkouts.begin("one", arguments, None);
        let output = output.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.success(), said)
    };
    for _ in 0..2 {
        let (done, said) = install(&["install", "--prefix", "place"]);
        assert!(done, "{said}");
        // A folder that is given relative to the caller, who is in the checkout here.
        let place = checkouts.path("one/place");
        let program = Command::new(place.join("bin/piezotact")).output().unwrap();
        assert!(
            String::from_utf8(program.stdout)
                .unwrap()
                .starts_with("first ")
        );
        for (name, of) in [
            (
                "bash-completion/completions/piezotact",
                "completions/piezotact.bash",
            ),
            (
                "fish/vendor_completions.d/piezotact.fish",
                "completions/piezotact.fish",
            ),
            ("zsh/site-functions/_piezotact", "completions/_piezotact"),
            ("man/man1/piezotact.1", "man/piezotact.1"),
        ] {
            let found = std::fs::read_to_string(place.join("share").join(name)).unwrap();
            assert_eq!(found, of);
        }
        assert!(
            said.contains("/one/place/bin/piezotact, completions"),
            "{said}"
        );
        assert!(said.contains("/one/place/bin is not on the path"), "{said}");
    }
    let (done, said) = install(&["install", "place"]);
    assert!(
        !done && said.contains("expected nothing or --prefix DIR, found place"),
        "{said}"
    );
}

/// The script on a system without Rust, which has the commands `has`, each a script of its own; HOME is empty.
fn without_rust(has: &[(&str, &str)], arguments: &[&str]) -> (bool, String) {
    let checkouts = Checkouts::new();
    checkouts.checkout("one", "first");
    let commands = checkouts.path("commands");
    std::fs::create_dir_all(&commands).unwrap();
    std::fs::create_dir_all(checkouts.path("home")).unwrap();
    let plain = [
        "bash", "sed", "sort", "head", "cut", "dirname", "mktemp", "rm", "cat", "printf", "env",
        "mkdir", "chmod", "ls", "grep", "stat",
    ];
    for name in plain {
        let found = ["/usr/bin", "/bin"].map(|folder| Path::new(folder).join(name));
        if let Some(place) = found.iter().find(|place| place.exists()) {
            std::os::unix::fs::symlink(place, commands.join(name)).unwrap();
        }
    }
    for (name, script) in has {
        let path = commands.join(name);
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        let runs = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        std::fs::set_permissions(&path, runs).unwrap();
    }
    let output = Command::new(commands.join("bash"))
        .arg("./x")
        .args(arguments)
        .current_dir(checkouts.path("one"))
        .env_clear()
        .env("PATH", &commands)
        .env("HOME", checkouts.path("home"))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    (
        output.status.success(),
        String::from_utf8(output.stderr).unwrap(),
    )
}

/// A compiler of C with its headers, or what the script takes for them, and the installer of Rust, which leaves a cargo that says
/// so and a rustc that is new.
const COMPILER: (&str, &str) = ("cc", "exit 0");
const INSTALLER: (&str, &str) = (
    "curl",
    "cat <<'END'\nmkdir -p \"$HOME/.cargo/bin\"\n\
     printf '#!/bin/sh\\necho built >&2\\n' > \"$HOME/.cargo/bin/cargo\"\n\
     printf '#!/bin/sh\\necho rustc 1.99.0\\n' > \"$HOME/.cargo/bin/rustc\"\n\
     chmod +x \"$HOME/.cargo/bin/cargo\" \"$HOME/.cargo/bin/rustc\"\nEND",
);

#[test]
fn where_rust_is_missing_the_official_installer_runs_only_after_a_yes() {
    if !Path::new("/usr/include/stdlib.h").exists() {
        return;
    }
    let has = [COMPILER, INSTALLER, ("sh", "exec bash \"$@\"")];
    let (done, said) = without_rust(&has, &["fmt"]);
    assert!(!done);
    assert!(said.contains("    curl --proto"), "{said}");
    assert!(said.contains("./x --yes fmt, which runs it"), "{said}");
    let (done, said) = without_rust(&has, &["--yes", "fmt"]);
    assert!(said.contains("built"), "{said}");
    assert!(done, "{said}");
}

#[test]
fn where_there_is_no_apt_the_command_of_the_system_is_named() {
    for (manager, named) in [
        ("dnf", "sudo dnf install gcc"),
        ("pacman", "sudo pacman -S --needed gcc"),
        ("brew", "xcode-select --install"),
        ("true", "the package is called gcc on Debian"),
    ] {
        let (done, said) = without_rust(&[(manager, "exit 0")], &["build"]);
        assert!(!done);
        assert!(said.contains(named), "{manager}: {said}");
    }
}
