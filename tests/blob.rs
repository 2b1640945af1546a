//! A bad blob is refused, each kind with its own error.

#[path = "blob/loading.rs"]
mod loading;
mod support;

use meniscus::blob::{
    BEFORE, CRC, Extension, FieldGroup, FilterConfig, Header, KnownGroups, LoadError, Model, OLDEST_VERSION,
    PREFIX_LEN, Tensor, VERSION,
};
use meniscus::latent::decoder::Selection;
use meniscus::latent::nn::Element;
use meniscus::runtime::{Estimate, Estimator, Memory, TurnInput};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::Micros;
use meniscus_data::blob_file::quantize::quantize;
use meniscus_data::blob_file::read;
use meniscus_data::blob_file::write::{Part, blob, stored};
use meniscus_platform::clock::Monotonic;
use meniscus_platform::files::AlignedBytes;

/// The error for `bytes`.
fn refusal(bytes: &[u8]) -> LoadError {
    Model::load(&AlignedBytes::copy(bytes)).map(|_| ()).expect_err("this blob must be refused")
}

/// Writes the checksum anew, as someone who damages a blob on purpose would.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let crc = CRC.checksum(&bytes[PREFIX_LEN..]).to_le_bytes();
    bytes[20..24].copy_from_slice(&crc);
    bytes
}

fn sound() -> Vec<u8> {
    support::random_blob(1, 0.1).to_vec()
}

#[test]
fn a_sound_blob_loads_and_reads_in_place() {
    let bytes = support::random_blob(1, 0.1);
    let model = Model::load(&bytes).expect("sound");
    assert_eq!(model.header.liquid, "noise");
    assert_eq!(model.field_len(), 13 * support::PARTICLES);
    let weights = model.decoder.groups[0].rest.as_ptr().cast::<u8>();
    assert!(bytes.as_ptr_range().contains(&weights), "the weights are those of the blob");
}

#[test]
fn every_cut_is_refused() {
    let bytes = sound();
    for length in (0..bytes.len()).step_by(97).chain([0, 7, 23, bytes.len() - 1]) {
        let error = refusal(&bytes[..length]);
        assert!(matches!(error, LoadError::Truncated { have, .. } if have == length), "{length}: {error}");
    }
}

#[test]
fn every_flipped_bit_is_refused() {
    let bytes = sound();
    for bit in (0..8 * bytes.len()).step_by(1009).chain(0..8 * PREFIX_LEN) {
        let mut bytes = bytes.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let error = refusal(&bytes);
        match bit / 8 {
            0..8 => assert_eq!(error, LoadError::NotABlob),
            8..12 => assert!(matches!(error, LoadError::Version { .. }), "{error}"),
            12..16 => assert!(matches!(error, LoadError::Header), "{error}"),
            16..20 => {
                assert!(matches!(error, LoadError::Truncated { .. } | LoadError::Trailing { .. }), "{error}");
            }
            _ => assert!(matches!(error, LoadError::Checksum { .. }), "{error}"),
        }
    }
}

#[test]
fn another_version_says_which() {
    let mut bytes = sound();
    bytes[8] = 9;
    assert_eq!(refusal(&bytes), LoadError::Version { found: 9 });
    assert!(refusal(&bytes).to_string().contains("version 9"));
}

/// The blob of `header` in format version 3: without its extension.
fn in_version_3(header: Header) -> Vec<u8> {
    let mut bytes = blob(header.clone(), &support::parts(1, 0.1)).expect("a blob");
    let mut buffer = [0; 512];
    let extension = postcard::to_slice(&header.extension(), &mut buffer).expect("room").len();
    // The tensors stay where they are; the zeros between header and tensors take the place of the extension.
    let head = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    bytes[PREFIX_LEN + head - extension..PREFIX_LEN + head].fill(0);
    bytes[8..12].copy_from_slice(&OLDEST_VERSION.to_le_bytes());
    bytes[12..16].copy_from_slice(&((head - extension) as u32).to_le_bytes());
    sealed(bytes)
}

#[test]
fn a_blob_of_version_3_loads_with_the_reference_settings() {
    let header = Header { model_version: 9, stated_known: KnownGroups::NONE, ..support::header() };
    let bytes = AlignedBytes::copy(&in_version_3(header));
    let model = Model::load(&bytes).expect("version 3 is still read");
    assert_eq!(model.header.extension(), Extension::default());
    assert_eq!(model.header.known(), KnownGroups::ALL);
    assert_eq!(model.header.filter, FilterConfig::REFERENCE);
    assert_eq!(model.header.model_version, 0);
}

/// Before format version 4 a blob did not state its groups; one that was corrected knows what a correction teaches.
#[test]
fn a_corrected_blob_of_version_3_knows_surface_and_positions() {
    let provenance = format!("meniscus correct --steps 300 --seed 1{BEFORE}meniscus train");
    let provenance = provenance.as_str().try_into().expect("short");
    let bytes = AlignedBytes::copy(&in_version_3(Header { provenance, ..support::header() }));
    let model = Model::load(&bytes).expect("version 3 is still read");
    assert!(model.header.corrected());
    assert_eq!(model.header.known(), KnownGroups::KINEMATICS);
    // Written again in the present format it states them.
    let (header, parts) = read::parts(&bytes).expect("sound");
    let again = AlignedBytes::copy(&blob(header, &parts).expect("a blob"));
    let again = Model::load(&again).expect("sound");
    assert_eq!(
        (again.header.stated_known, again.header.known()),
        (KnownGroups::KINEMATICS, KnownGroups::KINEMATICS)
    );
}

/// The field of a turn has no number of a group that the model does not know, whatever groups are decoded.
#[test]
fn a_turn_writes_no_number_of_an_unknown_group() {
    let known = KnownGroups::KINEMATICS.with(FieldGroup::ShearStress);
    let header = Header { stated_known: known, ..support::header() };
    let bytes = AlignedBytes::copy(&blob(header, &support::parts(1, 0.1)).expect("a blob"));
    let model = Model::load(&bytes).expect("sound");
    let written = |groups: Selection| {
        let estimator = Estimator::new(&model).only(groups);
        let mut field = vec![0.0; estimator.field_len()];
        let mut clock = Monotonic::start();
        let input = TurnInput::default();
        assert!(estimator.turn(&mut Memory::default(), input, &mut clock, &mut field).field_fresh);
        field
    };
    let sizes = [3, 3, 1, 3, 3].map(|components| components * support::PARTICLES);
    let mut field = written(Selection::ALL);
    for (size, known) in sizes.into_iter().zip([true, false, false, false, true]) {
        let rest = field.split_off(size);
        assert!(field.iter().all(|number| number.is_finite() == known));
        field = rest;
    }
    // Internal energy and shear stress alone.
    let field = written(Selection::NONE.with(2).with(4));
    let (energy, stress) = field.split_at(sizes[2]);
    assert!(energy.iter().all(|e| e.is_nan()) && stress.iter().all(|tau| tau.is_finite()));
}

/// Latents after 20 turns of one tilted profile under the filter settings `filter`.
fn settled(filter: FilterConfig) -> [f64; 13] {
    let known = KnownGroups::NONE.with(FieldGroup::Surface);
    let header = Header { model_version: 41, stated_known: known, filter, ..support::header() };
    let bytes = AlignedBytes::copy(&blob(header, &support::parts(1, 0.1)).expect("a blob"));
    assert_eq!(bytes[8], VERSION as u8);
    let model = Model::load(&bytes).expect("a sound blob");
    assert_eq!((model.header.model_version, model.header.known()), (41, known));
    assert_eq!(model.header.filter, filter);
    let profile = SurfaceProfile {
        height_m: std::array::from_fn(|i| 0.07 + 1e-3 * (i as f32 - 10.0)),
        variance_m2: [1e-8; POINTS],
        valid: [true; POINTS],
        glass_x_m: Some(0.0),
        sequence: 0,
        captured: Micros(0),
    };
    let (estimator, mut memory) = (Estimator::new(&model), Memory::default());
    let mut clock = Monotonic::start();
    let turns =
        (0..20).map(|_| estimator.turn(&mut memory, TurnInput::tracked(&profile), &mut clock, &mut []));
    turns.last().expect("20 turns").latent
}

/// The settings travel in the blob and the filter works by them: a wider prior of the cross-axis slosh, and a smaller
/// noise of the input, each lead to another estimate.
#[test]
fn a_new_blob_carries_the_settings_that_the_filter_works_by() {
    let reference = settled(FilterConfig::REFERENCE);
    assert_eq!(settled(FilterConfig::REFERENCE), reference, "the same settings, the same bits");
    for other in [
        FilterConfig { lateral_prior_mm: 50.0, ..FilterConfig::REFERENCE },
        FilterConfig { input_noise_std: 0.01, ..FilterConfig::REFERENCE },
        FilterConfig { innovation_gate: 0.5, ..FilterConfig::REFERENCE },
    ] {
        assert_ne!(settled(other), reference, "{other:?}");
    }
}

#[test]
fn settings_that_no_filter_can_have_are_refused_by_name() {
    let hostile = |filter: FilterConfig| {
        let header = Header { filter, ..support::header() };
        refusal(&blob(header, &support::parts(1, 0.1)).expect("a blob"))
    };
    let error = hostile(FilterConfig { input_noise_std: f64::NAN, ..FilterConfig::REFERENCE });
    assert!(matches!(error, LoadError::HeaderValue { field: "filter.input_noise_std", .. }), "{error}");
    let error = hostile(FilterConfig { position_gate: -30.0, ..FilterConfig::REFERENCE });
    assert!(error.to_string().contains("filter.position_gate is -30"), "{error}");
}

#[test]
fn a_weight_that_is_not_a_number_is_found() {
    for weight in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let bytes = sound();
        let model = AlignedBytes::copy(&bytes);
        let model = Model::load(&model).expect("sound");
        let section = model.header.sections.iter().find(|s| s.tensor == Tensor::EnergyIn).expect("there");
        let at = section.offset as usize + 4 * 70;
        let mut bytes = bytes.clone();
        bytes[at..at + 4].copy_from_slice(&weight.to_le_bytes());
        let error = refusal(&sealed(bytes));
        assert_eq!(error, LoadError::NotFinite { tensor: Tensor::EnergyIn, index: 70 });
    }
}

#[test]
fn errors_that_cannot_be_are_refused() {
    type Spoil = fn(&mut [f32]);
    let hostile: [(Tensor, Spoil); 5] = [
        // A covariance with a negative direction, one that is not symmetric, and numbers below zero.
        (Tensor::ProcessSpread, |q| q.iter_mut().for_each(|q| *q = -*q)),
        (Tensor::ReadingSpread, |r| r[1] = 2.0 * r[1] + 1.0),
        (Tensor::SurfaceMisfit, |d| d[20] = -1e-12),
        (Tensor::GroupMisfit, |d| d[0] = -1.0),
        (Tensor::Reach, |k| k[3] = -0.5),
    ];
    for (tensor, spoil) in hostile {
        let mut parts = support::parts(1, 0.1);
        parts.iter_mut().filter(|part| part.tensor == tensor).for_each(|part| spoil(&mut part.values));
        let error = refusal(&blob(support::header(), &parts).expect("a blob"));
        assert_eq!(error, LoadError::NotACovariance { tensor });
        assert!(error.to_string().contains("--intervals-of"), "{error}");
    }
}

/// A blob with a friction law has it in its step; numbers that no law has are refused.
#[test]
fn a_friction_law_is_read_and_checked() {
    let with = |values: [f32; 4]| {
        let mut parts = support::parts(1, 0.1);
        parts.push(Part { tensor: Tensor::FrictionLaw, rows: 4, columns: 1, values: values.to_vec() });
        blob(support::header(), &parts).expect("a blob")
    };
    let sound = AlignedBytes::copy(&with([2.0, 0.5, 0.25, 0.5]));
    let law = Model::load(&sound).expect("a sound blob").generic.law.expect("a law");
    assert_eq!(law.numbers(), [2.0, 0.5, 0.25, 0.5]);
    for hostile in [[0.0, 0.5, 0.2, 0.5], [2.0, 0.0, 0.2, 0.5], [2.0, 0.5, 1.5, 0.5], [2.0, 0.5, 0.2, -0.1]] {
        let error = refusal(&with(hostile));
        assert_eq!(error, LoadError::FrictionLaw, "{hostile:?}");
        assert!(error.to_string().contains("meniscus learn"), "{error}");
    }
}

#[test]
fn a_missing_tensor_and_a_wrong_shape_are_named() {
    let mut parts = support::parts(1, 0.1);
    parts.retain(|part| part.tensor != Tensor::Port);
    let error = refusal(&blob(support::header(), &parts).expect("a blob"));
    assert_eq!(error, LoadError::Missing { tensor: Tensor::Port });

    let mut parts = support::parts(1, 0.1);
    for part in parts.iter_mut().filter(|part| part.tensor == Tensor::TrunkWeight(1)) {
        part.columns = 32;
        part.values.truncate(64 * 32);
    }
    let error = refusal(&blob(support::header(), &parts).expect("a blob"));
    assert_eq!(error, LoadError::Shape { tensor: Tensor::TrunkWeight(1), found: (64, 32) });
}

#[test]
fn a_header_that_no_glass_can_have_is_refused() {
    let mut header = support::header();
    header.dt_s = f64::NAN;
    let error = refusal(&blob(header, &support::parts(1, 0.1)).expect("a blob"));
    assert!(matches!(error, LoadError::HeaderValue { field: "dt_s", .. }), "{error}");

    let mut header = support::header();
    header.rim_m = 0.05;
    let error = refusal(&blob(header, &support::parts(1, 0.1)).expect("a blob"));
    assert!(error.to_string().contains("rim"), "{error}");
}

#[test]
fn a_blob_off_its_boundary_is_refused() {
    let bytes = sound();
    let mut shifted = vec![0; bytes.len() + 1];
    shifted[1..].copy_from_slice(&bytes);
    let aligned = AlignedBytes::copy(&shifted);
    let error = Model::load(&aligned[1..]).map(|_| ()).expect_err("off its boundary");
    assert_eq!(error, LoadError::Misaligned);
}

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
