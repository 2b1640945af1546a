//! Fields at the tracers: first-order moving least squares over the particles.
//!
//! Around a tracer each field is fitted by a plane, `f(x) = c0 + c . (x - x_t)`, with weights
//! `V W(x - x_t)`; `c0` is its value there, and the velocity's `c` is its gradient `G`. With
//! `D = (G + G^T)/2` and the viscosity mu at the rate `sqrt(2 D:D)`:
//! ```text
//! sigma_ii = -p + 2 mu D_ii,   tau_ij = 2 mu D_ij
//! ```

use super::surface::Nearby;
use crate::Simulator;
use meniscus::latent::decoder::GROUP_COMPONENTS;
use meniscus_data::recording::{COLUMNS, LAYERS, Lattice, TRACERS};
use nalgebra::{Matrix4, SMatrix};
use rayon::prelude::*;

/// Numbers of one sample: v, e, sigma, tau of every tracer, group after group.
pub(crate) const FIELDS: usize = 10 * TRACERS;

/// Fields of one tracer: velocity, specific heat, normal stresses, shear stresses.
type Values = [f64; 10];

/// Samples all tracers under a surface of heights `column_m`; `nearby` lists particles by column.
pub(crate) fn sample(
    simulator: &Simulator,
    lattice: &Lattice,
    nearby: &[Nearby],
    column_m: &[f32],
) -> Vec<f32> {
    let values: Vec<Values> = (0..COLUMNS)
        .into_par_iter()
        .flat_map_iter(|column| {
            (0..LAYERS).map(move |layer| {
                let at = lattice.tracer(column, layer, f64::from(column_m[column]));
                fit(simulator, &nearby[column], at)
            })
        })
        .collect();
    let mut out = Vec::with_capacity(FIELDS);
    let mut first = 0;
    for width in &GROUP_COMPONENTS[1..] {
        for value in &values {
            out.extend(value[first..first + width].iter().map(|v| *v as f32));
        }
        first += width;
    }
    out
}

/// The fields at one point.
fn fit(simulator: &Simulator, nearby: &Nearby, at: [f64; 3]) -> Values {
    let kernel = &simulator.forces.kernel;
    let inverse = 1.0 / kernel.h;
    let mut moments = Matrix4::<f64>::zeros();
    let mut right = SMatrix::<f64, 4, 5>::zeros();
    for &(i, _) in nearby {
        let p = &simulator.fluid.particle[i as usize];
        let d = [p.x[0] - at[0], p.x[1] - at[1]];
        let dz = p.x[2] - at[2];
        let r2 = d[0] * d[0] + d[1] * d[1] + dz * dz;
        if r2 >= kernel.support2 {
            continue;
        }
        let weight = p.volume * kernel.value(r2);
        let b = [1.0, d[0] * inverse, d[1] * inverse, dz * inverse];
        let f = [p.v[0], p.v[1], p.v[2], p.p, simulator.fluid.heat[i as usize]];
        for row in 0..4 {
            let scaled = weight * b[row];
            for column in row..4 {
                moments[(row, column)] += scaled * b[column];
            }
            for (column, f) in f.iter().enumerate() {
                right[(row, column)] += scaled * f;
            }
        }
    }
    for row in 1..4 {
        for column in 0..row {
            moments[(row, column)] = moments[(column, row)];
        }
    }
    // Too few particles for a plane (a splash): their mean; none at all: nothing moves there.
    let solved = match moments.cholesky() {
        Some(factor) if factor.determinant() > 1e-6 * moments[(0, 0)].powi(4) => factor.solve(&right),
        _ => {
            let mut mean = SMatrix::<f64, 4, 5>::zeros();
            if moments[(0, 0)] > 0.0 {
                mean.set_row(0, &(right.row(0) / moments[(0, 0)]));
            }
            mean
        }
    };
    stresses(simulator, &solved, inverse)
}

/// Values and stresses from the fitted planes; their slopes are in units of `1/inverse`.
fn stresses(simulator: &Simulator, solved: &SMatrix<f64, 4, 5>, inverse: f64) -> Values {
    // d(i, j): derivative of velocity i along axis j.
    let d = |i: usize, j: usize| solved[(j + 1, i)] * inverse;
    let normal = [d(0, 0), d(1, 1), d(2, 2)];
    let shear = [d(0, 1) + d(1, 0), d(1, 2) + d(2, 1), d(2, 0) + d(0, 2)];
    let rate2 = 2.0 * normal.iter().map(|n| n * n).sum::<f64>() + shear.iter().map(|s| s * s).sum::<f64>();
    let mu = simulator.liquid.rheology.viscosity(rate2.sqrt());
    let p = solved[(0, 3)];
    let [sx, sy, sz] = normal.map(|n| 2.0 * mu * n - p);
    let [txy, tyz, tzx] = shear.map(|s| mu * s);
    [solved[(0, 0)], solved[(0, 1)], solved[(0, 2)], solved[(0, 4)], sx, sy, sz, txy, tyz, tzx]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Setup;
    use crate::output::surface::SurfaceFinder;
    use crate::setup::small_glass;
    use meniscus_data::liquids::Rheology;

    #[test]
    fn a_linear_flow_comes_back_with_its_stresses() {
        let setup = Setup { spacing_m: 0.00875, ..small_glass(1261.0, Rheology::newtonian(0.95)) };
        let glass = setup.glass;
        let mut simulator = Simulator::new(&setup).expect("the glass settles");
        simulator.set_velocity(|[x, y, z]| [2.0 * z, 0.5 * x, 3.0 * y - z]);
        let finder = SurfaceFinder::new(&simulator).expect("the surface is fitted");
        let nearby = finder.nearby(&simulator);
        let (columns, _) = finder.heights(&finder.coefficients(&simulator, &nearby));
        let lattice = Lattice::new(&glass);
        let out = sample(&simulator, &lattice, &nearby[..COLUMNS], &columns);
        for tracer in 0..TRACERS {
            let [x, y, z] =
                lattice.tracer(tracer / LAYERS, tracer % LAYERS, f64::from(columns[tracer / LAYERS]));
            let v = &out[3 * tracer..3 * tracer + 3];
            let sigma = &out[4 * TRACERS + 3 * tracer..4 * TRACERS + 3 * tracer + 3];
            let tau = &out[7 * TRACERS + 3 * tracer..7 * TRACERS + 3 * tracer + 3];
            for (found, truth) in v.iter().zip([2.0 * z, 0.5 * x, 3.0 * y - z]) {
                assert!((f64::from(*found) - truth).abs() < 1e-6, "v {found} for {truth} at tracer {tracer}");
            }
            for (found, truth) in tau.iter().zip([0.95 * 0.5, 0.95 * 3.0, 0.95 * 2.0]) {
                assert!(
                    (f64::from(*found) - truth).abs() < 1e-4,
                    "tau {found} for {truth} at tracer {tracer}"
                );
            }
            // sigma_xx - sigma_zz = 2 mu (D_xx - D_zz) = 2 mu.
            assert!(
                (f64::from(sigma[0] - sigma[2]) - 1.9).abs() < 1e-3,
                "sigma {sigma:?} at tracer {tracer}"
            );
        }
    }
}
