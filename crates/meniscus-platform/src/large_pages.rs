//! Large pages for what is read from end to end in every turn.
//!
//! A blob of 20 MB lies in 5000 pages of 4 KiB, more than a core remembers the places of; each that it has forgotten
//! costs it a walk through the page table, on a virtual machine through two. Of 2 MiB it is ten.
#![allow(
    unsafe_code,
    reason = "the kernel is advised about memory by address; the argument stands at the call"
)]

use rustix::mm::{Advice, madvise};

/// Bytes of a large page on x86-64, and on 64-bit Arm with pages of 4 KiB. Where it is another, less is gained.
pub const LARGE_PAGE: usize = 2 << 20;

/// Asks the system to back the whole large pages within `memory` by such. Worth it only before they are first written
/// to; a system that has none to give goes on with small ones.
pub fn ask_for(memory: &mut [u8]) {
    let start = memory.as_ptr().align_offset(LARGE_PAGE);
    let Some(within) = memory.get_mut(start..) else { return };
    let length = within.len() - within.len() % LARGE_PAGE;
    if length == 0 {
        return;
    }
    // SAFETY: the range lies within one exclusively borrowed slice, and this advice changes no byte of it and no right
    // to it, only the size of the pages behind.
    let asked = unsafe { madvise(within.as_mut_ptr().cast(), length, Advice::LinuxHugepage) };
    // Refused where the kernel was built without them: nothing is lost but speed.
    let _small = asked;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_stay_what_they_are_wherever_the_slice_begins() {
        let mut memory: Vec<u8> = (0..3 * LARGE_PAGE + 77).map(|k| (k % 251) as u8).collect();
        for start in [0, 1, LARGE_PAGE, 3 * LARGE_PAGE + 77] {
            ask_for(&mut memory[start..]);
        }
        assert!(memory.iter().enumerate().all(|(k, byte)| *byte == (k % 251) as u8));
    }
}
