//! All tests of the runner.
