//! `--motion`: who tells how the glass moves.

use super::Arguments;
use anyhow::{Context, ensure};
use meniscus_service::commanded_motion::Told;
use std::net::ToSocketAddrs;
use std::time::Duration;

/// Whoever tells, for a run of this length; nobody without --motion.
pub(super) fn told(arguments: &Arguments, length: Duration) -> anyhow::Result<Option<Told>> {
    let Some(source) = arguments.motion.as_deref() else { return Ok(None) };
    match source.strip_prefix("udp:") {
        Some(address) => by_wire(arguments, address).map(Some),
        None => by_table(arguments, source, length).map(Some),
    }
}

fn by_wire(arguments: &Arguments, address: &str) -> anyhow::Result<Told> {
    let lag_ms = arguments.motion_lag_ms;
    ensure!((0.0..=100.0).contains(&lag_ms), "--motion-lag-ms {lag_ms} is out of range: 0 to 100");
    let unknown = || format!("--motion udp:{address}: expected udp:HOST:PORT, as udp:127.0.0.1:9000");
    let found = address.to_socket_addrs().with_context(unknown)?.next().with_context(unknown)?;
    Told::by_wire(found, 1e-3 * lag_ms)
        .with_context(|| format!("--motion udp:{address} cannot be listened to"))
}

#[cfg(not(feature = "studies"))]
fn by_table(_: &Arguments, source: &str, _: Duration) -> anyhow::Result<Told> {
    anyhow::bail!(
        "--motion {source} cannot be read: this program was built without the simulator, which knows motions; from the \
         repository: cargo run --release -- run --motion {source}"
    )
}

#[cfg(feature = "studies")]
fn by_table(arguments: &Arguments, source: &str, length: Duration) -> anyhow::Result<Told> {
    use meniscus_data::motion::Motion;

    /// Steps of a table that are looked at before it is believed, a second.
    const LOOKS_HZ: f64 = 50.0;
    /// How far the glass may leave the line along x, m: what a hand does; the model makes nothing of it.
    const BESIDE_M: f64 = 0.010;

    let seconds = length.as_secs_f64();
    let motion = match source {
        "truth" => of_recording(arguments)?,
        table => Motion::parse(table, seconds).with_context(|| format!("--motion {table}"))?,
    };
    // Behind its end a table tells nothing, and the edges of the glass do.
    let seconds = seconds.min(motion.end_s());
    for time_s in (0..(seconds * LOOKS_HZ) as u64).map(|k| k as f64 / LOOKS_HZ) {
        let [away_m, height_m, tilt_rad] = [motion.away(time_s), motion.height(time_s), motion.tilt(time_s)];
        ensure!(
            away_m.abs() <= BESIDE_M && height_m == 0.0 && tilt_rad == 0.0,
            "--motion {source}: at {time_s:.2} s the glass is {away_m:.4} m beside its line, lifted by {height_m:.4} m and \
             inclined by {tilt_rad:.4} rad; the model knows motion along x alone, and bears {BESIDE_M} m beside it"
        );
    }
    Ok(Told::by_table(seconds, |time_s| motion.acceleration(time_s.max(0.0))))
}

/// The motion that the simulated camera's recording was made with.
#[cfg(feature = "studies")]
fn of_recording(arguments: &Arguments) -> anyhow::Result<meniscus_data::motion::Motion> {
    let source = match arguments.source.as_str() {
        name if name.starts_with("simulated-usb") => "shipped",
        name @ ("usb" | "replay") => {
            anyhow::bail!("--motion truth is for a simulated camera: {name} has none")
        }
        file => file,
    };
    let recording = super::recording(source)?;
    let places: Vec<(f64, f64)> =
        (0..).map(|frame| f64::from(frame) / 60.0).zip(recording.glass_x_m.iter().copied()).collect();
    meniscus_data::motion::Motion::sampled(&places).context("the recording has no motion")
}
