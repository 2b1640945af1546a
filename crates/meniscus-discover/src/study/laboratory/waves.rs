//! Waves of a glass with their coefficients: masses, springs, and the pieces of bulk and wall that rub.

use super::glass::{LaboratoryGlass, Liquid};
use super::layer::Layer;
use super::shapes::{Patch, Shape, Strained};

/// Azimuthal order and zero of each wave: four along x, two rings, two saddles.
pub(super) const WAVES: [(u32, f64); 8] = [
    (1, 1.841_183_8),
    (1, 5.331_442_8),
    (1, 8.536_316_4),
    (1, 11.706_004_9),
    (0, 3.831_706_0),
    (0, 7.015_586_7),
    (2, 3.054_236_9),
    (2, 6.706_133_2),
];

/// Waves along x.
pub(super) const ALONG: usize = 4;

/// One wave with its coefficients.
pub(super) struct Wave {
    pub(super) mass_kg: f64,
    pub(super) stiffness: f64,
    /// Force for each m/s2 of the glass, kg.
    pub(super) driven_kg: f64,
    /// C over kappa1, and D kappa over kappa1 squared, of a ring or a saddle, 1/m.
    pub(super) second: [f64; 2],
    /// Integral of `2 e:e` over the bulk at the unit rate, m.
    pub(super) strain_m: f64,
    /// The bulk in pieces, where the viscosity differs from piece to piece.
    pub(super) bulk: Vec<Strained>,
    /// The wall in pieces, each with a layer; one piece of speed one where the layers are alike.
    pub(super) wall: Vec<(Patch, Layer)>,
}

/// Returns the friction of a `piece` of the bulk at a rate of the wave, N s/m.
pub(super) fn resistance(liquid: &Liquid, piece: &Strained, rate: f64) -> f64 {
    piece.volume_m3 * piece.shear * piece.shear * liquid.viscosity(piece.shear * rate.abs())
}

/// Returns wave number `n` of `glass` with the `shape`, beside the shape of the `first`.
pub(super) fn wave(glass: &LaboratoryGlass, first: &Shape, n: usize, shape: Shape) -> Wave {
    let liquid = &glass.liquid;
    let [frequency, damping, _] = glass.differs;
    let area = shape.over_surface(|x, y| shape.height(x, y).powi(2));
    let tension =
        liquid.tension_n_m * shape.over_surface(|x, y| shape.slope(x, y).iter().map(|s| s * s).sum());
    let mass_kg = liquid.density_kg_m3 * area / shape.steepness();
    let stiffness = (liquid.density_kg_m3 * glass.gravity_m_s2 * area + tension) * (1.0 + frequency).powi(2);
    let driven_kg = liquid.density_kg_m3 * shape.over_surface(|x, y| x * shape.height(x, y));
    let mut strained = shape.strained();
    strained.iter_mut().for_each(|piece| piece.volume_m3 *= 1.0 + damping);
    let strain_m = strained.iter().map(|piece| piece.volume_m3 * piece.shear * piece.shear).sum();
    let mut patches = shape.patches();
    patches.iter_mut().for_each(|patch| patch.area_m2 *= 1.0 + damping);
    let thickness = |viscosity: f64| {
        let plain = (stiffness / mass_kg).sqrt();
        (2.0 * viscosity / (liquid.density_kg_m3 * plain)).sqrt()
    };
    // The pieces differ only in the first wave of a liquid that thins or stands.
    let apart = n == 0 && !liquid.is_linear();
    if !apart {
        let whole = patches.iter().map(|patch| patch.area_m2 * patch.speed * patch.speed).sum();
        patches = vec![Patch { area_m2: whole, speed: 1.0 }];
    }
    // Of a liquid that thins, the layer is about as thick as at the rate of a middling slosh.
    let layer = Layer::new(thickness(liquid.viscosity(30.0)));
    let wall = patches.into_iter().map(|patch| (patch, layer.clone())).collect();
    let second = if n < ALONG { [0.0; 2] } else { second_order(first, &shape, area) };
    Wave {
        mass_kg,
        stiffness,
        driven_kg: if shape.order == 1 { driven_kg } else { 0.0 },
        second,
        strain_m,
        bulk: if apart { strained } else { Vec::new() },
        wall,
    }
}

/// Returns `C/kappa1` and `D kappa/kappa1^2` of a wave of `shape` whose height has the square `area` over the surface, 1/m.
fn second_order(first: &Shape, shape: &Shape, area: f64) -> [f64; 2] {
    let (kappa1, kappa) = (first.steepness(), shape.steepness());
    let carried = shape.over_surface(|x, y| {
        let ([ax, ay], [bx, by]) = (first.slope(x, y), shape.slope(x, y));
        let (a, b) = (first.height(x, y), shape.height(x, y));
        a * (ax * bx + ay * by) - kappa1 * kappa * a * a * b
    });
    let flow = shape.over_surface(|x, y| {
        let [ax, ay] = first.slope(x, y);
        let (a, b) = (first.height(x, y), shape.height(x, y));
        0.5 * (ax * ax + ay * ay - kappa1 * kappa1 * a * a) * b
    });
    [carried / area / kappa1, flow / area * kappa / (kappa1 * kappa1)]
}
