//! Header fields: the format version, the known groups of the field, the settings of the filter.

use super::{refusal, sealed, sound, support};
use meniscus::blob::{
    BEFORE, Extension, FieldGroup, FilterConfig, Header, KnownGroups, LoadError, Model, OLDEST_VERSION,
    PREFIX_LEN, VERSION,
};
use meniscus::latent::decoder::Selection;
use meniscus::runtime::{Estimator, Memory, TurnInput};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::Micros;
use meniscus_data::blob_file::read;
use meniscus_data::blob_file::write::blob;
use meniscus_platform::clock::Monotonic;
use meniscus_platform::files::AlignedBytes;

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
