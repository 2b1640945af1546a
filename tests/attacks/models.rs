//! Attacks by resealed models: their checksum is right, and what they hold is not.

use crate::meet::{judged, meet};
use crate::resealed::resealed;
use crate::support::{Scratch, meniscus_command};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The shipped model with `new` in the place of the first `old` in its header, resealed.
fn altered(old: &[u8], new: &[u8]) -> Vec<u8> {
    let mut blob = meniscus_shipped::MODEL.to_vec();
    let at = blob[..600].windows(old.len()).position(|part| part == old).expect("in the header");
    blob[at..at + old.len()].copy_from_slice(new);
    resealed(blob)
}

/// A resealed model with numbers that no glass has is refused in words.
///
/// Time step, radius and fill that are no number, infinite, negative or zero; another number of tracers; a header that ends
/// early, and one that claims 4 GiB.
#[test]
fn a_resealed_model_of_no_glass_is_refused() {
    let scratch = Scratch::new("no-glass");
    let header = meniscus::blob::Model::load(&crate::support::blob()).expect("sound").header.clone();
    let mut bombs: Vec<(String, Vec<u8>)> = Vec::new();
    for (field, value) in [("dt_s", header.dt_s), ("radius_m", header.radius_m), ("fill_m", header.fill_m)] {
        for wrong in [f64::NAN, f64::INFINITY, -value, 0.0] {
            bombs.push((format!("{field} {wrong}"), altered(&value.to_le_bytes(), &wrong.to_le_bytes())));
        }
    }
    // A varint of two bytes in front of the time step: the number of tracers.
    let tracers = |count: u32| [(count & 127 | 128) as u8, (count >> 7) as u8];
    bombs.push(("tracers".into(), altered(&tracers(header.particles), &tracers(header.particles + 1))));
    for length in [3_u32, 200, u32::MAX] {
        let mut blob = meniscus_shipped::MODEL.to_vec();
        blob[12..16].copy_from_slice(&length.to_le_bytes());
        bombs.push((format!("header of {length} bytes"), resealed(blob)));
    }
    for (name, blob) in bombs {
        fs::write(scratch.0.join("a.blob"), blob).expect("written");
        let met = meet(&scratch.0, &["run", "--model", "a.blob", "--patient", "--seconds", "1.5"]);
        judged(&met, &name, "the model a.blob is refused: ");
    }
}

/// Runs the model at `path` for two seconds; the report and what was said.
fn report(folder: &Path, name: &str) -> (Option<Value>, String) {
    let output = meniscus_command()
        .args(["run", "--model", name, "--patient", "--seconds", "2", "--json", "--out", "out"])
        .current_dir(folder)
        .output()
        .expect("it starts");
    (serde_json::from_slice(&output.stdout).ok(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// A resealed model with hostile weights is refused, or runs to its end without a fall of entropy.
///
/// Weights of energy, friction, port and encoder that are multiplied by 1e3 and 1e18, that have their signs turned and that
/// are zero.
#[test]
fn hostile_weights_keep_the_second_law() {
    use meniscus::blob::Tensor;
    let scratch = Scratch::new("weights");
    let sound = meniscus_shipped::MODEL;
    let header = meniscus::blob::Model::load(&crate::support::blob()).expect("sound").header.clone();
    let tensors = [
        Tensor::FrictionFactor,
        Tensor::SkewLower,
        Tensor::EnergyLinear,
        Tensor::EnergyIn,
        Tensor::Port,
        Tensor::Preconditioner,
        Tensor::HeadWeight,
    ];
    let mut ran = 0;
    for tensor in tensors {
        let section = header.sections.iter().find(|section| section.tensor == tensor).expect("a section");
        let (from, count) = (section.offset as usize, (section.rows * section.columns) as usize);
        for factor in [1e3, 1e18, -1.0, 0.0] {
            let mut blob = sound.to_vec();
            for number in blob[from..from + 4 * count].chunks_exact_mut(4) {
                let weight = f32::from_le_bytes([number[0], number[1], number[2], number[3]]);
                number.copy_from_slice(&(weight * factor).to_le_bytes());
            }
            fs::write(scratch.0.join("a.blob"), resealed(blob)).expect("written");
            let (report, said) = report(&scratch.0, "a.blob");
            assert!(!said.contains("panicked"), "{tensor:?} times {factor}: {said}");
            let Some(report) = report else {
                assert!(said.contains("error: "), "{tensor:?} times {factor}: {said}");
                continue;
            };
            ran += 1;
            let checks = report["checks"].as_array().expect("checks");
            let falls = checks.iter().find(|check| check["name"] == "entropy_falls").expect("a check");
            assert_eq!(falls["value"], 0.0, "{tensor:?} times {factor}: {falls}");
        }
    }
    assert!(ran >= 20, "{ran} models ran");
}
