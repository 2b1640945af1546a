//! The board's twin on the host: the same job over the same payload file.

use meniscus_bare_metal::{Place, Room, run};
use std::fmt;
use std::fs::File;
use std::io::{BufReader, Read};
use std::process::ExitCode;

/// The shipped model, where its weights can be read in place.
#[repr(align(64))]
struct Aligned<T: ?Sized>(T);
static BLOB: &Aligned<[u8]> = &Aligned(*include_bytes!("../../../../models/glycerine.blob"));

struct Host(BufReader<File>);

impl Place for Host {
    fn read(&mut self, into: &mut [u8]) -> bool {
        self.0.read_exact(into).is_ok()
    }

    fn line(&mut self, line: fmt::Arguments<'_>) {
        println!("{line}");
    }

    fn instructions() -> u64 {
        0
    }
}

fn main() -> ExitCode {
    let path = std::env::args().nth(1).unwrap_or_else(|| "payloads.bin".into());
    let file = match File::open(&path) {
        Ok(file) => file,
        Err(error) => {
            eprintln!("error: cannot read {path}: {error}");
            return ExitCode::FAILURE;
        }
    };
    match run(&mut Host(BufReader::new(file)), &BLOB.0, &mut Box::new(Room::new())) {
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:?}");
            ExitCode::FAILURE
        }
    }
}
