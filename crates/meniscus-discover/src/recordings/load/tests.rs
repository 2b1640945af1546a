//! Names of the numbers in setup.toml.

use super::*;

#[test]
fn shares_are_read_by_their_names_and_by_their_old_ones() {
    let glass = "radius_m = 0.035\nfill_m = 0.07\ndensity_kg_m3 = 1261.0\nviscosity_pa_s = 0.95\n";
    let shares = |lines: &str| {
        let setup: Setup = toml::from_str(&format!("{glass}{lines}")).expect("a setup");
        [setup.tilt_share, setup.vertical_share]
    };
    assert_eq!(shares(""), [1.0, 1.0]);
    assert_eq!(shares("tilt_share = 0.5\nvertical_share = 0.0"), [0.5, 0.0]);
    assert_eq!(shares("tilt_told = 0.5\nvertical_told = 0.0"), [0.5, 0.0]);
}
