//! Attacks on the Unix socket of `run --publish`: by its readers, and by files in its place.

use crate::support::{Scratch, blob, meniscus_command};
use meniscus::blob::Model;
use meniscus_service::publish::{Destination, Publisher, READERS_MAX};
use std::fs;
use std::io::Read;
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixStream;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Readers of the Unix socket cannot use up the descriptors of the process.
///
/// 300 readers that read nothing: 32 are kept, the others get one line that says why.
#[test]
fn silent_readers_do_not_use_up_descriptors() {
    let path = std::env::temp_dir().join(format!("meniscus-attack-{}.sock", std::process::id()));
    let bytes = blob();
    let header = Model::load(&bytes).expect("sound").header.clone();
    let (outlet, publisher) =
        Publisher::start(&[Destination::Unix(path.clone())], &header, 0.0, 0).expect("it opens");
    let mut readers: Vec<_> = (0..300)
        .map(|_| {
            let reader = UnixStream::connect(&path).expect("it listens");
            reader.set_read_timeout(Some(Duration::from_millis(500))).expect("a timeout");
            reader
        })
        .collect();
    let counters = std::sync::Arc::clone(&outlet.counters);
    let begun = Instant::now();
    let refused = || counters.readers_refused.load(Ordering::Relaxed) as usize;
    while refused() < 300 - READERS_MAX && begun.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(refused(), 300 - READERS_MAX);
    let mut words = String::new();
    readers[299].read_to_string(&mut words).expect("a line, then the end");
    assert!(words.contains("32 readers are connected, which is the limit"), "{words}");
    // Whoever goes makes room for another, although no record has found that out yet.
    readers.clear();
    let mut late = UnixStream::connect(&path).expect("it listens");
    late.set_read_timeout(Some(Duration::from_millis(300))).expect("a timeout");
    let kept = late.read(&mut [0; 16]).expect_err("kept, and no record comes").kind();
    assert!(matches!(kept, std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut), "{kept}");
    drop(outlet);
    publisher.finish();
}

/// A socket takes the place of no file.
///
/// A text, a link to a text, a link to nothing and a folder at the path of `--publish unix:`.
#[test]
fn a_socket_takes_the_place_of_no_file() {
    let scratch = Scratch::new("socket");
    let at = |name: &str| scratch.0.join(name);
    fs::write(at("text"), "kept").expect("written");
    fs::create_dir(at("folder")).expect("a folder");
    symlink(at("text"), at("link")).expect("a link");
    symlink(at("nowhere"), at("dangling")).expect("a link");
    for name in ["text", "link", "dangling", "folder"] {
        let output = meniscus_command()
            .args(["run", "--patient", "--seconds", "1.5", "--publish"])
            .arg(format!("unix:{}", at(name).display()))
            .current_dir(&scratch.0)
            .output()
            .expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains("no socket lies there"), "{name}: {said}");
    }
    assert_eq!(fs::read(at("text")).expect("readable"), b"kept");
    assert_eq!(fs::read_link(at("link")).expect("a link"), at("text"));
    assert!(fs::read_link(at("dangling")).is_ok() && !at("nowhere").exists() && at("folder").is_dir());
}
