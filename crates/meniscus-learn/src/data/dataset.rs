//! Recordings as training wants them: POD coefficients, profiles, motion and energy, one sequence a
//! recording. Training and validation are split by recording; overlapping windows of one recording
//! on both sides would leak.

use crate::TrainError;
use crate::data::groups::IN_STATE;
use crate::data::pod::Basis;
use crate::data::snapshots::{decompose, fluctuation, mean_rest, pick, rest_of};
use crate::hyperparameters::PodParameters;
use meniscus::surface::POINTS;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::{Recording, STATE, group_range};

/// The bases and scales that all sequences share.
#[derive(Debug)]
pub(crate) struct Frame {
    /// One basis for each group of [`TRUNK`](crate::data::groups::TRUNK).
    pub(crate) bases: Vec<Basis>,
    /// Rest state, [`STATE`] numbers: the mean of the first frames of the training recordings.
    pub(crate) rest_state: Vec<f32>,
    /// Rest profile, metres.
    pub(crate) rest_profile: Vec<f32>,
    /// F: what the coefficients owe to the port value of the same instant, SI units a unit of u.
    pub(crate) feed: Vec<f32>,
    /// Root mean square norm of each group's coefficients over the training frames.
    pub(crate) group_scale: [f32; 5],
    /// Feature scale of heights, m.
    pub(crate) height_scale_m: f32,
    /// Feature and port scale of accelerations, m/s2.
    pub(crate) acceleration_scale: f32,
    /// Mean kinetic plus potential energy over the moving training frames, J.
    pub(crate) energy_scale_j: f64,
    /// Height at rest, m.
    pub(crate) fill_m: f64,
}

/// One recording, projected.
#[derive(Clone, Debug)]
pub(crate) struct Sequence {
    /// Frames x sum of ranks, SI units, without the feed-through of the port once it is known.
    pub(crate) coefficients: Vec<f32>,
    /// Squared norm of the fluctuation of each trunk group, frame by frame.
    pub(crate) norm2: Vec<[f32; 5]>,
    /// Frames x [`POINTS`], metres.
    pub(crate) profile_m: Vec<f32>,
    /// Acceleration of the glass at each frame over the scale.
    pub(crate) port: Vec<f64>,
    /// Position of the glass, m.
    pub(crate) glass_x_m: Vec<f64>,
    /// Kinetic plus potential energy, J.
    pub(crate) energy_j: Vec<f64>,
    /// Heat since the first frame, J.
    pub(crate) heat_j: Vec<f64>,
    /// Work of the moving glass since the first frame, J.
    pub(crate) work_j: Vec<f64>,
}

impl Sequence {
    /// Number of frames.
    #[must_use]
    pub(crate) fn frames(&self) -> usize {
        self.glass_x_m.len()
    }
}

impl Frame {
    /// Bases, rest and scales from the training recordings.
    ///
    /// # Errors
    /// [`TrainError::NoMotion`] when nothing moves in them.
    pub(crate) fn new(training: &[Recording], parameters: &PodParameters) -> Result<Self, TrainError> {
        let first = training.first().ok_or(TrainError::NoRecording)?;
        let (rest_state, rest_profile) = mean_rest(training);
        let picked = pick(training, parameters);
        if picked.is_empty() {
            return Err(TrainError::NoMotion);
        }
        let bases = decompose(training, &picked, parameters);
        let moving = |f: &dyn Fn(&Recording, usize) -> f64| {
            picked.iter().map(|&(r, n)| f(&training[r], n)).sum::<f64>() / picked.len() as f64
        };
        let mean_square = moving(&|r, n| r.acceleration_m_s2[n].powi(2));
        let fill_m = first.glass.fill_m;
        let height2 = moving(&|r, n| {
            r.profile(n).iter().map(|&h| (f64::from(h) - fill_m).powi(2)).sum::<f64>() / POINTS as f64
        });
        let width = bases.iter().map(Basis::rank).sum();
        Ok(Self {
            bases,
            feed: vec![0.0; width],
            rest_state,
            rest_profile,
            group_scale: [1.0; 5],
            height_scale_m: height2.sqrt() as f32,
            acceleration_scale: mean_square.sqrt().max(1e-3) as f32,
            energy_scale_j: moving(&|r, n| r.energy[n].kinetic + r.energy[n].potential).max(1e-9),
            fill_m,
        })
    }

    /// Sum of the ranks.
    #[must_use]
    pub(crate) fn width(&self) -> usize {
        self.bases.iter().map(Basis::rank).sum()
    }

    /// The range of each trunk group among the coefficients.
    #[must_use]
    pub(crate) fn ranges(&self) -> Vec<std::ops::Range<usize>> {
        let mut start = 0;
        let range = |basis: &Basis| {
            let range = start..start + basis.rank();
            start = range.end;
            range
        };
        self.bases.iter().map(range).collect()
    }

    /// Projects a recording on the bases.
    #[must_use]
    pub(crate) fn project(&self, recording: &Recording) -> Sequence {
        let frames = recording.frames();
        let rest = rest_of(recording);
        let mut coefficients = Vec::with_capacity(frames * self.width());
        let mut norm2 = Vec::with_capacity(frames);
        let mut field = vec![0.0; STATE];
        for frame in 0..frames {
            fluctuation(recording, frame, &rest, &mut field);
            let surface: Vec<f32> =
                recording.profile(frame).iter().zip(recording.profile(0)).map(|(z, r)| z - r).collect();
            let mut norms = [0.0; 5];
            for (group, (basis, norm)) in self.bases.iter().zip(&mut norms).enumerate() {
                let part = IN_STATE.get(group).map_or(&surface[..], |&g| &field[group_range(g)]);
                *norm = part.iter().map(|f| f * f).sum();
                basis.project(part, &mut coefficients);
            }
            norm2.push(norms);
        }
        Sequence {
            coefficients,
            norm2,
            profile_m: recording.profile_m.clone(),
            port: recording
                .acceleration_m_s2
                .iter()
                .map(|a| a / f64::from(self.acceleration_scale))
                .collect(),
            glass_x_m: recording.glass_x_m.clone(),
            energy_j: recording.energy.iter().map(|b| b.kinetic + b.potential).collect(),
            work_j: recording.energy.iter().map(|b| b.work - recording.energy[0].work).collect(),
            heat_j: recording.energy.iter().map(|b| b.internal - recording.energy[0].internal).collect(),
        }
    }

    /// Cost of an error of one in the port value, as the autoencoder counts errors: by the squared
    /// relative error, averaged over the groups; it never
    /// counts for nothing.
    #[must_use]
    pub(crate) fn feed_cost(&self) -> f64 {
        let scaled = self.feed.iter().zip(self.coefficient_scale()).map(|(f, s)| f64::from(f / s).powi(2));
        (scaled.sum::<f64>() / 5.0).sqrt().max(0.05)
    }

    /// Takes the feed-through out of the coefficients of `sequence`.
    pub(crate) fn take_out_feed(&self, sequence: &mut Sequence) {
        for (row, &u) in sequence.coefficients.chunks_exact_mut(self.feed.len()).zip(&sequence.port) {
            row.iter_mut().zip(&self.feed).for_each(|(c, f)| *c -= f * u as f32);
        }
    }

    /// Takes the scales of the groups from the projected training sequences.
    pub(crate) fn measure_scales(&mut self, training: &[Sequence]) {
        let (ranges, width) = (self.ranges(), self.width());
        let frames: usize = training.iter().map(Sequence::frames).sum();
        for (scale, range) in self.group_scale.iter_mut().zip(ranges) {
            let rows = training.iter().flat_map(|s| s.coefficients.chunks_exact(width));
            let sum: f64 = rows.flat_map(|row| &row[range.clone()]).map(|&c| f64::from(c).powi(2)).sum();
            *scale = (sum / frames as f64).sqrt().max(1e-12) as f32;
        }
    }

    /// The scale of every coefficient: that of its group.
    #[must_use]
    pub(crate) fn coefficient_scale(&self) -> Vec<f32> {
        let repeated = |(basis, &scale): (&Basis, &f32)| vec![scale; basis.rank()];
        self.bases.iter().zip(&self.group_scale).flat_map(repeated).collect()
    }
}

/// The acceleration that is known at frame n, a_n = (X_n - 2 X_{n-1} + X_{n-2}) / dt^2 in m/s2; the
/// glass stands still before the first frame.
#[must_use]
pub(crate) fn known_acceleration(glass_x_m: &[f64]) -> Vec<f64> {
    let at = |n: usize, back: usize| glass_x_m[n.saturating_sub(back)];
    let second = |n| (at(n, 0) - 2.0 * at(n, 1) + at(n, 2)) / (FRAME_INTERVAL_S * FRAME_INTERVAL_S);
    (0..glass_x_m.len()).map(second).collect()
}
