//! The glass: a vessel of revolution with its fill.

use crate::errors::refused;
use meniscus_data::glass::{Glass as Vessel, Profile, WallShape};
use meniscus_data::scene_file::GLASS;
use pyo3::prelude::*;

/// A glass of revolution; inner sizes, metres.
///
/// Args:
///     radius_m: Inner radius at the bottom.
///     fill_m: Height of the liquid at rest above the inner bottom.
///     rim_m: Height of the rim above the inner bottom.
///     taper: Growth of the radius with height, dr/dz; 0 is an upright cylinder.
///     profile_m: Heights and radii from the bottom to the rim, in place of radius and taper.
///
/// Example:
///     >>> from meniscus_liquid import Glass
///     >>> round(Glass(radius_m=0.03, fill_m=0.05, rim_m=0.1, taper=0.1).radius_at(0.05), 4)
///     0.035
#[pyclass(frozen, eq, module = "meniscus_liquid")]
#[derive(Clone, PartialEq)]
pub(crate) struct Glass(pub(crate) Vessel);

#[pymethods]
impl Glass {
    #[new]
    #[pyo3(signature = (radius_m=None, fill_m=None, rim_m=None, *, taper=None, profile_m=None))]
    fn new(
        radius_m: Option<f64>,
        fill_m: Option<f64>,
        rim_m: Option<f64>,
        taper: Option<f64>,
        profile_m: Option<Vec<[f64; 2]>>,
    ) -> PyResult<Self> {
        let fill_m = fill_m.unwrap_or(GLASS.fill_m);
        let Some(points) = profile_m else {
            let wall = WallShape::Straight { taper: taper.unwrap_or(0.0) };
            let (radius_m, rim_m) = (radius_m.unwrap_or(GLASS.radius_m), rim_m.unwrap_or(GLASS.rim_m));
            return Ok(Self(Vessel { radius_m, fill_m, rim_m, wall }));
        };
        if radius_m.is_some() || taper.is_some() {
            return Err(refused(
                "a glass has a profile_m, or a radius_m with a taper: leave one of them out",
            ));
        }
        let profile = Profile::new(&points).map_err(refused)?;
        Ok(Self(Vessel::curved(profile, fill_m, rim_m.unwrap_or(profile.top_m()))))
    }

    /// Inner radius at the bottom, m.
    #[getter]
    fn radius_m(&self) -> f64 {
        self.0.radius_m
    }

    /// Height of the liquid at rest above the inner bottom, m.
    #[getter]
    fn fill_m(&self) -> f64 {
        self.0.fill_m
    }

    /// Height of the rim above the inner bottom, m.
    #[getter]
    fn rim_m(&self) -> f64 {
        self.0.rim_m
    }

    /// Whether the side wall is upright and straight.
    #[getter]
    fn is_cylinder(&self) -> bool {
        self.0.is_cylinder()
    }

    /// Returns the inner radius at the height `z_m` above the inner bottom, m.
    fn radius_at(&self, z_m: f64) -> f64 {
        self.0.radius_at(z_m)
    }

    fn __repr__(&self) -> String {
        let Vessel { radius_m, fill_m, rim_m, wall } = &self.0;
        match wall {
            WallShape::Straight { taper } => {
                format!("Glass(radius_m={radius_m}, fill_m={fill_m}, rim_m={rim_m}, taper={taper})")
            }
            WallShape::Curved(profile) => {
                format!("Glass(fill_m={fill_m}, rim_m={rim_m}, profile_m={:?})", profile.points())
            }
        }
    }
}
