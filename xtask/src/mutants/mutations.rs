//! The mistakes of the sample. Most stand for one that an audit had put in unnoticed.

/// Tests that have to notice a mistake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tests {
    /// Unit tests of the core.
    Unit,
    /// A test of `tests/core`.
    Core(&'static str),
}

/// A text of a file and what replaces it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mutation {
    pub(super) file: &'static str,
    /// Stands in the file exactly once.
    pub(super) old: &'static str,
    pub(super) new: &'static str,
    /// The mistake in words.
    pub(super) mistake: &'static str,
    pub(super) tests: Tests,
}

const STEP: &str = "src/latent/generic/step.rs";
const FLOW: &str = "src/latent/generic/flow.rs";
const ASSEMBLER: &str = "src/usb/uvc/assembler.rs";
const KALMAN: &str = "src/filter/kalman.rs";
const UPDATES: &str = "src/filter/measurements.rs";
const EXTRACT: &str = "src/surface/extract.rs";
const DEPTH: &str = "src/surface/depth.rs";

/// The sample.
pub(super) const MUTATIONS: [Mutation; 24] = [
    Mutation {
        file: STEP,
        old: "if energy <= most {",
        new: "if energy <= most + 1e-6 * most.abs() {",
        mistake: "a step may raise the energy by a millionth",
        tests: Tests::Unit,
    },
    Mutation {
        file: STEP,
        old: "if !finite {",
        new: "if false {",
        mistake: "a result that is not a number is kept",
        tests: Tests::Unit,
    },
    Mutation {
        file: STEP,
        old: "speed = 0.5 * (speed + slots.rate(&widen(&trial.end)).abs());",
        new: "let _ = trial;",
        mistake: "a contact line slides by the speed at the start of the step",
        tests: Tests::Unit,
    },
    Mutation {
        file: FLOW,
        old: "(law.factor(p) - 1.0)",
        new: "(0.9 * (law.factor(p) - 1.0))",
        mistake: "a liquid thins by a tenth too little",
        tests: Tests::Unit,
    },
    Mutation {
        file: FLOW,
        old: "self.under(law, operators, gradient) - thins",
        new: "{ let _ = thins; self.under(law, operators, gradient) }",
        mistake: "the slope of a step's equations leaves out that friction thins",
        tests: Tests::Unit,
    },
    Mutation {
        file: STEP,
        old: "(0.5 * self.dt_s * u)",
        new: "(0.45 * self.dt_s * u)",
        mistake: "the port pushes a tenth too little",
        tests: Tests::Unit,
    },
    Mutation {
        file: STEP,
        old: "let x1 = closed.end + half_kick;",
        new: "let x1 = kicked * R::of(0.98) + half_kick;",
        mistake: "the learned step is replaced by a decay",
        tests: Tests::Unit,
    },
    Mutation {
        file: STEP,
        old: "for _ in 0..MAX_HALVINGS {",
        new: "for _ in 0..0 {",
        mistake: "a step that would rise is dropped, not halved",
        tests: Tests::Unit,
    },
    Mutation {
        file: ASSEMBLER,
        old: "self.fid == header.frame_id() && (",
        new: "(",
        mistake: "payloads of two frames are joined if their time is the same",
        tests: Tests::Core("uvc"),
    },
    Mutation {
        file: ASSEMBLER,
        old: "(self.pts == header.pts() || header.pts().is_none())",
        new: "true",
        mistake: "the frame after the next one is taken for the rest of this one",
        tests: Tests::Core("uvc"),
    },
    Mutation {
        file: ASSEMBLER,
        old: "Ok(_) | Err(_) => {\n                self.continuity.lost_unidentified();",
        new: "Ok(_) | Err(_) => {",
        mistake: "a frame of which the header alone came is booked twice",
        tests: Tests::Core("uvc"),
    },
    Mutation {
        file: KALMAN,
        old: "*u = u.clamp(-PORT_LIMIT, PORT_LIMIT);",
        new: "*u = u.min(PORT_LIMIT);",
        mistake: "an input may leave the range of the port",
        tests: Tests::Unit,
    },
    Mutation {
        file: KALMAN,
        old: "self.glass_mm = [0.0; 2];",
        new: "",
        mistake: "the position of the glass is not forgotten",
        tests: Tests::Unit,
    },
    Mutation {
        file: UPDATES,
        old: "if context.adaptation == Adaptation::Follow && sum.count > 0.0 {",
        new: "if false {",
        mistake: "the noise of the step does not follow the heights",
        tests: Tests::Unit,
    },
    Mutation {
        file: UPDATES,
        old: "if !*profile.valid.get(point)? {",
        new: "if false {",
        mistake: "a height that was not seen is taken as measured",
        tests: Tests::Unit,
    },
    Mutation {
        file: UPDATES,
        old: "(reading.latent - *latent)",
        new: "(reading.latent - *latent * 0.9)",
        mistake: "the encoder's reading is compared with nine tenths of the latents",
        tests: Tests::Unit,
    },
    Mutation {
        file: EXTRACT,
        old: "depth.bytes.len() == pixels.saturating_mul(2)",
        new: "true",
        mistake: "the length of the depth image is not checked",
        tests: Tests::Unit,
    },
    Mutation {
        file: EXTRACT,
        old: "threshold.contrast >= config.settings.least_contrast",
        new: "threshold.contrast >= 0.0",
        mistake: "any contrast will do",
        tests: Tests::Unit,
    },
    Mutation {
        file: EXTRACT,
        old: "const LEAST_COLUMNS: usize = 20;",
        new: "const LEAST_COLUMNS: usize = 2;",
        mistake: "two columns make a profile",
        tests: Tests::Unit,
    },
    Mutation {
        file: EXTRACT,
        old: "state.axis_m = profile.glass_x_m;",
        new: "state.axis_m = None;",
        mistake: "the position of the glass is not remembered",
        tests: Tests::Unit,
    },
    Mutation {
        file: DEPTH,
        old: "Some(off) if off < -limits.tolerance_m => Verdict::Covered,",
        new: "",
        mistake: "what stands before the glass passes for its liquid",
        tests: Tests::Unit,
    },
    Mutation {
        file: "src/blob/store.rs",
        old: "if skew || negative {",
        new: "if negative {",
        mistake: "an asymmetric covariance is accepted",
        tests: Tests::Core("blob"),
    },
    Mutation {
        file: "src/usb/d4xx/table.rs",
        old: "if stored != computed {",
        new: "if false {",
        mistake: "a damaged calibration table is accepted",
        tests: Tests::Unit,
    },
    Mutation {
        file: "src/uncertainty/error_model.rs",
        old: "f64::from(self.factors.weight_floor) + latent_energy",
        new: "f64::from(self.factors.weight_floor)",
        mistake: "errors do not grow with the slosh",
        tests: Tests::Unit,
    },
];
