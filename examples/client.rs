//! Reads estimates from `meniscus run --publish unix:PATH` and prints the highest point of the surface.
//!
//! ```sh
//! cargo run --release -- run --publish unix:/tmp/meniscus.sock &
//! cargo run --release -p meniscus-examples --example client -- /tmp/meniscus.sock
//! ```

use meniscus::runtime::output::{OUTPUT_VERSION, Packet};
use std::io::{BufRead, BufReader};
use std::os::unix::net::UnixStream;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: client PATH_OF_THE_SOCKET")?;
    let mut stream = BufReader::new(UnixStream::connect(&path).map_err(|e| format!("{path}: {e}"))?);
    let mut record = Vec::new();
    while stream.read_until(0, &mut record)? > 0 {
        // Takes the stuffing out in place. A record that is torn is no packet, and the next one is whole.
        if let Ok(packet) = postcard::from_bytes_cobs::<Packet>(&mut record)
            && packet.version == OUTPUT_VERSION
        {
            let estimate = &packet.estimate;
            let points = estimate.surface_m.iter().zip(&estimate.interval.surface_m);
            let highest =
                points.max_by(|a, b| a.0.total_cmp(b.0)).map_or((0.0, 0.0), |(z, half)| (*z, *half));
            let seconds = packet.time.0 as f64 * 1e-6;
            let latency = packet.host.map_or(String::new(), |host| {
                format!(", {:.1} ms after mid-exposure", 1e-3 * host.latency_us as f64)
            });
            println!(
                "{:6} {seconds:9.3} s {:?} highest {:.1} mm +- {:.1} mm{latency}",
                packet.number,
                estimate.mode,
                1e3 * highest.0,
                1e3 * highest.1
            );
        }
        record.clear();
    }
    Ok(())
}
