//! What was named, put into the flashed model and into the simulator, and what of the gap each closes.

use anyhow::{Context, anyhow, ensure};
use meniscus::blob::Model;
use meniscus::reduced::Rheology;
use meniscus::reduced::effects::Active;
use meniscus_discover::gap::gap_to;
use meniscus_discover::insert::latent::roll_out;
use meniscus_discover::insert::simulated::{Resolution, simulate};
use meniscus_discover::insert::{Closed, TrainedLiquid, insert};
use meniscus_discover::predict::Known;
use meniscus_discover::record::Record;
use meniscus_discover::workflow::Discovery;
use meniscus_platform::files::AlignedBytes;

/// By how much radius and fill of a model may differ from those of the recordings.
const SAME: f64 = 0.01;

/// Refuses a model of another glass than the recordings'.
pub(super) fn same_glass(model: &Model<'_>, known: &Known) -> anyhow::Result<()> {
    let header = &model.header;
    for (what, ours, theirs) in
        [("radius", header.radius_m, known.radius_m), ("fill", header.fill_m, known.fill_m)]
    {
        ensure!(
            (ours / theirs - 1.0).abs() <= SAME,
            "the model's glass has a {what} of {:.1} mm, the recordings' {:.1} mm: train a model of this glass",
            1e3 * ours,
            1e3 * theirs
        );
    }
    Ok(())
}

/// The model with the effects of `found`, and, where a recording is sealed, what that closes.
pub(super) fn flashed(
    bytes: &[u8],
    known: &Known,
    found: &Discovery,
    sealed: Option<&Record>,
) -> anyhow::Result<(Vec<u8>, Option<Closed>)> {
    let liquid = TrainedLiquid {
        density_kg_m3: known.density_kg_m3,
        rheology: Rheology::newtonian(known.viscosity_pa_s),
    };
    let blob = insert(bytes, liquid, &found.verdict.chosen.active)?.blob;
    let Some((record, noise)) = sealed.zip(found.gap.map(|gap| gap.noise)) else { return Ok((blob, None)) };
    let aligned = AlignedBytes::copy(&blob);
    let left = |bytes: &[u8]| -> anyhow::Result<f64> {
        let model = Model::load(bytes).context("the model is refused")?;
        let expected = roll_out(&model, record, found.calibration.lag_s).map_err(|why| anyhow!(why))?;
        Ok(gap_to(record, &expected, noise))
    };
    let closed = Closed { model: "the flashed model", untouched_m: left(bytes)?, effect_m: left(&aligned)? };
    Ok((blob, Some(closed)))
}

/// What the simulator closes of the sealed recording.
pub(super) fn simulated(
    known: &Known,
    found: &Discovery,
    record: &Record,
    resolution: Resolution,
) -> anyhow::Result<Closed> {
    let noise = found.gap.map_or(0.0, |gap| gap.noise);
    let left = |effects: &[Active]| -> anyhow::Result<f64> {
        let expected = simulate(known, effects, record, found.calibration.lag_s, resolution)
            .map_err(|why| anyhow!(why))?;
        Ok(gap_to(record, &expected, noise))
    };
    let untouched_m = left(&[])?;
    Ok(Closed { model: "the simulator", untouched_m, effect_m: left(&found.verdict.chosen.active)? })
}
