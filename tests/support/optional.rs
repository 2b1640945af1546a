//! Tests that need a program or a processor that a machine may lack.

/// Prints why a test is skipped. Where the environment variable `CI` is set, that is a failure: nothing may be missing
/// there.
#[track_caller]
pub(crate) fn skip(why: &str) {
    assert!(std::env::var_os("CI").is_none(), "no test may be skipped in CI: {why}");
    eprintln!("skipped: {why}");
}
