//! Load on the machine: threads that keep processors, memory or a disk busy until a flag ends them.
//!
//! Each counts its own work, so that a load that did nothing does not pass for one.

use std::fs::File;
use std::hint::black_box;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Bytes that the memory's load copies to and fro: more than a cache next to a core holds.
const COPIED: usize = 64 << 20;

/// Bytes of the file that the disk's load writes, syncs and writes again.
const WRITTEN: usize = 64 << 20;

/// Bytes of one write.
const BLOCK: usize = 1 << 20;

/// One kind of load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// A thread a processor that computes.
    Cpu,
    /// A thread that copies 64 MiB to and fro.
    Memory,
    /// A thread that writes a file of 64 MiB and syncs it, again and again.
    Disk,
}

impl Load {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Cpu, Self::Memory, Self::Disk];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Memory => "memory",
            Self::Disk => "disk",
        }
    }
}

/// Work that the loads have done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pressed {
    /// Threads that computed.
    pub spinning: usize,
    /// Read and written in memory, GB/s.
    pub copied_gb_s: f64,
    /// Written and synced, MB/s.
    pub written_mb_s: f64,
    /// Why the disk's load ended early.
    pub failed: Option<String>,
}

/// Presses until `ended`. The disk's file lies in `folder` and is removed.
pub fn press(loads: &[Load], folder: &Path, ended: &AtomicBool) -> Pressed {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let has = |load| loads.contains(&load);
    let mut pressed = Pressed::default();
    std::thread::scope(|scope| {
        if has(Load::Cpu) {
            pressed.spinning = processors;
            (0..processors).for_each(|seed| drop(scope.spawn(move || compute(seed as u64, ended))));
        }
        let memory = has(Load::Memory).then(|| scope.spawn(|| copy(ended)));
        let disk = has(Load::Disk).then(|| scope.spawn(|| write(&folder.join("deadline.load"), ended)));
        pressed.copied_gb_s = memory.and_then(|copy| copy.join().ok()).unwrap_or(0.0);
        match disk.and_then(|write| write.join().ok()) {
            Some(Ok(rate)) => pressed.written_mb_s = rate,
            Some(Err(error)) => pressed.failed = Some(format!("{}: {error}", folder.display())),
            None => {}
        }
    });
    pressed
}

/// Numbers without end (xorshift of Marsaglia 2003).
fn compute(seed: u64, ended: &AtomicBool) {
    let mut x = seed + 88_172_645_463_325_252;
    while !ended.load(Ordering::Relaxed) {
        for _ in 0..10_000 {
            x ^= x << 13;
            x ^= x >> 7;
            x ^= x << 17;
        }
        black_box(x);
    }
}

/// Copies without end, once at least; read and written, GB/s.
fn copy(ended: &AtomicBool) -> f64 {
    let (mut one, mut other) = (vec![1_u8; COPIED], vec![2_u8; COPIED]);
    let (begun, mut bytes) = (Instant::now(), 0.0);
    loop {
        black_box(&mut other).copy_from_slice(black_box(&one));
        std::mem::swap(&mut one, &mut other);
        bytes += 2.0 * COPIED as f64;
        if ended.load(Ordering::Relaxed) {
            return 1e-9 * bytes / begun.elapsed().as_secs_f64();
        }
    }
}

/// Writes and syncs without end, a block at least; MB/s.
fn write(path: &Path, ended: &AtomicBool) -> io::Result<f64> {
    let (block, begun, mut bytes) = (vec![7_u8; BLOCK], Instant::now(), 0.0);
    let mut round = || {
        let mut file = File::create(path)?;
        for _ in 0..WRITTEN / BLOCK {
            file.write_all(&block)?;
            bytes += BLOCK as f64;
            if ended.load(Ordering::Relaxed) {
                break;
            }
        }
        file.sync_all()
    };
    let mut done = round();
    while done.is_ok() && !ended.load(Ordering::Relaxed) {
        done = round();
    }
    // Never made, or removed by somebody else: gone either way.
    let _gone = std::fs::remove_file(path);
    done.map(|()| 1e-6 * bytes / begun.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn press_shortly(loads: &[Load], folder: &Path) -> Pressed {
        let ended = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let pressed = scope.spawn(|| press(loads, folder, &ended));
            std::thread::sleep(Duration::from_millis(200));
            ended.store(true, Ordering::Relaxed);
            pressed.join().expect("it ended")
        })
    }

    #[test]
    fn every_load_tells_what_it_did_and_leaves_nothing_behind() {
        let folder = std::env::temp_dir().join(format!("meniscus-load-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let pressed = press_shortly(&Load::ALL, &folder);
        assert!(
            pressed.spinning > 0 && pressed.copied_gb_s > 0.0 && pressed.written_mb_s > 0.0,
            "{pressed:?}"
        );
        assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 0);
        std::fs::remove_dir(&folder).expect("it is empty");
        let pressed = press_shortly(&[Load::Disk], &folder);
        assert!(
            pressed.failed.is_some_and(|why| why.contains("meniscus-load")),
            "a folder that is not there is reported"
        );
        assert_eq!(press_shortly(&[], &folder), Pressed::default());
    }
}
