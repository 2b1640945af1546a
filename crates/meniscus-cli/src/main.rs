//! The program `meniscus`.

use meniscus_platform::allocations::CountingAllocator;
use std::process::ExitCode;

/// Counts the allocations of the worker's turns: none.
#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

fn main() -> ExitCode {
    meniscus_cli::main()
}
