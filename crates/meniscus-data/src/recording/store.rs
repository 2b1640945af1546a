//! Recordings on disk: one safetensors file. It is typed, named, memory-mappable, opened by one call
//! from Python, refused as a whole when malformed, and carries the provenance as JSON text.
//!
//! | tensor | type, shape | |
//! |---|---|---|
//! | `glass_x_m`, `acceleration_m_s2` | F64, N | motion of the glass |
//! | `glass_y_m`, `glass_z_m`, `tilt_rad` | F64, N | its motion away from the camera and upwards, its inclination; zero where they lack |
//! | `column_m`, `wall_m`, `profile_m` | F32, N x 194, 72, 21 | free surface |
//! | `energy_j` | F64, N x 4 | kinetic, potential, internal, work |
//! | `spilled_m3`, `spilled_j` | F64, N | volume and energy that left over the rim; zero where they lack |
//! | `state` | F32, N x 27742 | full states, or instead of it: |
//! | `reference`, `truncation` | F32, 27742 and 5 | rest state; error by group |
//! | `q.coefficients`, `q.scale`, ... | F16 N x r, F32 r | by group: coefficients, their largest by mode |
//! | `q.strong`, `q.weak`, ... | F16 s x width, I8 (r - s) x width | modes; weak ones in steps of 1/127 |
//!
//! Metadata: `format` = `meniscus recording 2`; `glass`, `provenance` and `known` as JSON. `known` lists the groups of the
//! state that are of this liquid, `["q", "v", "e", "sigma", "tau", "surface"]` in a simulation. Version 1 had no `known`.

use super::groups::{groups, names};
use super::tensors::{FileText, Tensor, f16s, f32s, f64s, read_file, rows, serialize, typed};
use super::{
    COLUMNS, EnergyBook, Factored, GROUP_NAMES, Glass, Provenance, Recording, STATE, States, WALL_POINTS,
    group_range,
};
use meniscus::blob::KnownGroups;
use meniscus::surface::POINTS;
use meniscus_platform::files::write_whole;
use safetensors::tensor::{Dtype, SafeTensors};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Name of this format in the metadata.
const FORMAT: &str = "meniscus recording 2";
/// Name of the format without `known`, which is read too.
const FORMAT_1: &str = "meniscus recording 1";

/// Why a recording could not be read or written.
#[derive(Debug)]
pub enum StoreError {
    /// The file system said no.
    Io(PathBuf, std::io::Error),
    /// The file is not a recording, or a broken one.
    Malformed(PathBuf, String),
}

impl std::fmt::Display for StoreError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Io(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Malformed(path, why) => write!(f, "{} is not a recording: {why}", path.display()),
        }
    }
}

impl std::error::Error for StoreError {}

impl Recording {
    /// Writes the recording to `path`, whole or not at all.
    ///
    /// # Errors
    /// When the file system says no.
    pub fn save(&self, path: &Path) -> Result<(), StoreError> {
        let bytes = self.to_bytes().map_err(|why| StoreError::Malformed(path.into(), why))?;
        write_whole(path, &bytes).map_err(|error| StoreError::Io(error.path, error.cause))
    }

    /// Reads the recording at `path`; every type and shape is checked.
    ///
    /// # Errors
    /// When the file cannot be read or is not a whole recording.
    pub fn load(path: &Path) -> Result<Self, StoreError> {
        let bytes = read_file(path).map_err(|e| StoreError::Io(path.into(), e))?;
        Self::from_bytes(path, &bytes)
    }

    /// Reads a recording that is in memory already; `origin` names it in errors.
    ///
    /// # Errors
    /// When the bytes are not a whole recording.
    pub fn from_bytes(origin: &Path, bytes: &[u8]) -> Result<Self, StoreError> {
        parse(bytes).map_err(|why| StoreError::Malformed(origin.into(), why))
    }

    fn to_bytes(&self) -> Result<Vec<u8>, String> {
        let metadata = HashMap::from([
            ("format".to_owned(), FORMAT.to_owned()),
            ("known".to_owned(), serde_json::to_string(&names(self.known)).map_err(|e| format!("{e}"))?),
            ("glass".to_owned(), serde_json::to_string(&self.glass).map_err(|e| format!("{e}"))?),
            ("provenance".to_owned(), serde_json::to_string(&self.provenance).map_err(|e| format!("{e}"))?),
        ]);
        serialize(&self.tensors(), metadata)
    }

    fn tensors(&self) -> Vec<Tensor> {
        let n = self.frames();
        let energy = self.energy.iter().flat_map(|b| [b.kinetic, b.potential, b.internal, b.work]);
        let mut tensors = vec![
            Tensor::f64("glass_x_m", &[n], self.glass_x_m.iter().copied()),
            Tensor::f64("acceleration_m_s2", &[n], self.acceleration_m_s2.iter().copied()),
            Tensor::f64("glass_y_m", &[n], self.glass_y_m.iter().copied()),
            Tensor::f64("glass_z_m", &[n], self.glass_z_m.iter().copied()),
            Tensor::f64("tilt_rad", &[n], self.tilt_rad.iter().copied()),
            Tensor::f64("energy_j", &[n, 4], energy),
            Tensor::f64("spilled_m3", &[n], self.spilled_m3.iter().copied()),
            Tensor::f64("spilled_j", &[n], self.energy.iter().map(|book| book.spilled)),
            Tensor::f32("column_m", &[n, COLUMNS], &self.column_m),
            Tensor::f32("wall_m", &[n, WALL_POINTS], &self.wall_m),
            Tensor::f32("profile_m", &[n, POINTS], &self.profile_m),
        ];
        match &self.states {
            States::Full(all) => tensors.push(Tensor::f32("state", &[n, STATE], all)),
            States::Factored(factored) => {
                tensors.push(Tensor::f32("reference", &[STATE], &factored.reference));
                tensors.push(Tensor::f32("truncation", &[5], &factored.truncation));
                for (group, name) in GROUP_NAMES.iter().enumerate() {
                    tensors.extend(group_tensors(factored, group, name, n));
                }
            }
        }
        tensors
    }
}

/// Coefficients, their scale, strong and weak modes of one group of `n` frames.
fn group_tensors(factored: &Factored, group: usize, name: &str, n: usize) -> [Tensor; 4] {
    let (rank, width) = (factored.rank(group), group_range(group).len());
    let strong = factored.strong[group];
    let coefficients = &factored.coefficients[group];
    let mut scale = vec![0.0_f32; rank];
    for row in coefficients.chunks_exact(rank.max(1)) {
        for (s, c) in scale.iter_mut().zip(row) {
            *s = s.max(c.abs());
        }
    }
    let scaled: Vec<f32> = coefficients.iter().zip(scale.iter().cycle()).map(|(c, s)| c / s).collect();
    let (halves, eighths) = factored.modes[group].split_at(strong * width);
    [
        Tensor::f16(&format!("{name}.coefficients"), &[n, rank], &scaled),
        Tensor::f32(&format!("{name}.scale"), &[rank], &scale),
        Tensor::f16(&format!("{name}.strong"), &[strong, width], halves),
        Tensor::i8(&format!("{name}.weak"), &[rank - strong, width], eighths),
    ]
}

/// Refuses texts that a terminal would carry out when they are printed.
fn check_texts(provenance: &Provenance) -> Result<(), String> {
    let Provenance { liquid, motion, command, effects, .. } = provenance;
    let own = [("liquid", liquid), ("motion", motion), ("command", command)];
    let effects = effects.iter().map(|(name, _)| ("name of an effect", name));
    match own.into_iter().chain(effects).find(|(_, text)| text.chars().any(char::is_control)) {
        Some((field, _)) => Err(format!("provenance: its {field} holds control characters")),
        None => Ok(()),
    }
}

/// The recording in the bytes of a file.
fn parse(bytes: &[u8]) -> Result<Recording, String> {
    let text = FileText::read(bytes)?;
    let file = SafeTensors::deserialize(bytes).map_err(|e| format!("{e}"))?;
    let known = match text.get("format")? {
        // Every recording of version 1 is of a simulator that knows its whole liquid.
        FORMAT_1 => KnownGroups::ALL,
        FORMAT => groups(text.get("known")?)?,
        other => {
            return Err(format!("its format is '{other}'; this program reads '{FORMAT}' and '{FORMAT_1}'"));
        }
    };
    let glass: Glass = serde_json::from_str(text.get("glass")?).map_err(|e| format!("glass: {e}"))?;
    let provenance: Provenance =
        serde_json::from_str(text.get("provenance")?).map_err(|e| format!("provenance: {e}"))?;
    check_texts(&provenance)?;
    let glass_x_m = f64s(&file, "glass_x_m", None)?;
    let n = glass_x_m.len();
    let states = if file.tensor("state").is_ok() {
        States::Full(f32s(&file, "state", Some(&[n, STATE]))?)
    } else {
        States::Factored(Box::new(factored(&file, n)?))
    };
    let energy = f64s(&file, "energy_j", Some(&[n, 4]))?;
    // Recordings from before these channels were of glasses that did none of it.
    let channel = |name: &str| match file.tensor(name) {
        Ok(_) => f64s(&file, name, Some(&[n])),
        Err(_) => Ok(vec![0.0; n]),
    };
    Ok(Recording {
        glass,
        provenance,
        glass_x_m,
        acceleration_m_s2: f64s(&file, "acceleration_m_s2", Some(&[n]))?,
        glass_y_m: channel("glass_y_m")?,
        glass_z_m: channel("glass_z_m")?,
        tilt_rad: channel("tilt_rad")?,
        column_m: f32s(&file, "column_m", Some(&[n, COLUMNS]))?,
        wall_m: f32s(&file, "wall_m", Some(&[n, WALL_POINTS]))?,
        profile_m: f32s(&file, "profile_m", Some(&[n, POINTS]))?,
        energy: energy
            .chunks_exact(4)
            .zip(channel("spilled_j")?)
            .map(|(b, spilled)| EnergyBook {
                kinetic: b[0],
                potential: b[1],
                internal: b[2],
                work: b[3],
                spilled,
            })
            .collect(),
        spilled_m3: channel("spilled_m3")?,
        states,
        known,
    })
}

fn factored(file: &SafeTensors<'_>, frames: usize) -> Result<Factored, String> {
    let truncation = f32s(file, "truncation", Some(&[5]))?;
    let mut out = Factored {
        reference: f32s(file, "reference", Some(&[STATE]))?,
        coefficients: std::array::from_fn(|_| Vec::new()),
        modes: std::array::from_fn(|_| Vec::new()),
        strong: [0; 5],
        truncation: std::array::from_fn(|i| truncation[i]),
    };
    for (group, name) in GROUP_NAMES.iter().enumerate() {
        let part = |part: &str| format!("{name}.{part}");
        let scale = f32s(file, &part("scale"), None)?;
        let (rank, width) = (scale.len(), group_range(group).len());
        let strong = rows(file, &part("strong"));
        let weak = rank.checked_sub(strong).ok_or(format!("'{name}' has more strong modes than modes"))?;
        let mut modes = f16s(file, &part("strong"), &[strong, width])?;
        let eighths = typed(file, &part("weak"), Dtype::I8, Some(&[weak, width]))?;
        modes.extend(eighths.iter().map(|b| f32::from(b.cast_signed()) / 127.0));
        let mut coefficients = f16s(file, &part("coefficients"), &[frames, rank])?;
        for (c, s) in coefficients.iter_mut().zip(scale.iter().cycle()) {
            *c *= s;
        }
        (out.modes[group], out.coefficients[group], out.strong[group]) = (modes, coefficients, strong);
    }
    Ok(out)
}
