//! Initial positions of the particles: concentric rings in layers, and rings of wall particles around them.
//!
//! Ring `j` lies at radius `(j + 1/2) dx` with `round(2 pi (j + 1/2))` particles, so that every
//! particle owns the same volume to within 2 %; layers are turned against each other by the golden
//! angle so that no columns of particles stand on top of one another.

use meniscus_data::recording::Glass;

/// Layers of wall particles: the support 2.8 dx of the kernel, rounded up.
const WALL_LAYERS: usize = 3;

/// The golden angle, radians.
const TURN: f64 = 2.399_963_229_728_653;

/// Positions and volumes of a packing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Packing {
    /// Positions in the frame of the glass, metres.
    pub(crate) position: Vec<[f64; 3]>,
    /// Volume that each position stands for, m3.
    pub(crate) volume: Vec<f64>,
}

impl Packing {
    /// One layer of rings `pitch` apart from ring `first` to `last` (excluded) at height `z`, `dz` thick.
    fn layer(&mut self, first: usize, last: usize, pitch: f64, z: f64, dz: f64, phase: f64) {
        for ring in first..last {
            let radius = (ring as f64 + 0.5) * pitch;
            let count = (std::f64::consts::TAU * radius / pitch).round() as usize;
            let area = std::f64::consts::TAU * radius * pitch / count as f64;
            for k in 0..count {
                let angle = std::f64::consts::TAU * k as f64 / count as f64 + phase * (ring as f64 + 1.0);
                self.position.push([radius * angle.cos(), radius * angle.sin(), z]);
                self.volume.push(area * dz);
            }
        }
    }

    /// The liquid at rest in `glass`, with a spacing from [`fitting_spacing`].
    pub(crate) fn liquid(glass: &Glass, dx: f64, seed: u64) -> Self {
        let layers = (glass.fill_m / dx).round().max(1.0) as usize;
        let dz = glass.fill_m / layers as f64;
        let mut packing = Self::default();
        for layer in 0..layers {
            let phase = TURN * (layer as f64 + seed as f64 % 1024.0);
            let z = (layer as f64 + 0.5) * dz;
            let (rings, pitch) = rings_at(glass, dx, z);
            // As thick as a cylinder with the liquid between two heights: the walls of a cone or bowl are no steps.
            let [low, high] = [layer as f64 * dz, (layer + 1) as f64 * dz];
            let radius = rings as f64 * pitch;
            let thick = glass.volume_m3(low, high) / (std::f64::consts::PI * radius * radius);
            packing.layer(0, rings, pitch, z, thick, phase);
        }
        packing
    }

    /// Bottom and side wall, a few layers thick, up to two supports above the rim.
    pub(crate) fn wall(glass: &Glass, dx: f64) -> Self {
        let rings = rings(glass, dx);
        let mut packing = Self::default();
        for layer in 0..WALL_LAYERS {
            let z = -(layer as f64 + 0.5) * dx;
            packing.layer(0, rings + WALL_LAYERS, dx, z, dx, TURN * layer as f64);
        }
        let layers = (glass.rim_m / dx).ceil() as usize + 2 * WALL_LAYERS;
        for layer in 0..layers {
            let z = (layer as f64 + 0.5) * dx;
            let (rings, pitch) = rings_at(glass, dx, z);
            packing.layer(rings, rings + WALL_LAYERS, pitch, z, dx, TURN * (layer + WALL_LAYERS) as f64);
        }
        packing
    }
}

/// The spacing nearest to `spacing_m` with a whole number of rings across the radius.
pub(crate) fn fitting_spacing(glass: &Glass, spacing_m: f64) -> f64 {
    glass.size_m() / rings(glass, spacing_m) as f64
}

/// Rings of liquid particles at height `z`, and how far apart they are: nearest to `dx` in a cone or a bowl, where each layer has
/// its own.
fn rings_at(glass: &Glass, dx: f64, z: f64) -> (usize, f64) {
    if glass.is_cylinder() {
        return (rings(glass, dx), dx);
    }
    let radius = glass.radius_at(z);
    let rings = (radius / dx).round().max(1.0);
    (rings as usize, radius / rings)
}

/// Rings of liquid particles across the radius by which the glass is judged.
fn rings(glass: &Glass, spacing_m: f64) -> usize {
    (glass.size_m() / spacing_m).round().max(2.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::glass::WallShape;

    #[test]
    fn the_packing_fills_the_glass() {
        let glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };
        let packing = Packing::liquid(&glass, 0.005, 3);
        let volume: f64 = packing.volume.iter().sum();
        let truth = std::f64::consts::PI * 0.035_f64.powi(2) * 0.07;
        assert_eq!(packing.position.len(), 2156);
        assert!((volume / truth - 1.0).abs() < 1e-9);
        assert!(packing.position.iter().all(|p| p[0].hypot(p[1]) < 0.035 && p[2] > 0.0 && p[2] < 0.07));
        let wall = Packing::wall(&glass, 0.005);
        assert!(wall.position.iter().all(|p| p[0].hypot(p[1]) > 0.035 || p[2] < 0.0));
    }
}
