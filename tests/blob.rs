//! A bad blob is refused, each kind with its own error.

#[path = "blob/bases.rs"]
mod bases;
#[path = "blob/loading.rs"]
mod loading;
mod support;
#[path = "blob/versions.rs"]
mod versions;

use meniscus::blob::{CRC, LoadError, Model, PREFIX_LEN, Tensor};
use meniscus_data::blob_file::write::{Part, blob};
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
