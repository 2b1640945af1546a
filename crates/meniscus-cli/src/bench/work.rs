//! Fixed work without a clock, a function a stage: what benches/instructions counts.

use anyhow::Context;
use meniscus::blob::{Model, Variant};
use meniscus::latent::generic::{LATENTS, LatentState};
use meniscus::latent::nn::Element;
use meniscus::latent::window::{FEATURES, WINDOW};
use meniscus::runtime::{Estimator, InputSource, ProfileSensor, Tracker};
use meniscus::surface::{Config, Settings};
use meniscus_data::recording::Recording;
use meniscus_platform::clock::NoClock;
use meniscus_timing::bench::chain::{Chain, Packed};
use meniscus_timing::bench::networks::Networks;
use meniscus_timing::bench::turn::{Payloads, payloads};
use meniscus_virtual::render::SceneSettings;
use std::hint::black_box;

/// Frames that the turn is counted on: a window and as many again.
const FRAMES: usize = 32;

/// Every stage `times` times. Nothing depends on a clock or on chance, so the instructions are those of the code.
pub(super) fn count(
    model: &Model<'_>,
    recording: &Recording,
    settings: Settings,
    times: u32,
) -> anyhow::Result<()> {
    let networks = Networks::new(1);
    let window = Networks::window(1);
    let frames = payloads(recording, SceneSettings { camera: settings, ..SceneSettings::default() }, FRAMES);
    let config = Config::new(settings)?;
    let mut field = vec![0.0; model.field_len()];
    let mut small = model.clone();
    small.header.variant = Variant::Small;
    for _ in 0..times {
        stage_encode(model);
        stage_step(model);
        stage_field(model, &mut field);
        stage_turns(model, config, &frames, &mut field);
        stage_turns_small(&small, config, &frames);
    }
    for (stage, element) in [
        (stage_chain_f32 as fn(&Chain<'_>, &[f32], &mut [f32]), Element::F32),
        (stage_chain_bf16, Element::Bf16),
        (stage_chain_i8, Element::I8),
    ] {
        let packed = Packed::new(&networks, |layer| super::element(element, layer));
        let chain = packed.chain().context("the networks have not the chain's shape")?;
        let mut field = Chain::field();
        (0..times).for_each(|_| stage(&chain, &window, &mut field));
    }
    Ok(())
}

/// A window to latents.
#[inline(never)]
fn stage_encode(model: &Model<'_>) {
    let rows = [[0.1_f32; FEATURES]; WINDOW];
    black_box(model.encoder.encode(black_box(&rows).iter()));
}

/// Sixty time steps from rest under a stroke.
#[inline(never)]
fn stage_step(model: &Model<'_>) {
    let mut state = LatentState::default();
    for frame in 0..60 {
        model.generic.step(&mut state, f64::sin(0.36 * f64::from(frame)));
    }
    black_box(state);
}

/// Latents to the full field.
#[inline(never)]
fn stage_field(model: &Model<'_>, field: &mut [f32]) {
    let coefficients = model.decoder.coefficients(black_box(&[0.3; LATENTS]), 0.5);
    model.decoder.field(&coefficients, 0.01, field);
    black_box(field);
}

/// Thirty-two frames from payload to field.
#[inline(never)]
fn stage_turns(model: &Model<'_>, config: Config, frames: &Payloads, field: &mut [f32]) {
    turns(model, config, frames, field);
}

/// The same of the small variant, whose field is empty.
#[inline(never)]
fn stage_turns_small(model: &Model<'_>, config: Config, frames: &Payloads) {
    turns(model, config, frames, &mut []);
}

fn turns(model: &Model<'_>, config: Config, frames: &Payloads, field: &mut [f32]) {
    let (width, height) = config.image_size();
    let (mut depth, mut infrared) = (vec![0; 2 * width * height], vec![0; width * height]);
    let sensor = ProfileSensor::new(config, &mut depth, &mut infrared);
    let mut tracker = Tracker::new(Estimator::new(model), sensor);
    for (stream, payload) in frames {
        tracker.accept(*stream, payload, InputSource::tracked, &mut NoClock, field, |turn, _| {
            black_box(turn);
        });
    }
}

/// The paper's chain.
#[inline(never)]
fn stage_chain_f32(chain: &Chain<'_>, window: &[f32], field: &mut [f32]) {
    chain.run(black_box(window), field);
}

/// The same in bf16.
#[inline(never)]
fn stage_chain_bf16(chain: &Chain<'_>, window: &[f32], field: &mut [f32]) {
    chain.run(black_box(black_box(window)), field);
}

/// The same in i8.
#[inline(never)]
fn stage_chain_i8(chain: &Chain<'_>, window: &[f32], field: &mut [f32]) {
    chain.run(black_box(black_box(black_box(window))), field);
}
