//! Data that a page loads once: the glass, the names of the numbers, and the bases of the full field.
//!
//! ```text
//! group = rest + sum_j c_j basis_j      basis_j = scale_j (whole numbers from -32767 to 32767)
//! ```
//! Sixteen bits keep each number of a basis to 1.5e-5 of its largest, a hundredth of what the estimate may be off.
//!
//! A group that the model does not know has no basis and no numbers: the page cannot show it. The positions at rest always
//! travel, because they say where a tracer is drawn.

use super::frame::{AHEAD, NUMBERS, PROFILES};
use meniscus::blob::{FieldGroup, Model};
use meniscus::latent::decoder::{GROUP_COMPONENTS, Group};
use meniscus::latent::nn::Weights;
use meniscus::runtime::DEADLINE_US;
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus_data::validity::Validity;
use serde_json::json;

/// Names of the field groups, with their units.
const GROUPS: [(&str, &str); 5] = [("q", "m"), ("v", "m/s"), ("e", "J/kg"), ("sigma", "Pa"), ("tau", "Pa")];

/// Largest whole number of a basis.
const LARGEST: f32 = 32767.0;

/// Part of a group that travels.
#[derive(Clone, Copy)]
struct SentGroup<'m> {
    known: bool,
    rest: &'m [f32],
    basis: Weights<'m>,
    columns: usize,
}

/// Returns what travels of each group.
fn sent<'m>(model: &Model<'m>) -> Vec<SentGroup<'m>> {
    let known = model.header.known();
    let part = |(group, kind): (Group<'m>, FieldGroup)| {
        let Group { rest, basis, .. } = group;
        let (known, place) = (known.contains(kind), kind == FieldGroup::Position);
        let rest = if known || place { rest } else { &[] };
        SentGroup { known, rest, basis, columns: if known { basis.columns() } else { 0 } }
    };
    model.decoder.groups.into_iter().zip(FieldGroup::ALL).map(part).collect()
}

/// The bytes: the length of the JSON text as four bytes, the text, spaces up to a multiple of four, then for each
/// group its rest and its scales as `f32` and its basis column by column as `i16`, little-endian.
pub(super) fn bases(model: &Model<'_>, title: &str) -> Vec<u8> {
    let header = &model.header;
    let validity = Validity::of(header);
    let sent = sent(model);
    let groups = sent.iter().zip(GROUPS).zip(GROUP_COMPONENTS);
    let groups: Vec<_> = groups
        .map(|((sent, (name, unit)), components)| {
            json!({ "name": name, "unit": unit, "components": components, "known": sent.known,
                    "numbers": sent.rest.len(), "rank": sent.columns })
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
        "known": validity.names(),
        "unknown": validity.sentence,
    });
    let mut text = text.to_string();
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    let mut bytes = Vec::with_capacity(text.len() + 64 * model.field_len());
    bytes.extend_from_slice(&u32::try_from(text.len()).unwrap_or(0).to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
    for SentGroup { rest, basis, columns, .. } in sent {
        let column = |column: usize| (0..rest.len()).map(move |row| basis.at(row, column));
        let scales: Vec<f32> = (0..columns)
            .map(|index| column(index).fold(0.0, |most: f32, number| most.max(number.abs())) / LARGEST)
            .collect();
        rest.iter().chain(&scales).for_each(|number| bytes.extend_from_slice(&number.to_le_bytes()));
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
