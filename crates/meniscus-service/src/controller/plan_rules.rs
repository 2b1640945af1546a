//! Rules that a plan has to keep, and the sentence about one that does not.

/// Version of plans.
pub const PLAN_VERSION: u8 = 1;
/// Fewest samples of a plan.
pub(super) const LEAST: usize = 4;
/// Most samples of a plan.
pub const PLAN_SAMPLES_MAX: usize = 256;
/// Time by which the first stamp may lie in the past, s.
pub(super) const PAST_S: f64 = 0.1;
/// Time by which the last stamp may lie in the future, s.
pub(super) const AHEAD_S: f64 = 3.0;
/// Longest time between two samples, s.
pub(super) const APART_S: f64 = 0.1;
/// Speed at the end from which on the plan ends while moving, m/s.
pub(super) const REST_M_S: f64 = 0.02;
/// Largest acceleration between samples, m/s2.
pub(super) const LARGEST_M_S2: f64 = 50.0;
/// Largest position, m.
pub(super) const LARGEST_M: f64 = 100.0;

/// Reason for which a plan is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanFault {
    /// Another version.
    Version(u8),
    /// Flags or length do not fit.
    Layout,
    /// Too few samples.
    TooFew(usize),
    /// Too many samples.
    TooMany(usize),
    /// The sample is not after the one before it, or too long after it.
    Spacing(usize),
    /// A position that is none, or an acceleration that no glass bears, at the sample.
    Range(usize),
    /// The first stamp lies so many seconds in the past.
    Past(f64),
    /// The last stamp lies so many seconds in the future.
    Future(f64),
    /// The plan ends with this speed, m/s.
    EndsMoving(f64),
}

impl PlanFault {
    /// Returns the number of the fault in a record.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Version(_) => 1,
            Self::Layout => 2,
            Self::TooFew(_) => 3,
            Self::TooMany(_) => 4,
            Self::Spacing(_) => 5,
            Self::Range(_) => 6,
            Self::Past(_) => 7,
            Self::Future(_) => 8,
            Self::EndsMoving(_) => 9,
        }
    }
}

impl std::fmt::Display for PlanFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Version(version) => {
                write!(
                    f,
                    "it has version {version}, and this program reads version {PLAN_VERSION}: update the sender"
                )
            }
            Self::Layout => {
                f.write_str("its length does not fit its count, or a flag is unknown: see docs/robots.md")
            }
            Self::TooFew(count) => write!(f, "it has {count} samples, and {LEAST} are the least"),
            Self::TooMany(count) => {
                write!(
                    f,
                    "it has {count} samples, and {PLAN_SAMPLES_MAX} are the most: send fewer, or the next part later"
                )
            }
            Self::Spacing(index) => {
                write!(
                    f,
                    "sample {index} is not 1 us to {APART_S} s after the one before it: stamps have to rise"
                )
            }
            Self::Range(index) => write!(
                f,
                "at sample {index} the position is above {LARGEST_M} m, no number, or accelerated by more than {LARGEST_M_S2} m/s2"
            ),
            Self::Past(seconds) => {
                write!(f, "it begins {seconds:.3} s in the past: send it before it is carried out")
            }
            Self::Future(seconds) => {
                write!(f, "it ends {seconds:.3} s from now, and {AHEAD_S} s are the most")
            }
            Self::EndsMoving(speed) => {
                write!(f, "it ends while the glass moves at {speed:.3} m/s: add the samples up to rest")
            }
        }
    }
}

/// Checks the number of samples.
pub(super) fn check_count(count: usize) -> Result<(), PlanFault> {
    match count {
        ..LEAST => Err(PlanFault::TooFew(count)),
        LEAST..=PLAN_SAMPLES_MAX => Ok(()),
        _ => Err(PlanFault::TooMany(count)),
    }
}
