//! Does nothing: a package with dependencies of a build has one.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
}
