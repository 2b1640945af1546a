//! The exact GENERIC step in double precision: what the warm start, the filter and the reports use,
//! and what the roll-out through burn must agree with.
//!
//! E(x, s) = H(x) + s, S = s, x' = (L - phi D) grad H + B u, with L skew, D = C C^T >= 0 constant and phi > 0 of the
//! friction law (1 without one), so that L_full grad S = 0 and M_full grad E = 0 hold for every weight.

use meniscus::latent::generic::FrictionLaw;
pub(crate) use meniscus::latent::generic::{LATENTS, Latent};
use meniscus::units::FRAME_INTERVAL_S;
use nalgebra::{DMatrix, DVector, SMatrix};

/// Ridges of H.
pub(crate) const HIDDEN: usize = 64;

/// A matrix on latent states.
pub(crate) type Square = SMatrix<f64, LATENTS, LATENTS>;

/// H, L, D and B.
#[derive(Clone, Debug)]
pub(crate) struct Dynamics {
    /// L, skew.
    pub(crate) skew: Square,
    /// C, lower triangular, D = C C^T.
    pub(crate) friction: Square,
    /// K.
    pub(crate) linear: Square,
    /// W, [`HIDDEN`] x [`LATENTS`].
    pub(crate) inner: DMatrix<f64>,
    /// b.
    pub(crate) bias: DVector<f64>,
    /// w.
    pub(crate) weight: DVector<f64>,
    /// B.
    pub(crate) port: Latent,
    /// Dependence of friction on the rate of shear; none where it does not depend on it.
    pub(crate) law: Option<FrictionLaw>,
}

/// Result of one turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    /// The state after it.
    pub(crate) x: Latent,
    /// Work of the port, in units of H.
    pub(crate) work: f64,
    /// Heat made, in units of H; never negative.
    pub(crate) heat: f64,
}

/// p(a) = sqrt(1 + a^2).
fn bent(a: f64) -> f64 {
    (1.0 + a * a).sqrt()
}

impl Dynamics {
    /// H(x) = |K x|^2 / 2 + sum w^2 d^2 / (B (A B + 1 + a b)), d = W x, a = d + b, A = p(a), B = p(b): convex, as
    /// [`meniscus::latent::generic::Potential`] says.
    #[must_use]
    pub(crate) fn energy(&self, x: &Latent) -> f64 {
        let along = &self.inner * x;
        let ridges = along.iter().zip(&self.bias).zip(&self.weight);
        let bowed = ridges.map(|((d, b), w)| {
            let (a_bent, b_bent) = (bent(d + b), bent(*b));
            w * w * d * d / (b_bent * (a_bent * b_bent + 1.0 + (d + b) * b))
        });
        0.5 * (self.linear * x).norm_squared() + bowed.sum::<f64>()
    }

    /// grad^2 H(0) = K^T K + W^T diag(w^2 / B^3) W.
    #[must_use]
    pub(crate) fn stiffness(&self) -> Square {
        self.stiffness_at(&Latent::zeros())
    }

    /// grad^2 H = K^T K + W^T diag(w^2 / A^3) W at `x`.
    #[must_use]
    pub(crate) fn stiffness_at(&self, x: &Latent) -> Square {
        let inside = &self.inner * x + &self.bias;
        let curvature = inside.zip_map(&self.weight, |a, w| w * w / bent(a).powi(3));
        let ridges = self.inner.tr_mul(&(DMatrix::from_diagonal(&curvature) * &self.inner));
        self.linear.tr_mul(&self.linear) + Square::from_iterator(ridges.iter().copied())
    }

    /// The same motion in the coordinates y = T x: L and D go as T L T^T, gradients as T^-T.
    ///
    /// `None` when T is singular.
    pub(crate) fn changed(&self, t: &Square) -> Option<Self> {
        let inverse = t.try_inverse()?;
        // C may be any root of D; the blob wants the lower triangular one: (T C)^T = Q R, C = R^T.
        let friction = (t * self.friction).transpose().qr().r().transpose();
        Some(Self {
            skew: t * self.skew * t.transpose(),
            friction,
            linear: self.linear * inverse,
            inner: DMatrix::from_iterator(HIDDEN, LATENTS, (&self.inner * inverse).iter().copied()),
            bias: self.bias.clone(),
            weight: self.weight.clone(),
            port: t * self.port,
            law: self.law,
        })
    }

    /// L - phi D at the gradient `gradient` of H.
    fn flow_at(&self, gradient: &Latent) -> Square {
        let Some(law) = &self.law else { return self.flow() };
        let rubs = self.friction.tr_mul(gradient);
        self.skew - self.friction * self.friction.transpose() * law.factor(rubs.norm_squared())
    }

    /// L - D.
    #[must_use]
    pub(crate) fn flow(&self) -> Square {
        self.skew - self.friction * self.friction.transpose()
    }

    /// dH(x, y) = K^T K (x + y) / 2 + W^T [w^2 ((a + a') / (A + A') - b / B)], the mean of grad H between its ends, so
    /// that dH . (y - x) = H(y) - H(x) exactly.
    #[must_use]
    pub(crate) fn discrete_gradient(&self, x: &Latent, y: &Latent) -> Latent {
        let (from, to) = (&self.inner * x + &self.bias, &self.inner * y + &self.bias);
        let slope = DVector::from_fn(HIDDEN, |i, _| {
            let (a, b, w) = (from[i] + to[i], self.bias[i], self.weight[i]);
            w * w * (a / (bent(from[i]) + bent(to[i])) - b / bent(b))
        });
        self.linear.tr_mul(&(self.linear * ((x + y) * 0.5))) + self.inner.tr_mul(&slope)
    }

    /// One correction b <- b - P (b - a - dt (L - D) dH(a, b)) of the closed step; returns what it moved.
    fn correct(&self, a: &Latent, b: &mut Latent, flow: &Square, preconditioner: &Square) -> Latent {
        let miss = *b - a - flow * self.discrete_gradient(a, b);
        let change = preconditioner * miss;
        *b -= change;
        change
    }

    /// S = K^T K / 2 + W^T diag(w^2 c) W, c = 1 / (A + A') - (a + a') a' / (A' (A + A')^2): how dH(x, y) changes with y.
    fn midway_stiffness(&self, x: &Latent, y: &Latent) -> Square {
        let (from, to) = (&self.inner * x + &self.bias, &self.inner * y + &self.bias);
        let curvature = DVector::from_fn(HIDDEN, |i, _| {
            let (sum, end) = (bent(from[i]) + bent(to[i]), bent(to[i]));
            self.weight[i].powi(2) * (1.0 / sum - (from[i] + to[i]) * to[i] / (end * sum * sum))
        });
        let ridges = self.inner.tr_mul(&(DMatrix::from_diagonal(&curvature) * &self.inner));
        self.linear.tr_mul(&self.linear) * 0.5 + Square::from_iterator(ridges.iter().copied())
    }

    /// One turn of dt by Strang splitting: half the port, the closed step by Newton's method, half the port.
    #[must_use]
    pub(crate) fn turn(&self, x: &Latent, u: f64) -> Turn {
        // Under a law each correction leaves a part of the last, as phi is taken as it stands.
        const ITERATIONS: usize = 40;
        let kick = self.port * (0.5 * FRAME_INTERVAL_S * u);
        let before = x + kick;
        let mut after = before;
        for _ in 0..ITERATIONS {
            let flow = self.flow_at(&self.discrete_gradient(&before, &after)) * FRAME_INTERVAL_S;
            let slope = Square::identity() - flow * self.midway_stiffness(&before, &after);
            let change = self.correct(
                &before,
                &mut after,
                &flow,
                &slope.try_inverse().unwrap_or_else(Square::identity),
            );
            if change.norm_squared() <= 1e-24 * (1.0 + after.norm_squared()) {
                break;
            }
        }
        let end = after + kick;
        let (h0, h1, h2, h3) = (self.energy(x), self.energy(&before), self.energy(&after), self.energy(&end));
        Turn { x: end, work: (h1 - h0) + (h3 - h2), heat: h1 - h2 }
    }

    /// Returns the length of the last of `iterations` corrections of a turn.
    #[must_use]
    pub(crate) fn residual(&self, x: &Latent, u: f64, preconditioner: &Square, iterations: usize) -> f64 {
        let before = x + self.port * (0.5 * FRAME_INTERVAL_S * u);
        let flow = self.flow() * FRAME_INTERVAL_S;
        let (mut after, mut moved) = (before, 0.0);
        for _ in 0..iterations {
            moved = self.correct(&before, &mut after, &flow, preconditioner).norm();
        }
        moved
    }

    /// The turns under `ports`, from `x`.
    pub(crate) fn turns(&self, x: Latent, ports: &[f64]) -> Vec<Turn> {
        let next = |x: &mut Latent, &u: &f64| {
            let turn = self.turn(x, u);
            *x = turn.x;
            Some(turn)
        };
        ports.iter().scan(x, next).collect()
    }

    /// The states after each of `ports`, from `x`.
    #[must_use]
    pub(crate) fn roll_out(&self, x: Latent, ports: &[f64]) -> Vec<Latent> {
        self.turns(x, ports).into_iter().map(|turn| turn.x).collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::networks::noise::normal;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Dynamics with random weights of a liquid's order of magnitude.
    pub(crate) fn random(seed: u64) -> (Dynamics, ChaCha8Rng) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut square = |scale: f64| Square::from_fn(|_, _| scale * normal(&mut rng));
        let (raw, friction, linear) = (square(8.0), square(0.8).lower_triangle(), square(0.3));
        let skew = (raw - raw.transpose()) * 0.5;
        let mut any =
            |rows, columns, scale: f64| DMatrix::from_fn(rows, columns, |_, _| scale * normal(&mut rng));
        let (inner, bias) = (any(HIDDEN, LATENTS, 0.3), any(HIDDEN, 1, 0.3).column(0).into());
        let weight = any(HIDDEN, 1, 0.1).column(0).into();
        let port = Latent::from_fn(|_, _| 3.0 * normal(&mut rng));
        (Dynamics { skew, friction, linear, inner, bias, weight, port, law: None }, rng)
    }

    #[test]
    fn gradient_is_that_of_the_energy() {
        let (dynamics, mut rng) = random(1);
        let x = Latent::from_fn(|_, _| normal(&mut rng));
        let g = dynamics.discrete_gradient(&x, &x);
        for i in 0..LATENTS {
            let mut step = Latent::zeros();
            step[i] = 1e-5;
            let slope = (dynamics.energy(&(x + step)) - dynamics.energy(&(x - step))) / 2e-5;
            assert!((slope - g[i]).abs() < 1e-7 * (1.0 + g[i].abs()), "{i}: {slope} against {}", g[i]);
        }
    }

    #[test]
    fn a_turn_keeps_the_books_and_never_cools() {
        let (dynamics, mut rng) = random(2);
        for _ in 0..50 {
            let x = Latent::from_fn(|_, _| normal(&mut rng));
            let turn = dynamics.turn(&x, normal(&mut rng));
            let balance = dynamics.energy(&turn.x) - dynamics.energy(&x) - turn.work + turn.heat;
            assert!(balance.abs() < 1e-12, "{balance}");
            assert!(turn.heat >= 0.0, "{}", turn.heat);
        }
    }

    /// dH . (b - a) = H(b) - H(a), and the heat of a solved step is dt dH^T D dH.
    #[test]
    fn heat_is_the_friction_of_the_discrete_gradient() {
        let (dynamics, mut rng) = random(3);
        let x = Latent::from_fn(|_, _| normal(&mut rng));
        let turn = dynamics.turn(&x, 0.0);
        let g = dynamics.discrete_gradient(&x, &turn.x);
        let change = dynamics.energy(&turn.x) - dynamics.energy(&x);
        assert!((g.dot(&(turn.x - x)) - change).abs() < 1e-12);
        let friction = FRAME_INTERVAL_S * dynamics.friction.tr_mul(&g).norm_squared();
        assert!((turn.heat - friction).abs() < 1e-9 * friction, "{} against {friction}", turn.heat);
    }

    /// The mean of grad H along a straight way is the same in all coordinates, and so is the step.
    #[test]
    fn a_change_of_coordinates_changes_no_motion() {
        let (dynamics, mut rng) = random(5);
        let t = Square::identity() + Square::from_fn(|_, _| 0.2 * normal(&mut rng));
        let x = Latent::from_fn(|_, _| normal(&mut rng));
        let energy = dynamics.changed(&t).expect("a regular map").energy(&(t * x));
        assert!((energy - dynamics.energy(&x)).abs() < 1e-9 * energy);
        let changed = dynamics.changed(&t).expect("a regular map");
        let ports = [0.5, -1.0, 0.3];
        let (plain, other) = (dynamics.roll_out(x, &ports), changed.roll_out(t * x, &ports));
        for (x, y) in plain.iter().zip(&other) {
            assert!((t * x - y).norm() < 1e-8 * y.norm(), "{}", (t * x - y).norm() / y.norm());
        }
        assert!((changed.friction - changed.friction.lower_triangle()).norm() < 1e-12);
    }

    #[test]
    fn rest_stays_at_rest() {
        let (dynamics, _) = random(4);
        let states = dynamics.roll_out(Latent::zeros(), &[0.0; 10]);
        assert!(states.iter().all(|x| x.norm() == 0.0));
    }
}
