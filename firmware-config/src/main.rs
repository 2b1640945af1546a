//! Link proof: storey 1 from blob to field, in a program that has no allocator to link against, and
//! whose panic handler needs a symbol that does not exist.
//!
//! If anything on the way allocates, the linker misses `__rust_alloc`. If any path can panic, the
//! handler stays in the program and the linker misses `a_panic_path_is_left_in_storey_1`.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;
use meniscus::model::Model;
use meniscus::runtime::{Clock, Estimator, Memory};

unsafe extern "C" {
    /// Defined nowhere.
    safe fn a_panic_path_is_left_in_storey_1() -> !;
}

/// Reached by no path of a program that links.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    a_panic_path_is_left_in_storey_1()
}

/// A clock as a board would have it: a counter.
struct Ticks(u64);

impl Clock for Ticks {
    fn now_us(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(1);
        black_box(self.0)
    }
}

/// The main job on bytes that the compiler cannot see through. Linked, never run.
// SAFETY: the only symbol of that name; the linker's entry point, called by nobody else.
#[unsafe(no_mangle)]
pub extern "C" fn _start() -> ! {
    let blob: &[u8] = black_box(&[]);
    let mut numbers = [0.0; 16];
    let field: &mut [f32] = black_box(&mut numbers);
    let mut clock = Ticks(0);
    match Model::load(blob) {
        Ok(model) => {
            let estimator = Estimator::new(&model);
            let mut memory = Memory::default();
            loop {
                let profile = black_box(None);
                black_box(estimator.turn(&mut memory, profile, 0, &mut clock, field));
            }
        }
        Err(error) => loop {
            black_box(error);
        },
    }
}
