//! The job on an MPS2 board with a Cortex-M7 (QEMU's mps2-an500): payloads by semihosting, lines to its
//! console, instructions by a timer. At the end: what the turns cost, and how much of the stack was used.
#![no_std]
#![no_main]

#[cfg(target_os = "none")]
mod machine;

#[cfg(target_os = "none")]
mod job {
    use super::machine::{self, Console, File};
    use core::fmt;
    use core::panic::PanicInfo;
    use meniscus_bare_metal::{Done, Line, Place, run};

    /// The shipped model, where its weights can be read in place.
    #[repr(align(64))]
    struct Aligned<T: ?Sized>(T);
    static BLOB: &Aligned<[u8]> = &Aligned(*include_bytes!("../../../../../models/glycerine.blob"));

    struct Board {
        file: File,
        console: Console,
    }

    impl Place for Board {
        fn read(&mut self, into: &mut [u8]) -> bool {
            self.file.read(into)
        }

        fn line(&mut self, line: fmt::Arguments<'_>) {
            self.console.write(Line::of(format_args!("{line}\n")).bytes());
        }

        fn instructions() -> u64 {
            machine::instructions()
        }
    }

    #[panic_handler]
    fn panic(info: &PanicInfo<'_>) -> ! {
        Console::open().write(Line::of(format_args!("panic: {info}\n")).bytes());
        machine::exit(false)
    }

    /// Called by the reset handler with a painted stack.
    pub(super) fn main() -> ! {
        let mut board = Board { file: File::open(), console: Console::open() };
        let done = run(&mut board, &BLOB.0, machine::room());
        match done {
            Ok(done) => {
                let Done { turns, tracked, all, completing, longest, frames, tracking, stages } = done;
                let (turns, tracked) = (u64::from(turns).max(1), u64::from(tracked).max(1));
                board.line(format_args!(
                    "stages surface {} predict {} correct {} encode {} field {} frame {}",
                    stages.surface_us / tracked,
                    stages.predict_us / tracked,
                    stages.correct_us / tracked,
                    stages.encode_us / tracked,
                    stages.field_us / tracked,
                    tracking / u64::from(frames).max(1),
                ));
                board.line(format_args!(
                    "board instructions_per_turn {} longest {longest} stack_bytes {} per_frame {}",
                    completing / turns,
                    machine::stack_used(),
                    all / turns,
                ));
            }
            Err(error) => board.line(format_args!("error: {error:?}")),
        }
        machine::exit(done.is_ok())
    }
}

/// The same name built for a machine with a system does nothing: there is no board.
#[cfg(not(target_os = "none"))]
mod elsewhere {
    #[unsafe(no_mangle)]
    extern "C" fn main() -> i32 {
        1
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {}
    }
}
