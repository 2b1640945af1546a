//! Data that a page loads once: the glass, the names of the numbers, and the bases of the full field.
//!
//! ```text
//! group = rest + sum_j c_j basis_j      basis_j = scale_j (whole numbers from -32767 to 32767)
//! ```
//! Sixteen bits keep each number of a basis to 1.5e-5 of its largest, a hundredth of what the estimate may be off.

use super::frame::{AHEAD, NUMBERS, PROFILES};
use meniscus::blob::Model;
use meniscus::latent::decoder::GROUP_COMPONENTS;
use meniscus::runtime::DEADLINE_US;
use meniscus::surface::{POINTS, profile_abscissa};
use serde_json::json;

/// Names of the field groups, with their units.
const GROUPS: [(&str, &str); 5] = [("q", "m"), ("v", "m/s"), ("e", "J/kg"), ("sigma", "Pa"), ("tau", "Pa")];

/// Largest whole number of a basis.
const LARGEST: f32 = 32767.0;

/// The bytes: the length of the JSON text as four bytes, the text, spaces up to a multiple of four, then for each
/// group its rest and its scales as `f32` and its basis column by column as `i16`, little-endian.
pub(super) fn bases(model: &Model<'_>, title: &str) -> Vec<u8> {
    let header = &model.header;
    let groups = model.decoder.groups.iter().zip(GROUPS).zip(GROUP_COMPONENTS);
    let groups: Vec<_> = groups
        .map(|((group, (name, unit)), components)| {
            json!({ "name": name, "unit": unit, "components": components,
                    "numbers": group.rest.len(), "rank": group.basis.columns() })
        })
        .collect();
    let text = json!({
        "title": title,
        "version": env!("CARGO_PKG_VERSION"),
        "liquid": header.liquid.as_str(),
        "tracers": header.particles,
        "radius_m": header.radius_m, "fill_m": header.fill_m, "rim_m": header.rim_m,
        "turn_s": header.dt_s,
        "deadline_us": DEADLINE_US,
        "abscissae": (0..POINTS).map(profile_abscissa).collect::<Vec<_>>(),
        "ahead_s": AHEAD.map(|turns| turns as f64 * header.dt_s),
        "profiles": PROFILES,
        "numbers": NUMBERS.map(|(name, _)| name).to_vec(),
        "groups": groups,
    });
    let mut text = text.to_string();
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    let mut bytes = Vec::with_capacity(text.len() + 64 * model.field_len());
    bytes.extend_from_slice(&u32::try_from(text.len()).unwrap_or(0).to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
    for group in &model.decoder.groups {
        let (rows, columns) = (group.rest.len(), group.basis.columns());
        let column = |column: usize| (0..rows).map(move |row| group.basis.at(row, column));
        let scales: Vec<f32> = (0..columns)
            .map(|index| column(index).fold(0.0, |most: f32, number| most.max(number.abs())) / LARGEST)
            .collect();
        group.rest.iter().chain(&scales).for_each(|number| bytes.extend_from_slice(&number.to_le_bytes()));
        for (index, scale) in scales.iter().enumerate() {
            for number in column(index) {
                // A column of zeros has no scale, and its zeros need none.
                let whole = if *scale > 0.0 { (number / scale).round() as i16 } else { 0 };
                bytes.extend_from_slice(&whole.to_le_bytes());
            }
        }
        while !bytes.len().is_multiple_of(4) {
            bytes.push(0);
        }
    }
    bytes
}
