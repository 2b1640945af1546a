//! Estimates of a run in one file: a column for each number of a packet, in safetensors as a recording is.
//!
//! | tensor | type, shape | |
//! |---|---|---|
//! | `number` | U64, N | number of the packet |
//! | `camera_us` | U64, N | instant of the turn on the camera's clock, mid-exposure |
//! | `sequence` | I64, N | frame counter of the camera; -1 where the frame was lost |
//! | `host_unix_ns`, `host_std_ns`, `latency_us` | U64, N | the instant on the host's clock, its standard deviation, latency to the end of the turn; zeros where it is not known |
//! | `mode` | U8, N | 0 Filling, 1 Tracking, 2 Coasting, 3 Halted |
//! | `latent`, `covariance` | F64, N x 13; F32, N x 91 | reduced state and the lower triangle of its error covariance |
//! | `surface_m`, `surface_half_m` | F32, N x 21 | heights and their half-widths with 90 % coverage |
//! | `group_half` | F32, N x 5 | half-width of one number of q, v, e, sigma, tau, SI units |
//! | `acceleration_m_s2`, `port` | F32, N | acceleration of the glass, input of the decoder |
//! | `energy_j` | F64, N x 3 | slosh energy, heat, energy of the correction |
//! | `audit` | F64, N x 3 | work, heat, residual of the step in units of H |
//!
//! Metadata: `format` = `meniscus estimates 2`; `model_version`, `known` and `command` as JSON. The version is that of the
//! recordings. The full field is decoded from these numbers with the blob of the run.

use super::StoreError;
use super::groups::{groups, names};
use super::tensors::{FileText, Tensor, f32s, f64s, i64s, read_file, serialize, typed, u64s};
use meniscus::blob::KnownGroups;
use meniscus::latent::generic::LATENTS;
use meniscus::runtime::Mode;
use meniscus::runtime::output::{HostTime, Packet};
use meniscus::surface::POINTS;
use meniscus::uncertainty::latent_covariance::COVARIANCE_ENTRIES;
use meniscus_platform::files::write_whole;
use safetensors::tensor::{Dtype, SafeTensors};
use std::collections::HashMap;
use std::path::Path;

/// Name of this format in the metadata.
const FORMAT: &str = "meniscus estimates 2";

/// Estimates of a run; every array has one row a turn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EstimateRecording {
    /// Command of the run.
    pub command: String,
    /// Version of its model.
    pub model_version: u64,
    /// Field groups that the model is valid for.
    pub known: KnownGroups,
    /// Number of the packet.
    pub number: Vec<u64>,
    /// Instant of the turn on the camera's clock, microseconds.
    pub camera_us: Vec<u64>,
    /// Frame counter of the camera; -1 where the frame was lost.
    pub sequence: Vec<i64>,
    /// Instant on the host's clock; `None` where it is not known.
    pub host: Vec<Option<HostTime>>,
    /// Mode as in a packet: 0 Filling, 1 Tracking, 2 Coasting, 3 Halted.
    pub mode: Vec<u8>,
    /// Reduced state, N x 13.
    pub latent: Vec<f64>,
    /// Lower triangle of its error covariance, N x 91.
    pub covariance: Vec<f32>,
    /// Heights of the surface, m, N x 21.
    pub surface_m: Vec<f32>,
    /// Their half-widths with 90 % coverage, m, N x 21.
    pub surface_half_m: Vec<f32>,
    /// Half-width of one number of each field group, SI units, N x 5.
    pub group_half: Vec<f32>,
    /// Acceleration of the glass that entered the step, m/s2.
    pub acceleration_m_s2: Vec<f32>,
    /// Input of the decoder.
    pub port: Vec<f32>,
    /// Slosh energy, heat and energy of the correction, J, N x 3.
    pub energy_j: Vec<f64>,
    /// Work, heat and residual of the step in units of H, N x 3.
    pub audit: Vec<f64>,
}

impl EstimateRecording {
    /// Returns a file's content for `packets` of one run, made by `command`.
    #[must_use]
    pub fn of(packets: &[Packet], command: &str) -> Self {
        let mut out = Self { command: command.into(), ..Self::default() };
        if let Some(first) = packets.first() {
            (out.model_version, out.known) = (first.model_version, first.known);
        }
        packets.iter().for_each(|packet| out.push(packet));
        out
    }

    fn push(&mut self, packet: &Packet) {
        let estimate = &packet.estimate;
        self.number.push(packet.number);
        self.camera_us.push(packet.time.0);
        self.sequence.push(packet.sequence.map_or(-1, i64::from));
        self.host.push(packet.host);
        self.mode.push(match estimate.mode {
            Mode::Filling => 0,
            Mode::Tracking => 1,
            Mode::Coasting => 2,
            Mode::Halted => 3,
        });
        self.latent.extend_from_slice(&estimate.latent);
        self.covariance.extend_from_slice(estimate.covariance.packed());
        self.surface_m.extend_from_slice(&estimate.surface_m);
        self.surface_half_m.extend_from_slice(&estimate.interval.surface_m);
        self.group_half.extend_from_slice(&estimate.interval.field);
        self.acceleration_m_s2.push(estimate.acceleration_m_s2);
        self.port.push(estimate.port);
        self.energy_j.extend([estimate.slosh_j, estimate.heat_j, estimate.corrected_j]);
        let audit = &estimate.audit;
        self.audit.extend([audit.work, audit.heat, audit.energy_residual]);
    }

    /// Number of turns.
    #[must_use]
    pub fn turns(&self) -> usize {
        self.number.len()
    }

    /// Writes the estimates to `path`, whole or not at all.
    ///
    /// # Errors
    /// When the file system says no.
    pub fn save(&self, path: &Path) -> Result<(), StoreError> {
        let bytes = self.to_bytes().map_err(|why| StoreError::Malformed(path.into(), why))?;
        write_whole(path, &bytes).map_err(|error| StoreError::Io(error.path, error.cause))
    }

    /// Reads the estimates at `path`; every type and shape is checked.
    ///
    /// # Errors
    /// When the file cannot be read or does not hold whole estimates.
    pub fn load(path: &Path) -> Result<Self, StoreError> {
        let bytes = read_file(path).map_err(|e| StoreError::Io(path.into(), e))?;
        parse(&bytes).map_err(|why| StoreError::Malformed(path.into(), why))
    }

    fn to_bytes(&self) -> Result<Vec<u8>, String> {
        let n = self.turns();
        let host = |part: fn(HostTime) -> u64| self.host.iter().map(move |host| host.map_or(0, part));
        let tensors = [
            Tensor::u64("number", &[n], self.number.iter().copied()),
            Tensor::u64("camera_us", &[n], self.camera_us.iter().copied()),
            Tensor::i64("sequence", &[n], self.sequence.iter().copied()),
            Tensor::u64("host_unix_ns", &[n], host(|host| host.unix_ns)),
            Tensor::u64("host_std_ns", &[n], host(|host| host.std_ns)),
            Tensor::u64("latency_us", &[n], host(|host| host.latency_us)),
            Tensor::u8("mode", &[n], self.mode.iter().copied()),
            Tensor::f64("latent", &[n, LATENTS], self.latent.iter().copied()),
            Tensor::f32("covariance", &[n, COVARIANCE_ENTRIES], &self.covariance),
            Tensor::f32("surface_m", &[n, POINTS], &self.surface_m),
            Tensor::f32("surface_half_m", &[n, POINTS], &self.surface_half_m),
            Tensor::f32("group_half", &[n, 5], &self.group_half),
            Tensor::f32("acceleration_m_s2", &[n], &self.acceleration_m_s2),
            Tensor::f32("port", &[n], &self.port),
            Tensor::f64("energy_j", &[n, 3], self.energy_j.iter().copied()),
            Tensor::f64("audit", &[n, 3], self.audit.iter().copied()),
        ];
        let known = serde_json::to_string(&names(self.known)).map_err(|e| format!("{e}"))?;
        let text = [
            ("format", FORMAT.to_owned()),
            ("model_version", self.model_version.to_string()),
            ("known", known),
            ("command", self.command.clone()),
        ];
        serialize(
            &tensors,
            text.into_iter().map(|(key, value)| (key.to_owned(), value)).collect::<HashMap<_, _>>(),
        )
    }
}

/// The estimates in the bytes of a file.
fn parse(bytes: &[u8]) -> Result<EstimateRecording, String> {
    let text = FileText::read(bytes)?;
    let format = text.get("format")?;
    if format != FORMAT {
        let earlier = format.starts_with(FORMAT.trim_end_matches(|c: char| c.is_ascii_digit()));
        let remedy = if earlier { "; make it again with `meniscus run --estimates`" } else { "" };
        return Err(format!("its format is '{format}', expected '{FORMAT}'{remedy}"));
    }
    let file = SafeTensors::deserialize(bytes).map_err(|e| format!("{e}"))?;
    let number = u64s(&file, "number", None)?;
    let n = number.len();
    let column = |name: &str| u64s(&file, name, Some(&[n]));
    let (unix_ns, std_ns, latency_us) =
        (column("host_unix_ns")?, column("host_std_ns")?, column("latency_us")?);
    let host = unix_ns.into_iter().zip(std_ns).zip(latency_us).map(|((unix_ns, std_ns), latency_us)| {
        (unix_ns > 0).then_some(HostTime { unix_ns, std_ns, latency_us })
    });
    Ok(EstimateRecording {
        command: text.get("command")?.into(),
        model_version: text.get("model_version")?.parse().map_err(|e| format!("model_version: {e}"))?,
        known: groups(text.get("known")?)?,
        camera_us: column("camera_us")?,
        sequence: i64s(&file, "sequence", Some(&[n]))?,
        host: host.collect(),
        mode: typed(&file, "mode", Dtype::U8, Some(&[n]))?.to_vec(),
        latent: f64s(&file, "latent", Some(&[n, LATENTS]))?,
        covariance: f32s(&file, "covariance", Some(&[n, COVARIANCE_ENTRIES]))?,
        surface_m: f32s(&file, "surface_m", Some(&[n, POINTS]))?,
        surface_half_m: f32s(&file, "surface_half_m", Some(&[n, POINTS]))?,
        group_half: f32s(&file, "group_half", Some(&[n, 5]))?,
        acceleration_m_s2: f32s(&file, "acceleration_m_s2", Some(&[n]))?,
        port: f32s(&file, "port", Some(&[n]))?,
        energy_j: f64s(&file, "energy_j", Some(&[n, 3]))?,
        audit: f64s(&file, "audit", Some(&[n, 3]))?,
        number,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::Model;
    use meniscus::runtime::{Estimator, Memory, Turn, TurnInput};
    use meniscus::units::Micros;
    use meniscus_platform::clock::NoClock;
    use meniscus_platform::files::AlignedBytes;

    /// Packets of a run without frames; every second one has a host time.
    fn packets() -> Vec<Packet> {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let (estimator, mut memory) = (Estimator::new(&model), Memory::default());
        let packet = |n: u64| {
            let estimate = estimator.turn(&mut memory, TurnInput::default(), &mut NoClock, &mut []);
            let turn = Turn { time: Micros(16_667 * n), stamp: None, profile: None, estimate };
            let host = (n % 2 == 1).then_some(HostTime { unix_ns: 5 + n, std_ns: 7, latency_us: 9 });
            Packet { host, ..Packet::of(&turn, n, &model.header) }
        };
        (0..5).map(packet).collect()
    }

    #[test]
    fn a_file_gives_the_same_estimates() {
        let packets = packets();
        let estimates = EstimateRecording::of(&packets, "meniscus run");
        let path =
            std::env::temp_dir().join(format!("meniscus-estimates-{}.safetensors", std::process::id()));
        estimates.save(&path).expect("written");
        let loaded = EstimateRecording::load(&path).expect("read");
        std::fs::remove_file(&path).expect("removed");
        assert_eq!(loaded, estimates);
        assert_eq!((loaded.turns(), loaded.sequence[0], loaded.host[1]), (5, -1, packets[1].host));
        assert_eq!(loaded.covariance[91..182], packets[1].estimate.covariance.packed()[..]);
    }

    #[test]
    fn a_recording_of_another_kind_is_refused_by_name() {
        let bytes =
            serialize(&[], HashMap::from([("format".into(), "meniscus recording 2".into())])).expect("bytes");
        let why = parse(&bytes).expect_err("no estimates");
        assert_eq!(why, "its format is 'meniscus recording 2', expected 'meniscus estimates 2'");
        let bytes =
            serialize(&[], HashMap::from([("format".into(), "meniscus estimates 1".into())])).expect("bytes");
        let why = parse(&bytes).expect_err("an earlier version");
        assert!(why.ends_with("make it again with `meniscus run --estimates`"), "{why}");
    }
}
