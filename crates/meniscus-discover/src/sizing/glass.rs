//! The particle simulator as a model that is sized, with the reference liquid as control variate.
//!
//! ```text
//! s(p) = simulated(p) + mean over the references in the same motion of (measured - simulated reference)
//! ```
//! The reference is simulated in the same packing, so that much of what a packing changes cancels as well.

use super::candidate::SizingCandidate;
use super::error::SizingError;
use super::forward::{Forward, Point, Simulated};
use super::projection::{Observed, ObservedChannel, Series};
use super::simulations::{Simulations, Wanted};
use super::store::Heights;
use crate::baseline::calibrate::Calibration;
use crate::insert::simulated::{Resolution, SimulatedGlass};
use crate::recordings::record::{Channel, Quantity, Record};
use crate::recordings::stated::Known;
use meniscus_numerics::statistics::rms;
use meniscus_sph::Setup;

/// Error that the simulator is expected to have in a channel, relative to its root mean square.
const SIMULATOR_ERROR: f64 = 0.02;

/// Difference of logarithmic viscosities up to which two references are of one liquid.
const SAME_VISCOSITY: f64 = 0.01;

/// References of known liquids: recordings and what is known of each.
pub type References<'a> = [(Known, &'a [Record])];

/// One recording with the references in the same motion.
#[derive(Clone, Debug)]
pub struct Matched<'a> {
    /// Recording.
    pub record: &'a Record,
    /// References in its motion, of the liquid nearest to its own.
    pub references: Vec<(Known, &'a Record)>,
}

impl<'a> Matched<'a> {
    /// Returns `record` with those of `references` in its motion.
    #[must_use]
    pub fn new(record: &'a Record, known: &Known, references: &References<'a>) -> Self {
        let kinds = |r: &Record| r.channels.iter().map(|c| c.quantity).collect::<Vec<_>>();
        let apart = |of: &Known| (of.viscosity_pa_s / known.viscosity_pa_s).ln().abs();
        let mut found: Vec<(Known, &'a Record)> = references
            .iter()
            .flat_map(|(known, records)| records.iter().map(move |record| (*known, record)))
            .filter(|(_, other)| other.drive.same(&record.drive) && kinds(other) == kinds(record))
            .collect();
        let nearest = found.iter().map(|(known, _)| apart(known)).fold(f64::INFINITY, f64::min);
        found.retain(|(known, _)| apart(known) <= nearest + SAME_VISCOSITY);
        Self { record, references: found }
    }

    /// Returns the recording as it is compared.
    #[must_use]
    pub fn observed(&self, calibration: &Calibration, recordings: usize) -> Observed {
        let compared = self.record.channels.iter().filter(|channel| is_compared(channel));
        let channel = |channel: &Channel| {
            let noise = calibration.noise_of(channel.quantity).sigma_m;
            // The control variate has the noise of its references.
            let noise = match self.references.len() {
                0 => noise,
                count => noise * (1.0 + 1.0 / count as f64).sqrt(),
            };
            let moving = channel.value.iter().skip(self.record.rest_frames).flatten().copied();
            ObservedChannel {
                value: channel.value.clone(),
                sigma_m: noise.hypot(SIMULATOR_ERROR * rms(moving)),
                offset_m: calibration.offset_m2(channel.quantity, recordings).sqrt(),
            }
        };
        Observed {
            name: self.record.name.clone(),
            interval_s: self.record.interval_s,
            lag_s: calibration.lag_deviation_s,
            channels: compared.map(channel).collect(),
        }
    }
}

/// The position of the glass is an input of the simulation and is not compared.
fn is_compared(channel: &Channel) -> bool {
    channel.quantity != Quantity::Place
}

/// Simulator of a candidate at one spacing.
pub struct GlassForward<'a> {
    /// Maker of simulations.
    pub simulations: &'a Simulations<'a>,
    /// Candidate.
    pub candidate: &'a SizingCandidate,
    /// Glass and liquid as stated.
    pub known: Known,
    /// Recordings.
    pub recordings: &'a [Matched<'a>],
    /// Lag of the frames, s.
    pub lag_s: f64,
    /// Spacing of the particles, m.
    pub spacing_m: f64,
    /// Seed of the first packing; the others follow.
    pub seed: u64,
}

impl GlassForward<'_> {
    fn resolution(&self, packing: usize) -> Resolution {
        Resolution { spacing_m: self.spacing_m, seed: self.seed + packing as u64 }
    }

    /// Returns the set-up of the simulator at `point`; none where it is refused.
    #[must_use]
    pub fn setup(&self, point: &Point) -> Option<Setup> {
        let (active, known) = self.candidate.at(&point.parameters, &self.known);
        self.simulations.glass(&known, &active, self.resolution(point.packing)).ok().map(|glass| glass.setup)
    }

    /// Returns the glass at `point` with its simulations.
    fn wanted(&self, point: &Point) -> Result<(SimulatedGlass, Vec<Wanted>), String> {
        let (active, known) = self.candidate.at(&point.parameters, &self.known);
        let glass = self.simulations.glass(&known, &active, self.resolution(point.packing))?;
        let course = |matched: &Matched<'_>| {
            Ok(Wanted { setup: glass.setup.clone(), course: glass.course(matched.record)? })
        };
        let wanted = self.recordings.iter().map(course).collect::<Result<Vec<_>, String>>()?;
        Ok((glass, wanted))
    }

    /// Returns the simulations of the references in `packing`, recording by recording.
    fn controls(&self, packing: usize) -> Result<Vec<Vec<(SimulatedGlass, Wanted)>>, String> {
        let one = |(known, record): &(Known, &Record)| {
            let glass = self.simulations.glass(known, &[], self.resolution(packing))?;
            let wanted = Wanted { setup: glass.setup.clone(), course: glass.course(record)? };
            Ok((glass, wanted))
        };
        let all = |matched: &Matched<'_>| matched.references.iter().map(one).collect::<Result<Vec<_>, _>>();
        self.recordings.iter().map(all).collect()
    }

    /// Returns the mean of measured less simulated over the references of each recording.
    fn control(
        &self,
        glasses: &[Vec<(SimulatedGlass, Wanted)>],
        heights: &mut impl Iterator<Item = Heights>,
    ) -> Result<Vec<Option<Series>>, String> {
        let mut out = Vec::new();
        for (matched, glasses) in self.recordings.iter().zip(glasses) {
            let mut sum: Vec<Vec<(f64, f64)>> = Vec::new();
            for ((glass, _), (_, reference)) in glasses.iter().zip(&matched.references) {
                let heights = heights.next().ok_or("a simulation is missing")??;
                let simulated = glass.channels(reference, &heights, self.lag_s)?;
                let pairs = reference.channels.iter().zip(simulated).filter(|(c, _)| is_compared(c));
                for (n, (channel, series)) in pairs.enumerate() {
                    if sum.len() <= n {
                        sum.push(vec![(0.0, 0.0); matched.record.frames()]);
                    }
                    for (slot, (measured, simulated)) in
                        sum[n].iter_mut().zip(channel.value.iter().zip(series))
                    {
                        if let Some(measured) = measured {
                            *slot = (slot.0 + measured - simulated, slot.1 + 1.0);
                        }
                    }
                }
            }
            // Where no reference was measured, nothing is known of the simulator's error.
            let mean =
                |column: &Vec<(f64, f64)>| column.iter().map(|(sum, count)| sum / count.max(1.0)).collect();
            out.push((!sum.is_empty()).then(|| sum.iter().map(mean).collect()));
        }
        Ok(out)
    }
}

impl Forward for GlassForward<'_> {
    fn run(&self, points: &[Point]) -> Result<Vec<Result<Simulated, String>>, SizingError> {
        let wanted: Vec<Result<_, String>> = points.iter().map(|point| self.wanted(point)).collect();
        let mut packings: Vec<usize> = points.iter().map(|point| point.packing).collect();
        packings.sort_unstable();
        packings.dedup();
        let not_simulated = |reason: String| SizingError::NotSimulated { reason };
        let controls = packings.iter().map(|packing| self.controls(*packing)).collect::<Result<Vec<_>, _>>();
        let controls = controls.map_err(not_simulated)?;
        let mut batch: Vec<Wanted> = wanted.iter().flatten().flat_map(|(_, wanted)| wanted.clone()).collect();
        let own = batch.len();
        batch.extend(controls.iter().flatten().flatten().map(|(_, wanted)| wanted.clone()));
        let mut heights = self.simulations.run(&batch)?.into_iter();
        let mut first: std::vec::IntoIter<Heights> =
            heights.by_ref().take(own).collect::<Vec<_>>().into_iter();
        let control = controls.iter().map(|glasses| self.control(glasses, &mut heights));
        let control: Vec<Vec<Option<Series>>> = control.collect::<Result<_, _>>().map_err(not_simulated)?;
        let one = |(point, wanted): (&Point, Result<(SimulatedGlass, Vec<Wanted>), String>)| {
            let (glass, wanted) = wanted?;
            let mine: Vec<Heights> = first.by_ref().take(wanted.len()).collect();
            let place = packings.iter().position(|packing| *packing == point.packing).unwrap_or(0);
            let mut recordings = Vec::new();
            for ((matched, heights), control) in self.recordings.iter().zip(mine).zip(&control[place]) {
                let channels = glass.channels(matched.record, &heights?, self.lag_s)?;
                let kept = matched.record.channels.iter().zip(channels).filter(|(c, _)| is_compared(c));
                let mut series: Series = kept.map(|(_, series)| series).collect();
                if let Some(control) = control {
                    let each = series.iter_mut().zip(control);
                    each.for_each(|(s, c)| s.iter_mut().zip(c).for_each(|(s, c)| *s += c));
                }
                recordings.push(series);
            }
            Ok(Simulated { recordings, control: control[place].clone() })
        };
        Ok(points.iter().zip(wanted).map(one).collect())
    }
}
