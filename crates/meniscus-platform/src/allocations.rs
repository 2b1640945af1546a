//! Counts the allocations of each thread, so that "the turn allocates nothing" is a measurement.
//!
//! The one file of `unsafe` for this need: a global allocator can only be written with it.
#![allow(unsafe_code, reason = "GlobalAlloc is an unsafe trait; the argument stands at the impl")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

std::thread_local! {
    /// Allocations of this thread. A `const` start needs no allocation of its own.
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator with a counter a thread. Make it the program's `#[global_allocator]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct CountingAllocator;

/// Allocations and reallocations of the calling thread so far; zero for ever in a program whose
/// global allocator is another one.
#[must_use]
pub fn allocations_of_this_thread() -> u64 {
    COUNT.try_with(Cell::get).unwrap_or(0)
}

/// A thread on its way out has no counter any more, and its allocations are nobody's concern.
fn count() {
    let _gone = COUNT.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: every call is handed on unchanged to `System`, which keeps the contract of `GlobalAlloc`;
// counting touches a thread-local cell only and does not allocate, so it cannot recurse.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise about `layout` is the one that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System` with this `layout`, as all of ours do.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        count();
        // SAFETY: as for `dealloc`, and the caller's promise about `new_size` is handed on.
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}
