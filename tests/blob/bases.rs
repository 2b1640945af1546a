//! Bases of the decoder: coarser elements, the pattern of the heat, cut ranks, parts of the field.

use super::{refusal, sealed, support};
use meniscus::blob::{LoadError, Model, PREFIX_LEN, Tensor};
use meniscus::latent::decoder::Selection;
use meniscus::latent::nn::Element;
use meniscus::runtime::{Estimate, Estimator, Memory, TurnInput};
use meniscus_data::blob_file::quantize::quantize;
use meniscus_data::blob_file::write::{Part, blob, stored};
use meniscus_platform::clock::Monotonic;
use meniscus_platform::files::AlignedBytes;

#[test]
fn coarser_blobs_load_and_stay_near() {
    let parts = support::parts(1, 0.1);
    let fine = support::random_blob(1, 0.1);
    let fine = Model::load(&fine).expect("sound");
    let latent = [0.3; 13];
    let c = fine.decoder.coefficients(&latent, 0.5);
    let mut due = vec![0.0; fine.field_len()];
    fine.decoder.field(&c, 0.01, &mut due);
    for (element, most) in [(Element::F32, 0.0), (Element::Bf16, 0.02), (Element::I8, 0.05)] {
        let bytes = AlignedBytes::copy(&stored(support::header(), &parts, |_| element).expect("a blob"));
        let model = Model::load(&bytes).expect("a coarser blob loads");
        assert_eq!(model.decoder.groups[1].basis.element(), element);
        let c = model.decoder.coefficients(&latent, 0.5);
        let mut field = vec![0.0; model.field_len()];
        model.decoder.field(&c, 0.01, &mut field);
        let norm = |x: &[f32]| x.iter().map(|x| x * x).sum::<f32>().sqrt();
        let off: Vec<f32> = field.iter().zip(&due).map(|(a, b)| a - b).collect();
        let relative = norm(&off) / norm(&due);
        assert!(relative <= most && (most == 0.0 || relative > 0.0), "{element}: {relative}");
        // What the laws stand on is the same to the bit.
        assert_eq!(model.generic.operators, fine.generic.operators);
        let x = meniscus::latent::generic::Latent::repeat(0.4);
        assert_eq!(model.generic.potential.value(&x).to_bits(), fine.generic.potential.value(&x).to_bits());
    }
}

#[test]
fn a_blob_whose_laws_are_coarse_is_refused() {
    let bytes = stored(support::header(), &support::parts(1, 0.1), |_| Element::Bf16).expect("a blob");
    let head = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    let model = AlignedBytes::copy(&bytes);
    let sections = Model::load(&model).expect("sound").header.sections;
    let energy = sections.iter().position(|s| s.tensor == Tensor::EnergyIn).expect("there");
    // The elements are the last bytes of the header, one each.
    let mut hostile = bytes.clone();
    hostile[PREFIX_LEN + head - sections.len() + energy] = 1;
    let error = refusal(&sealed(hostile));
    assert_eq!(error, LoadError::TooCoarse { tensor: Tensor::EnergyIn, element: Element::Bf16 });
    // An element that there is not, and one too few.
    let mut unknown = bytes;
    unknown[PREFIX_LEN + head - 1] = 9;
    assert_eq!(refusal(&sealed(unknown)), LoadError::Header);
}

/// The internal energy of `field`, and what it has to be: `columns` of the basis by the heat and the coefficients of e.
fn heated(parts: &[Part], columns: usize) -> (Vec<f32>, Vec<f32>) {
    let bytes = AlignedBytes::copy(&blob(support::header(), parts).expect("a blob"));
    let model = Model::load(&bytes).expect("sound");
    let c = model.decoder.coefficients(&[0.2; 13], 0.1);
    let heat_j = 0.01;
    let mut said = vec![0.0; support::PARTICLES];
    model.decoder.part(Selection::NONE.with(2), &c, heat_j, &mut said);
    let values = |tensor| &parts.iter().find(|part| part.tensor == tensor).expect("there").values;
    let (rest, basis) = (values(Tensor::GroupRest(2)), values(Tensor::GroupBasis(2)));
    // q and v have two coefficients each before those of e.
    let times = [1.0, c[4], c[5]];
    let due = rest
        .iter()
        .zip(basis.chunks_exact(columns))
        .map(|(rest, row)| rest + row.iter().zip(times).map(|(b, c)| heat_j * b * c).sum::<f32>());
    (said, due.collect())
}

#[test]
fn the_pattern_of_the_heat_moves_with_its_coefficients_and_one_column_stands_still() {
    let close = |(said, due): (Vec<f32>, Vec<f32>)| said.iter().zip(&due).all(|(a, b)| (a - b).abs() < 1e-6);
    let mut parts = support::parts(1, 0.1);
    assert!(close(heated(&parts, 3)));
    // As blobs were before: one column, and no coefficients of e between those of v and sigma.
    for part in &mut parts {
        let columns = part.columns;
        match part.tensor {
            Tensor::GroupBasis(2) => {
                part.values = part.values.iter().step_by(columns).copied().collect();
                part.columns = 1;
            }
            Tensor::TrunkLinear | Tensor::TrunkPort | Tensor::TrunkWeight(2) | Tensor::TrunkBias(2) => {
                part.values.drain(4 * columns..6 * columns);
                part.rows -= 2;
            }
            _ => {}
        }
    }
    assert!(close(heated(&parts, 1)));
}

/// The bases before and behind e are turned; what e is multiplied by stays in its place.
#[test]
fn cutting_the_bases_leaves_the_internal_energy_alone() {
    let bytes = support::random_blob(1, 0.1);
    let model = Model::load(&bytes).expect("sound");
    let still = Estimator::new(&model).turn(
        &mut Memory::default(),
        TurnInput::default(),
        &mut Monotonic::start(),
        &mut [],
    );
    let wave = |n: usize| {
        let mut estimate = still;
        estimate.latent = std::array::from_fn(|k| (0.3 * (n * (k + 1)) as f64).sin());
        estimate.port = (0.7 * n as f32).cos();
        estimate
    };
    let run: Vec<Estimate> = (0..60).map(wave).collect();
    let cut = quantize(&bytes, Element::F32, Some(0.5), &run).expect("quantised");
    assert!(cut.ranks.iter().any(|(before, after)| after < before), "{:?}", cut.ranks);
    assert_eq!(cut.ranks[2], (3, 3));
    let cut = AlignedBytes::copy(&cut.blob);
    let [fine, cut] = [&bytes, &cut].map(|bytes| {
        let model = Model::load(bytes).expect("sound");
        let mut energy = vec![0.0; support::PARTICLES];
        let c = model.decoder.coefficients(&[0.2; 13], 0.1);
        model.decoder.part(Selection::NONE.with(2), &c, 0.01, &mut energy);
        energy
    });
    assert_eq!(fine, cut);
}

#[test]
fn a_part_of_the_field_is_that_part() {
    let bytes = support::random_blob(1, 0.1);
    let model = Model::load(&bytes).expect("sound");
    let c = model.decoder.coefficients(&[0.2; 13], 0.1);
    let mut all = vec![0.0; model.field_len()];
    model.decoder.field(&c, 0.01, &mut all);
    let chosen = Selection::NONE.with(1).with(2);
    let particles = support::PARTICLES;
    assert_eq!(model.decoder.part_len(chosen), 4 * particles);
    let mut part = vec![0.0; 4 * particles];
    assert_eq!(model.decoder.part(chosen, &c, 0.01, &mut part), 4 * particles);
    assert_eq!(part, all[3 * particles..7 * particles]);
    assert_eq!(model.decoder.part(Selection::NONE, &c, 0.01, &mut part), 0);
    assert_eq!(Selection::NONE.with(7), Selection::NONE);
}
