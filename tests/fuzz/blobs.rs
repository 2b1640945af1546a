//! Weight blobs whose length and checksum are right again after the change: nothing stands between it and the parsers.

use crate::mutation::{Edit, cases, edited, edits};
use crate::resealed::resealed;
use crate::support;
use meniscus::blob::{Model, PREFIX_LEN};
use meniscus::latent::generic::LatentState;
use meniscus::runtime::{Estimator, Memory, TurnInput};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::Micros;
use meniscus_platform::clock::NoClock;
use meniscus_platform::files::AlignedBytes;
use proptest::prelude::*;

/// Numbers that a weight may be set to.
const EXTREMES: [f32; 9] = [0.0, -0.0, 1.0, -1.0, 1e-38, 1e6, -1e19, 3e38, f32::NAN];

/// Returns `blob` with changes of its header, whose stated length is right again, resealed.
pub(crate) fn with_header(blob: &[u8], edits: &[Edit]) -> Vec<u8> {
    let length = u32::from_le_bytes([blob[12], blob[13], blob[14], blob[15]]) as usize;
    let header = edited(&blob[PREFIX_LEN..PREFIX_LEN + length], edits);
    // Tensors stay on their boundaries as long as the header fits in front of them.
    let room = length.next_multiple_of(64);
    let mut all = [&blob[..PREFIX_LEN], &header].concat();
    all[12..16].copy_from_slice(&(header.len() as u32).to_le_bytes());
    all.resize(PREFIX_LEN + header.len().max(room.min(blob.len() - PREFIX_LEN)), 0);
    all.truncate(blob.len());
    let kept = all.len();
    all.extend_from_slice(&blob[kept..]);
    resealed(all)
}

fn leaning(turn: u64) -> SurfaceProfile {
    let lean = 0.0004 * (turn as f32 / 5.0).sin();
    SurfaceProfile {
        height_m: std::array::from_fn(|index| 0.07 + lean * (index as f32 - 10.0)),
        variance_m2: [1e-7; POINTS],
        valid: [true; POINTS],
        glass_x_m: Some(0.01 * lean),
        sequence: turn as u32,
        captured: Micros(1_000_000 + turn * 16_667),
    }
}

/// Runs a model for 24 turns, and its step alone under strong motions: heat never falls and the books close.
fn run(model: &Model<'_>) -> Result<(), TestCaseError> {
    let (mut memory, mut field) = (Memory::default(), vec![0.0; model.field_len()]);
    for turn in 0..24 {
        let profile = leaning(turn);
        let estimate =
            Estimator::new(model).turn(&mut memory, TurnInput::tracked(&profile), &mut NoClock, &mut field);
        prop_assert!(estimate.audit.heat >= 0.0, "heat {} at turn {turn}", estimate.audit.heat);
    }
    let mut state = LatentState::default();
    for turn in 0..24 {
        let before = model.generic.energy(&state);
        let audit = model.generic.step(&mut state, 40.0 * (f64::from(turn) * 0.7).sin());
        let size = before.abs() + audit.work.abs() + audit.heat.abs();
        prop_assert!(audit.heat >= 0.0, "heat {} of step {turn}", audit.heat);
        prop_assert!(audit.energy_residual.abs() <= 1e-9 * size + 1e-12, "{audit:?}");
        prop_assert!(state.latent.iter().all(|x| x.is_finite()) && state.heat.is_finite());
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(400))]

    /// A header that passes all checks is of a model that runs.
    #[test]
    fn headers(edits in edits(), seed in 0..8_u64) {
        let bytes = with_header(&support::random_blob(seed, 0.1), &edits);
        if let Ok(model) = Model::load(&AlignedBytes::copy(&bytes)) {
            run(&model)?;
        }
    }

    /// Weights of any size are refused or keep both laws.
    #[test]
    fn weights(
        changes in prop::collection::vec((any::<usize>(), 0..EXTREMES.len(), 1..200_usize), 1..6),
        seed in 0..8_u64,
        size in prop_oneof![Just(0.1_f32), Just(3.0), Just(1e4), Just(0.0)],
    ) {
        let mut bytes = support::random_blob(seed, size).to_vec();
        let header = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
        let from = (PREFIX_LEN + header).next_multiple_of(64);
        let count = (bytes.len() - from) / 4;
        for (at, value, length) in changes {
            for number in at % count..(at % count + length).min(count) {
                let place = from + 4 * number;
                bytes[place..place + 4].copy_from_slice(&EXTREMES[value].to_le_bytes());
            }
        }
        if let Ok(model) = Model::load(&AlignedBytes::copy(&resealed(bytes))) {
            run(&model)?;
        }
    }
}
