//! One program: everything but what it is solved for.

use crate::course::Course;
use crate::models::FrameInput;
use crate::preferred::Preferred;
use crate::request::Request;
use crate::response::{Departure, ENDS, Response};

/// Difference of the forecast from the linear response, and half-widths, frame by frame; the last one holds on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Correction {
    /// d of both ends, m.
    pub(crate) offset_m: Vec<[f64; ENDS]>,
    /// m: half-widths at the stated confidence, m.
    pub(crate) half_m: Vec<f64>,
}

impl Correction {
    /// d + m of an end in frame `k`, m.
    pub(super) fn at(&self, k: usize, end: usize) -> f64 {
        let last = |n: usize| k.min(n.saturating_sub(1));
        let offset = self.offset_m.get(last(self.offset_m.len())).map_or(0.0, |ends| ends[end]);
        offset + self.half_m.get(last(self.half_m.len())).copied().unwrap_or(0.0)
    }
}

/// One program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Program<'a> {
    pub(crate) request: &'a Request,
    pub(crate) departure: &'a Departure,
    pub(crate) response: &'a Response,
    pub(crate) correction: &'a Correction,
    pub(crate) input: FrameInput,
    /// T, s.
    pub(crate) duration_s: f64,
    /// M.
    pub(crate) knots: usize,
    /// Frames over which the surface is limited.
    pub(crate) frames: usize,
    /// Preferred jerks.
    pub(crate) preferred: Preferred<'a>,
    /// Motion that the solution may be near to, of any duration.
    pub(crate) nearby: Option<&'a Course>,
}

/// Numbers of a program that many of its rows need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    /// d, s.
    pub(super) knot_s: f64,
    /// Largest acceleration A, m/s2: the unit of the unknowns.
    pub(super) acceleration_m_s2: f64,
    /// Jerk over the largest, for a difference of unity between two unknowns: A / (d J).
    pub(super) jerk: f64,
    /// a_0 in units of A.
    pub(super) first: f64,
}

impl Program<'_> {
    /// Time between two knots, s.
    pub(super) fn knot_s(&self) -> f64 {
        self.duration_s / self.knots as f64
    }

    pub(super) fn scales(&self) -> Scales {
        let (knot_s, limits) = (self.knot_s(), self.request.limits);
        let acceleration_m_s2 = limits.acceleration_m_s2;
        Scales {
            knot_s,
            acceleration_m_s2,
            jerk: acceleration_m_s2 / (knot_s * limits.jerk_m_s3),
            first: self.departure.glass.acceleration_m_s2 / acceleration_m_s2,
        }
    }

    /// Accelerations at the inner knots of the motion nearby, stretched to the duration, in units of A; none where none is known.
    pub(super) fn nearby(&self) -> Option<Vec<f64>> {
        let course = self.nearby?;
        let stretch = course.duration_s() / self.duration_s;
        let unit = stretch * stretch / self.request.limits.acceleration_m_s2;
        let at = |k: usize| unit * course.at(stretch * k as f64 * self.knot_s()).acceleration_m_s2;
        Some((1..self.knots).map(at).collect())
    }
}
