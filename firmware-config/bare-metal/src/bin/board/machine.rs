//! The machine below the job: reset, semihosting, a timer, the stack. The one file of `unsafe` for the board.
//!
//! The argument for soundness:
//!
//! 1. There is one core, one thread and no interrupt: nothing runs beside what is written here.
//! 2. [`room`] gives its reference once and ends the program at a second call: it is the only one to that static.
//! 3. A semihosting call stops the core while the debugger (QEMU) reads or writes the memory that its
//!    parameter block names; the blocks name buffers of this frame or of the caller, with their true length.
//! 4. The stack is painted by the reset handler below its own stack pointer, before any Rust code runs, and
//!    read again as bytes between two symbols of the linker script that lie in memory of nobody else.
//! 5. The timer's and the coprocessor's registers are those of the Application Notes 500 and of ARMv7-M.
#![allow(unsafe_code, reason = "registers, reset and semihosting; the argument stands above")]

use core::arch::{asm, global_asm};
use core::ptr::{addr_of, read_volatile, write_volatile};
use core::sync::atomic::{AtomicBool, Ordering};
use meniscus_bare_metal::Room;

unsafe extern "C" {
    /// Lowest address of the stack.
    static _stack_end: u32;
    /// Highest address of the stack.
    static _stack_start: u32;
}

/// Word that fills unused stack.
const PAINT: u32 = 0x5afe_5afe;

// Vector table; reset: floating point on (CPACR, full access to CP10 and CP11), stack painted, then the job.
global_asm!(
    ".section .vectors, \"a\"",
    ".word _stack_start",
    ".word reset",
    ".rept 14",
    ".word fault",
    ".endr",
    ".section .text.reset, \"ax\"",
    ".thumb_func",
    ".global reset",
    "reset:",
    "ldr r0, =0xe000ed88",
    "ldr r1, [r0]",
    "orr r1, r1, #0xf00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "ldr r0, =_stack_end",
    "mov r1, sp",
    "ldr r2, =0x5afe5afe",
    "1: cmp r0, r1",
    "bhs 2f",
    "str r2, [r0], #4",
    "b 1b",
    "2: bl begin",
    ".thumb_func",
    "fault:",
    "bl failed",
    ".ltorg",
);

#[unsafe(no_mangle)]
extern "C" fn begin() -> ! {
    start_timer();
    super::job::main()
}

#[unsafe(no_mangle)]
extern "C" fn failed() -> ! {
    Console::open().write(b"fault: the core took an exception\n");
    exit(false)
}

/// The buffers of the job. A second call ends the emulation: a second reference to them must not be.
pub(super) fn room() -> &'static mut Room {
    static mut ROOM: Room = Room::new();
    static GIVEN: AtomicBool = AtomicBool::new(false);
    // With one thread and no interrupt nothing comes between the two (1).
    if GIVEN.load(Ordering::Relaxed) {
        Console::open().write(b"the room of the job was taken twice\n");
        exit(false)
    }
    GIVEN.store(true, Ordering::Relaxed);
    // SAFETY: the flag lets one call come here, and nothing else names the static (2).
    unsafe { &mut *(&raw mut ROOM) }
}

/// Semihosting: operation and address of its parameter block.
///
/// # Safety
/// `block` has to be what the operation takes, and the memory that it names has to be the caller's to read, or to write, with the
/// length that it says.
unsafe fn call(operation: u32, block: *const u32) -> u32 {
    let answer;
    // SAFETY: the breakpoint is taken by the debugger, which keeps to the block (3).
    unsafe {
        asm!("bkpt 0xab", inout("r0") operation => answer, in("r1") block);
    }
    answer
}

fn open(name: &[u8], mode: u32) -> u32 {
    // The name ends with a zero that its length does not count.
    let block = [name.as_ptr() as u32, mode, name.len() as u32 - 1];
    // SAFETY: SYS_OPEN reads a name of this length (3).
    unsafe { call(0x01, block.as_ptr()) }
}

/// The payload file on the host.
#[derive(Debug)]
pub(super) struct File(u32);

impl File {
    pub(super) fn open() -> Self {
        Self(open(b"payloads.bin\0", 1))
    }

    /// Fills `into`; `false` when the file has ended before.
    pub(super) fn read(&mut self, into: &mut [u8]) -> bool {
        let block = [self.0, into.as_mut_ptr() as u32, into.len() as u32];
        // SAFETY: SYS_READ writes at most `into.len()` bytes into `into`, which is borrowed for writing (3).
        let missing = unsafe { call(0x06, block.as_ptr()) };
        // The answer is the number of bytes that did not come.
        missing == 0
    }
}

/// The debugger's console.
#[derive(Debug)]
pub(super) struct Console(u32);

impl Console {
    pub(super) fn open() -> Self {
        Self(open(b":tt\0", 4))
    }

    pub(super) fn write(&mut self, bytes: &[u8]) {
        let block = [self.0, bytes.as_ptr() as u32, bytes.len() as u32];
        // SAFETY: SYS_WRITE reads `bytes.len()` bytes (3).
        unsafe { call(0x05, block.as_ptr()) };
    }
}

/// Ends the emulation.
pub(super) fn exit(well: bool) -> ! {
    // ADP_Stopped_ApplicationExit, or a run time error.
    let reason = if well { 0x2_0026 } else { 0x2_0023 };
    // SAFETY: this operation takes a number and reads no memory.
    unsafe { call(0x18, reason as *const u32) };
    loop {}
}

/// Timer 0 of the board: control, value, reload. It counts down at 25 MHz.
const TIMER: *mut u32 = 0x4000_0000 as *mut u32;

/// Nanoseconds, and with one instruction a nanosecond also instructions, of a tick.
const TICK: u64 = 40;

fn start_timer() {
    // SAFETY: the registers of timer 0, used by nothing else (1, 5).
    unsafe {
        write_volatile(TIMER.add(2), u32::MAX);
        write_volatile(TIMER.add(1), u32::MAX);
        write_volatile(TIMER, 1);
    }
}

/// Instructions since the start, to 40, under `-icount shift=0`; for 171 s.
pub(super) fn instructions() -> u64 {
    // SAFETY: as above.
    let left = unsafe { read_volatile(TIMER.add(1)) };
    u64::from(u32::MAX - left) * TICK
}

/// Bytes of the stack that were ever used.
pub(super) fn stack_used() -> usize {
    let (mut at, top) = (addr_of!(_stack_end), addr_of!(_stack_start));
    // SAFETY: words between the two symbols, which are the stack's memory (4).
    while at < top && unsafe { read_volatile(at) } == PAINT {
        // SAFETY: at most the end of the same memory.
        at = unsafe { at.add(1) };
    }
    top as usize - at as usize
}
