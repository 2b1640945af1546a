//! Liquid of known analytic shape, rendered, and the errors of what is read back.

use meniscus::surface::{
    Config, ExtractionState, POINTS, Settings, SurfaceProfile, Tally, extract, profile_abscissa,
};
use meniscus::units::Micros;
use meniscus::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use meniscus_data::glass::WallShape;
use meniscus_data::recording::{Glass, Lattice, WALL_POINTS, wall_azimuth};
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings};

pub(crate) const GLASS: Glass =
    Glass { radius_m: 0.035, fill_m: 0.070, rim_m: 0.110, wall: WallShape::UPRIGHT };

/// Surface height at `(x, y)` in the frame of the glass, metres, for an amplitude in metres.
pub(crate) type Shape = fn(amplitude: f64, x: f64, y: f64) -> f64;

pub(crate) fn flat(_: f64, _: f64, _: f64) -> f64 {
    GLASS.fill_m
}

/// A plane; the amplitude is reached at the wall on the right.
pub(crate) fn tilted(amplitude: f64, x: f64, _: f64) -> f64 {
    GLASS.fill_m + amplitude * x / GLASS.radius_m
}

/// The first mode of an upright circular glass, `J1(k r) cos(azimuth)`, `k R = 1.8412`.
pub(crate) fn first_mode(amplitude: f64, x: f64, y: f64) -> f64 {
    let r = x.hypot(y).max(1e-9);
    GLASS.fill_m + amplitude * j1(1.8412 * r / GLASS.radius_m) / j1(1.8412) * x / r
}

/// The first mode and a bowl, whose contact line is curved in the image.
pub(crate) fn curved(amplitude: f64, x: f64, y: f64) -> f64 {
    first_mode(amplitude, x, y) + 0.3 * amplitude * (x * x - y * y) / GLASS.radius_m.powi(2)
}

/// Bessel's `J1` by its power series, for small arguments.
fn j1(x: f64) -> f64 {
    let mut term = x / 2.0;
    let mut sum = term;
    for k in 1..12 {
        term *= -(x * x / 4.0) / (f64::from(k) * f64::from(k + 1));
        sum += term;
    }
    sum
}

/// A shape, sampled as a recording samples it, and its true profile.
pub(crate) struct Surface {
    pub(crate) wall_m: Vec<f32>,
    pub(crate) column_m: Vec<f32>,
    pub(crate) profile_m: [f64; POINTS],
}

pub(crate) fn sampled(shape: Shape, amplitude: f64) -> Surface {
    let wall = |index| {
        let (sin, cos) = wall_azimuth(index).sin_cos();
        shape(amplitude, GLASS.radius_m * cos, GLASS.radius_m * sin) as f32
    };
    let point = |index| {
        let x = profile_abscissa(index) * GLASS.radius_m;
        shape(amplitude, x, -(GLASS.radius_m.powi(2) - x * x).sqrt())
    };
    Surface {
        wall_m: (0..WALL_POINTS).map(wall).collect(),
        column_m: Lattice::new(&GLASS).columns.iter().map(|[x, y]| shape(amplitude, *x, *y) as f32).collect(),
        profile_m: std::array::from_fn(point),
    }
}

/// Errors of profiles and glass positions over many frames.
#[derive(Default)]
pub(crate) struct Errors {
    frames: u32,
    points: u32,
    sum: [f64; POINTS],
    count: [u32; POINTS],
    squares: f64,
    axis: Vec<f64>,
}

impl Errors {
    pub(crate) fn add(&mut self, profile: &SurfaceProfile, truth: &[f64; POINTS], glass_x_m: f64) {
        self.frames += 1;
        for i in (0..POINTS).filter(|&i| profile.valid[i]) {
            let error = f64::from(profile.height_m[i]) - truth[i];
            self.sum[i] += error;
            self.count[i] += 1;
            self.points += 1;
            self.squares += error * error;
        }
        self.axis.push(f64::from(profile.glass_x_m.expect("a profile has an axis")) - glass_x_m);
    }

    pub(crate) fn rms_mm(&self) -> f64 {
        1e3 * (self.squares / f64::from(self.points)).sqrt()
    }

    /// Largest mean error of a point.
    pub(crate) fn bias_mm(&self) -> f64 {
        let means = self.sum.iter().zip(&self.count).map(|(sum, &n)| (sum / f64::from(n.max(1))).abs());
        1e3 * means.fold(0.0, f64::max)
    }

    /// Scatter of the glass position around its mean error: what differentiating twice amplifies.
    pub(crate) fn axis_rms_mm(&self) -> f64 {
        let mean = self.axis_bias_mm() / 1e3;
        let squares = self.axis.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>();
        1e3 * (squares / self.axis.len() as f64).sqrt()
    }

    /// Mean error of the glass position.
    pub(crate) fn axis_bias_mm(&self) -> f64 {
        1e3 * self.axis.iter().sum::<f64>() / self.axis.len() as f64
    }

    /// Share of points that were valid.
    pub(crate) fn seen(&self) -> f64 {
        f64::from(self.points) / (f64::from(self.frames) * POINTS as f64)
    }

    pub(crate) fn report(&self, name: &str) {
        println!(
            "{name:32} rms {:.3} mm, worst bias {:.3} mm, axis rms {:.4} bias {:.4} mm, seen {:.3}",
            self.rms_mm(),
            self.bias_mm(),
            self.axis_rms_mm(),
            self.axis_bias_mm(),
            self.seen()
        );
    }
}

/// The glass swings over its whole range.
pub(crate) fn swing(frame: u64) -> f64 {
    0.055 * (0.31 * frame as f64).sin()
}

/// Rendered images as the assembler would lend them.
pub(crate) fn lent<'a>(
    settings: &Settings,
    images: &'a Images,
    frame: u64,
) -> (DepthFrame<'a>, OutlineFrame<'a>) {
    let (width, height) = (settings.intrinsics.width, settings.intrinsics.height);
    let stamp = Stamp { sequence: frame as u32, captured: Micros(frame * 16_667) };
    (
        DepthFrame { bytes: &images.depth, width, height, stamp },
        OutlineFrame { bytes: &images.infrared, width, height, stamp },
    )
}

/// Renders a shape in a swinging glass and reads it back; every frame must give a profile.
pub(crate) fn read_back(
    settings: SceneSettings,
    shape: Shape,
    amplitude: f64,
    frames: u64,
) -> (Errors, Tally) {
    let config = Config::new(settings.camera).expect("the settings are sound");
    let (mut state, mut scene, mut images) =
        (ExtractionState::new(), Scene::new(settings), Images::new(&settings));
    let surface = sampled(shape, amplitude);
    let mut errors = Errors::default();
    for frame in 0..frames {
        let glass_x_m = swing(frame);
        let liquid =
            Liquid { glass_m: [glass_x_m, 0.0], wall_m: &surface.wall_m, column_m: &surface.column_m };
        scene.render(&liquid, frame, &mut images);
        let (depth, infrared) = lent(&settings.camera, &images, frame);
        let profile = extract(&config, &mut state, depth, infrared)
            .unwrap_or_else(|why| panic!("frame {frame}, glass at {glass_x_m} m: {why}"));
        errors.add(&profile, &surface.profile_m, glass_x_m);
    }
    (errors, state.tally())
}
