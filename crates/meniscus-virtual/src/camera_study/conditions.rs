//! The scenes of the study: a seeded set over liquids, distances, tilts, and one condition each.

use crate::render::{Clutter, Finger, Glare, SceneSettings};
use meniscus::surface::{Liquid, POINTS, Settings, profile_abscissa};
use meniscus_data::glass::WallShape;
use meniscus_data::recording::Glass;
use meniscus_data::recording::{Lattice, WALL_POINTS, wall_azimuth};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Five looks: name, before which background, tone, share of the room that the surface mirrors.
pub const LOOKS: [(&str, Liquid, f64, f64); 5] = [
    ("glycerine, dyed", Liquid::Dark, 38.0, 0.2),
    ("blood", Liquid::Dark, 30.0, 0.1),
    ("chocolate", Liquid::Dark, 55.0, 0.05),
    ("butter", Liquid::Bright, 175.0, 0.25),
    ("mayonnaise", Liquid::Bright, 205.0, 0.02),
];

/// Distances of the camera, metres.
pub const DISTANCES_M: [f64; 3] = [0.30, 0.45, 0.60];
/// Largest tilt of the camera, degrees.
pub const TILT_DEG: f64 = 15.0;
/// Frames of a scene; the clutter comes with the third one, when the glass is tracked.
pub const FRAMES: u64 = 6;
/// Frame with which the clutter comes.
pub const CLUTTERED_FROM: u64 = 2;

/// Condition under which a scene is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// The camera's own noise, 5 % holes.
    Nominal,
    /// Twice the noise, in depth and in the infrared image.
    DoubleNoise,
    /// 10 to 30 % of the depth image are holes.
    Holes,
    /// Up to 4 mm of foam on a part of the surface.
    Foam,
    /// A lamp mirrored by the glass.
    Glare,
    /// A finger before the glass.
    Finger,
    /// No glass, or a clear liquid in it, with or without a finger: no profile may come out.
    NoLiquid,
}

impl Condition {
    /// All, in the order of the table.
    pub const ALL: [Self; 7] = [
        Self::Nominal,
        Self::DoubleNoise,
        Self::Holes,
        Self::Foam,
        Self::Glare,
        Self::Finger,
        Self::NoLiquid,
    ];

    /// Name in the table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::DoubleNoise => "double noise",
            Self::Holes => "holes 10-30 %",
            Self::Foam => "foam",
            Self::Glare => "glare",
            Self::Finger => "finger",
            Self::NoLiquid => "no liquid",
        }
    }

    /// Of twenty scenes, six are nominal and some of each other kind.
    fn of(index: usize) -> Self {
        match index % 20 {
            0 | 3 | 6 | 9 | 12 | 15 => Self::Nominal,
            1 | 7 | 13 => Self::DoubleNoise,
            2 | 8 | 14 => Self::Holes,
            4 | 16 => Self::Foam,
            5 | 17 => Self::Glare,
            10 | 18 => Self::Finger,
            _ => Self::NoLiquid,
        }
    }
}

/// One scene and its truth.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its condition.
    pub condition: Condition,
    /// Index into [`LOOKS`].
    pub look: usize,
    /// Index into [`DISTANCES_M`].
    pub distance: usize,
    /// Tilt of the camera, degrees, positive upwards.
    pub tilt_deg: f64,
    /// All inputs of the renderer, the clutter included.
    pub settings: SceneSettings,
    /// Heights of the contact line and of the lattice columns, metres.
    pub wall_m: Vec<f32>,
    /// The same of the columns.
    pub column_m: Vec<f32>,
    /// The true profile, metres.
    pub truth_m: [f64; POINTS],
    start_m: f64,
    speed_m: f64,
}

/// Draws a finger in the glass.
fn finger(within: &mut impl FnMut(f64, f64) -> f64) -> Finger {
    Finger {
        height_m: within(0.02, 0.085),
        radius_m: within(0.006, 0.009),
        tip: within(-0.6, 0.8),
        before_m: within(0.010, 0.030),
        from_right: within(0.0, 1.0) < 0.5,
    }
}

/// Puts what `condition` disturbs into nominal `settings`; `within` draws uniformly between two bounds.
fn disturb(settings: &mut SceneSettings, condition: Condition, within: &mut impl FnMut(f64, f64) -> f64) {
    match condition {
        Condition::Nominal => {}
        Condition::DoubleNoise => {
            settings.disparity_rms_px *= 2.0;
            settings.grey_rms *= 2.0;
        }
        Condition::Holes => settings.hole_share = within(0.10, 0.30),
        Condition::Foam => {
            let from = within(-1.0, 0.3);
            settings.clutter.foam_m = within(0.001, 0.004);
            settings.clutter.foam_span = [from, from + within(0.4, 1.2)];
        }
        Condition::Glare => {
            let (across, width_px) = (within(-0.7, 0.7), within(1.0, 2.5));
            settings.clutter.glare = Some(Glare { across, width_px });
        }
        Condition::Finger => settings.clutter.finger = Some(finger(within)),
        Condition::NoLiquid => {
            settings.glass_present = within(0.0, 1.0) < 0.6;
            let finger = (within(0.0, 1.0) < 0.4).then(|| finger(within));
            settings.clutter = Clutter { clear: within(0.85, 1.0), finger, ..Clutter::default() };
        }
    }
}

impl Case {
    /// Scene `index` of the set of `seed`.
    #[must_use]
    pub fn new(seed: u64, index: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(0x9e37_79b9).wrapping_add(index as u64));
        let mut within = |from: f64, to: f64| from + (to - from) * random.random::<f64>();
        let condition = Condition::of(index);
        let (look, distance) = (within(0.0, 4.999) as usize, within(0.0, 2.999) as usize);
        let tilt_deg = within(-TILT_DEG, TILT_DEG);
        let (_, liquid, tone, mirror) = LOOKS[look];
        let camera = Settings {
            camera_distance_m: DISTANCES_M[distance] as f32,
            camera_pitch_rad: tilt_deg.to_radians() as f32,
            liquid,
            ..Settings::default()
        };
        let mut settings = SceneSettings {
            camera,
            tone: Some(tone),
            mirror,
            seed: seed.wrapping_mul(1_000_003).wrapping_add(index as u64),
            ..SceneSettings::default()
        };
        disturb(&mut settings, condition, &mut within);
        let shape = Sloshing {
            first_m: within(-0.010, 0.010),
            azimuth: within(0.0, std::f64::consts::TAU),
            bowl_m: within(-0.002, 0.002),
        };
        let glass = Glass {
            radius_m: f64::from(camera.radius_m),
            fill_m: f64::from(camera.fill_m),
            rim_m: f64::from(camera.rim_m),
            wall: WallShape::UPRIGHT,
        };
        let at = |x: f64, y: f64| shape.height(&glass, x, y);
        let wall = |i| wall_azimuth(i).sin_cos();
        let truth = |i| {
            let x = profile_abscissa(i) * glass.radius_m;
            at(x, -(glass.radius_m.powi(2) - x * x).sqrt())
        };
        Self {
            condition,
            look,
            distance,
            tilt_deg,
            settings,
            wall_m: (0..WALL_POINTS)
                .map(|i| at(glass.radius_m * wall(i).1, glass.radius_m * wall(i).0) as f32)
                .collect(),
            column_m: Lattice::new(&glass).columns.iter().map(|[x, y]| at(*x, *y) as f32).collect(),
            truth_m: std::array::from_fn(truth),
            start_m: within(-0.02, 0.02),
            speed_m: within(-0.003, 0.003),
        }
    }

    /// Position of the glass in a frame, metres.
    #[must_use]
    pub fn glass_m(&self, frame: u64) -> f64 {
        self.start_m + self.speed_m * frame as f64
    }
}

/// The first mode of an upright circular glass in any direction, and a bowl.
struct Sloshing {
    first_m: f64,
    azimuth: f64,
    bowl_m: f64,
}

impl Sloshing {
    /// `fill + A J1(k r) cos(phi - phi0) / J1(k R) + B (x^2 - y^2) / R^2`, `k R = 1.8412`.
    fn height(&self, glass: &Glass, x: f64, y: f64) -> f64 {
        let r = x.hypot(y).max(1e-9);
        let along = (x * self.azimuth.cos() + y * self.azimuth.sin()) / r;
        let first = bessel_j1(1.8412 * r / glass.radius_m) / bessel_j1(1.8412);
        let bowl = (x * x - y * y) / glass.radius_m.powi(2);
        glass.fill_m + self.first_m * first * along + self.bowl_m * bowl
    }
}

/// Bessel's `J1` by its power series, for small arguments: `sum (-1)^k (x/2)^(2k+1) / (k! (k+1)!)`.
fn bessel_j1(x: f64) -> f64 {
    let mut term = x / 2.0;
    let mut sum = term;
    for k in 1..12 {
        term *= -(x * x / 4.0) / f64::from(k * (k + 1));
        sum += term;
    }
    sum
}
