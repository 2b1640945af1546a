//! Glasses that are no cylinders: the first mode of a cone and of a wine glass, their volume and their centre of mass.

use super::first_mode::FirstMode;
use super::fit::fit;
use super::ring_down::setup;
use super::theory::Tone;
use crate::{Error, Setup, Simulator};
use meniscus_data::glass::{Glass, Profile, WallShape};
use meniscus_data::liquids::Rheology;
use meniscus_numerics::quadrature::gauss_legendre;
use std::f64::consts::PI;

/// Speed of the mode at the edge of the surface when it starts, m/s.
const START_M_S: f64 = 0.05;

/// Start of the fit, s: by then sound has died away.
const AFTER_S: f64 = 0.05;

/// A tumbler whose side leans by 8.5 degrees.
pub(super) const CONE: Glass =
    Glass { radius_m: 0.028, fill_m: 0.06, rim_m: 0.1, wall: WallShape::Straight { taper: 0.15 } };

/// Heights and radii of the inside of a wine glass, m: round below, widest at half its height, narrower at the rim.
const WINE: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [0.003, 0.0145],
    [0.008, 0.0225],
    [0.016, 0.0295],
    [0.028, 0.035],
    [0.042, 0.038],
    [0.058, 0.0385],
    [0.078, 0.0355],
    [0.1, 0.031],
];

/// Figures of one glass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shaped {
    /// Relative error of the first mode's frequency against Ritz's method, signed, per cent.
    pub(super) frequency_error: f64,
    /// Relative error of the volume of the settled liquid against the integral of the profile, per cent.
    pub(super) volume_error: f64,
    /// Deviation of the height of the centre of mass of the settled liquid, as a part of the fill, per cent.
    pub(super) centre_error: f64,
}

/// The wine glass, filled to 60 mm.
///
/// # Errors
/// When its points are no profile.
pub(super) fn wine_glass() -> Result<Glass, Error> {
    let profile = Profile::new(&WINE).map_err(|e| Error::Setup(format!("{e}")))?;
    Ok(Glass::curved(profile, 0.06, 0.1))
}

/// Lets the first mode ring for `seconds` in `glass`, without viscosity, in the packing of particles with the seed `packing`.
///
/// # Errors
/// As for [`Simulator::new`] and [`Simulator::step`], and where no oscillation is determined.
pub(super) fn shaped(
    glass: Glass,
    spacing_m: f64,
    packing: u64,
    seconds: f64,
    mut watch: impl FnMut(f64),
) -> Result<Shaped, Error> {
    let undetermined = || Error::Setup("the first mode of the glass is not determined".into());
    let mode = FirstMode::new(&glass).ok_or_else(undetermined)?;
    let setup = Setup { glass, seed: packing, ..setup(Rheology::newtonian(0.0), spacing_m, true) };
    let mut simulator = Simulator::new(&setup)?;
    // By volume: the weak compression of the simulator makes the liquid below heavier than any real one is.
    let particles = &simulator.fluid.particle;
    let volume: f64 = particles.iter().map(|p| p.volume).sum();
    let moment: f64 = particles.iter().map(|p| p.volume * p.x[2]).sum();
    let (truth, centre_m) = (glass.volume_m3(0.0, glass.fill_m), centre_m(&glass));

    simulator.set_velocity(|x| mode.velocity(x).map(|v| START_M_S * v));
    let mut series = Vec::new();
    while simulator.time_s() < seconds {
        simulator.step(|_| 0.0)?;
        if simulator.time_s() > AFTER_S {
            let along = |(x, v, m): ([f64; 3], [f64; 3], f64)| {
                m * mode.velocity(x).iter().zip(v).map(|(e, v)| e * v).sum::<f64>()
            };
            series.push((simulator.time_s(), simulator.motion().map(along).sum()));
        }
        watch(simulator.time_s() / seconds);
    }
    let found = fit(&series, Tone { hz: mode.hz(), decay: 0.1 }, &[]).ok_or_else(undetermined)?;
    Ok(Shaped {
        frequency_error: 100.0 * (found.tone.hz / mode.hz() - 1.0),
        volume_error: 100.0 * (volume / truth - 1.0).abs(),
        centre_error: 100.0 * (moment / volume - centre_m).abs() / glass.fill_m,
    })
}

/// Height of the centre of mass of the liquid at rest, m: `int pi r^2 z dz / V`.
fn centre_m(glass: &Glass) -> f64 {
    const NODES: usize = 60;
    let moment = |(z, over_z): (f64, f64)| PI * glass.radius_at(z).powi(2) * z * over_z;
    gauss_legendre(NODES, glass.fill_m).into_iter().map(moment).sum::<f64>()
        / glass.volume_m3(0.0, glass.fill_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At a coarse spacing; the table has 5 mm. Frequencies of packings are 0.2 % apart there: the mean of three is judged.
    #[test]
    fn cone_and_wine_glass_slosh_at_their_own_frequency() {
        let narrow =
            Glass { radius_m: 0.043, fill_m: 0.06, rim_m: 0.1, wall: WallShape::Straight { taper: -0.1 } };
        let wine = wine_glass().expect("a glass");
        for (name, glass) in [("cone", CONE), ("narrowing cone", narrow), ("wine glass", wine)] {
            let mut frequency_error = 0.0;
            for packing in 0..3 {
                let found = shaped(glass, 0.007, packing, 0.6, |_| ()).expect("it rings");
                println!("{name}, packing {packing}: {found:?}");
                assert!(found.volume_error < 0.05 && found.centre_error < 0.8, "{name}: {found:?}");
                frequency_error += found.frequency_error / 3.0;
            }
            assert!(frequency_error.abs() < 1.0, "{name}: {frequency_error} %");
        }
    }
}
