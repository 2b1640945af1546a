//! Pose of a square from its four corners.
//!
//! Corners p_i = (+-s/2, +-s/2, 0) of a tag of size s in its own axes (right, down, into the tag); the camera's axes are right, down,
//! forward. A point of the tag is at R p + t, and its image is
//!
//! ```text
//! u = c_x + f_x X/Z,   v = c_y + f_y Y/Z,   (X, Y, Z) = R p + t
//! ```
//!
//! **Start.** In coordinates without lens, ((u - c_x)/f_x, (v - c_y)/f_y, 1) ~ H (p_x, p_y, 1) with H = l (r_1 r_2 t); eight linear
//! equations give H up to l, which |r_1| |r_2| = 1 gives (Hartley & Zisserman, Multiple View Geometry, 2nd ed., 4.1 and 8.1.1).
//!
//! **Refinement.** Gauss-Newton on the reprojection error, S = sum |u_i - u(p_i)|^2, with R <- exp([w]x) R:
//!
//! ```text
//! d(X, Y, Z) = w x R p + dt,   (J^T J) (w, dt) = J^T r,   covariance = sigma^2 (J^T J)^-1
//! ```
//!
//! **Ambiguity.** From far away a plane that leans towards the camera looks like one that leans away. The second minimum of S is near
//! the first one mirrored along the line of sight d = t/|t| (Schweighofer & Pinz, IEEE PAMI 28 (2006) 2024; Collins & Bartoli, IJCV 109
//! (2014) 252):
//!
//! ```text
//! R' = rot(d, pi) R rot(e_z, pi)
//! ```
//! It is refined as well. Under a normal error of the corners, S_2 - S_1 is twice the logarithm of how much likelier the first one is,
//! in units of sigma^2.

use meniscus::surface::Intrinsics;
use nalgebra::{
    Matrix2x3, Matrix3, Matrix6, Rotation3, SMatrix, SVector, UnitQuaternion, Vector2, Vector3, Vector6,
};
use std::f64::consts::PI;

/// Standard deviation of a corner's coordinate that covariance and gates count on, px.
pub const CORNER_STD_PX: f64 = 0.1;
/// Root mean square of a coordinate over the sharp images of the tests that are 27 pixels wide or more, px.
const SHARP_STD_PX: f64 = 0.03;

/// Steps of Gauss-Newton, and the turn and share of the distance below which they end.
const STEPS: usize = 20;
const CONVERGED: f64 = 1e-9;
/// S_2 - S_1 in sigma^2 up to which the second attitude is possible: 1 in 90 of the first one.
const AMBIGUOUS: f64 = 9.0;
/// S_1 in sigma^2 from which on the four corners are no square: chi-square with 2 degrees of freedom exceeds it in 1 of 22,000 images.
const UNFIT: f64 = 20.0;
/// Attitudes nearer than this are one minimum, rad.
const SAME_RAD: f64 = 0.01;
/// Share of the distance by which the positions of two possible attitudes may differ.
const APART: f64 = 0.005;

/// Pose of a tag in the camera's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagPose {
    /// Attitude R.
    pub rotation: UnitQuaternion<f64>,
    /// Position t of the centre, m.
    pub position_m: Vector3<f64>,
    /// Covariance of (w, t), rad and m, in the camera's axes.
    pub covariance: Matrix6<f64>,
    /// The other attitude that explains the corners, where there is one.
    pub other: Option<UnitQuaternion<f64>>,
}

/// Reason for which corners have no pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PoseFault {
    /// They are no image of a plane square.
    #[error("its corners are not those of a flat square: {0:.1} px from one")]
    Unfit(f64),
    /// Two attitudes explain them, and their positions differ.
    #[error("two poses explain its corners")]
    Undecided,
}

/// One minimum of S.
#[derive(Clone, Copy, Debug)]
struct Minimum {
    rotation: Rotation3<f64>,
    position_m: Vector3<f64>,
    /// S, px^2.
    squares: f64,
    /// J^T J.
    information: Matrix6<f64>,
}

/// Returns the pose of a tag of `size_m` whose corners are in the image at `corners_px`, in the order of
/// [`SeenTag`](crate::SeenTag).
///
/// # Errors
/// [`PoseFault`].
pub fn pose(corners_px: &[[f64; 2]; 4], size_m: f64, lens: &Intrinsics) -> Result<TagPose, PoseFault> {
    let square = Square::of(size_m, lens);
    let corners = corners_px.map(Vector2::from);
    let unfit = |squares: f64| PoseFault::Unfit((squares / 4.0).sqrt());
    let start = square.start(&corners).ok_or(unfit(f64::INFINITY))?;
    let first = square.refined(start, &corners).ok_or(unfit(f64::INFINITY))?;
    let second = mirrored(&first).and_then(|start| square.refined(start, &corners));
    let (best, other) = match second {
        Some(second) if second.squares < first.squares => (second, Some(first)),
        second => (first, second),
    };
    let variance = CORNER_STD_PX * CORNER_STD_PX;
    if best.squares > UNFIT * variance {
        return Err(unfit(best.squares));
    }
    let possible = other.filter(|other| {
        other.squares - best.squares < AMBIGUOUS * variance
            && best.rotation.angle_to(&other.rotation) > SAME_RAD
    });
    if possible
        .is_some_and(|other| (other.position_m - best.position_m).norm() > APART * best.position_m.norm())
    {
        return Err(PoseFault::Undecided);
    }
    let covariance = best.information.try_inverse().ok_or(PoseFault::Undecided)? * variance;
    Ok(TagPose {
        rotation: best.rotation.into(),
        position_m: best.position_m,
        covariance,
        other: possible.map(|other| other.rotation.into()),
    })
}

impl TagPose {
    /// Returns the pose with the attitude, of two possible ones, that is nearer to `before`.
    #[must_use]
    pub fn nearer_to(self, before: &UnitQuaternion<f64>) -> Self {
        match self.other {
            Some(other) if other.angle_to(before) < self.rotation.angle_to(before) => {
                Self { rotation: other, other: Some(self.rotation), ..self }
            }
            _ => self,
        }
    }

    /// Standard deviation of the position of a sharp image along a direction of length one, m.
    #[must_use]
    pub fn std_along_m(&self, direction: &Vector3<f64>) -> f64 {
        let positions = self.covariance.fixed_view::<3, 3>(3, 3);
        SHARP_STD_PX / CORNER_STD_PX * direction.dot(&(positions * direction)).max(0.0).sqrt()
    }

    /// Largest standard deviations of an attitude about the axes of the camera, rad, and of a position along them, m.
    #[must_use]
    pub fn std(&self) -> [f64; 2] {
        let largest = |from: usize| {
            (from..from + 3).map(|axis| self.covariance[(axis, axis)]).fold(0.0, f64::max).sqrt()
        };
        [largest(0), largest(3)]
    }
}

/// rot(d, pi) R rot(e_z, pi), at the same position.
fn mirrored(first: &Minimum) -> Option<(Rotation3<f64>, Vector3<f64>)> {
    let sight = nalgebra::Unit::try_new(first.position_m, f64::EPSILON)?;
    let about_sight = Rotation3::from_axis_angle(&sight, PI);
    let about_normal = Rotation3::from_axis_angle(&Vector3::z_axis(), PI);
    Some((about_sight * first.rotation * about_normal, first.position_m))
}

/// A tag before a lens.
struct Square<'l> {
    points_m: [Vector3<f64>; 4],
    lens: &'l Intrinsics,
}

impl<'l> Square<'l> {
    fn of(size_m: f64, lens: &'l Intrinsics) -> Self {
        let half = 0.5 * size_m;
        let points_m = [[-half, -half], [half, -half], [half, half], [-half, half]];
        Self { points_m: points_m.map(|[x, y]| Vector3::new(x, y, 0.0)), lens }
    }

    /// Pose from the homography; `None` where four corners are none or lie behind the camera.
    fn start(&self, corners: &[Vector2<f64>; 4]) -> Option<(Rotation3<f64>, Vector3<f64>)> {
        let (mut rows, mut right) = (SMatrix::<f64, 8, 8>::zeros(), SVector::<f64, 8>::zeros());
        let [fx, fy, ppx, ppy] = [self.lens.fx, self.lens.fy, self.lens.ppx, self.lens.ppy].map(f64::from);
        for (k, (point, corner)) in self.points_m.iter().zip(corners).enumerate() {
            let (x, y, u, v) = (point.x, point.y, (corner.x - ppx) / fx, (corner.y - ppy) / fy);
            rows.set_row(2 * k, &[x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y].into());
            rows.set_row(2 * k + 1, &[0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y].into());
            (right[2 * k], right[2 * k + 1]) = (u, v);
        }
        let h = rows.lu().solve(&right)?;
        let (h1, h2) = (Vector3::new(h[0], h[3], h[6]), Vector3::new(h[1], h[4], h[7]));
        let scale = 1.0 / (h1.norm() * h2.norm()).sqrt();
        let position_m = scale * Vector3::new(h[2], h[5], 1.0);
        let axes = Matrix3::from_columns(&[scale * h1, scale * h2, scale * scale * h1.cross(&h2)]);
        let sound = axes.iter().chain(position_m.iter()).all(|number| number.is_finite());
        // A tag whose back is seen would have its corners in the other order.
        (sound && axes.determinant() > 0.0).then(|| (Rotation3::from_matrix(&axes), position_m))
    }

    /// Residual r of a corner and its derivatives by w and t; `None` behind the camera.
    fn residual(
        &self,
        rotation: &Rotation3<f64>,
        position_m: &Vector3<f64>,
        point: &Vector3<f64>,
        corner: &Vector2<f64>,
    ) -> Option<(Vector2<f64>, SMatrix<f64, 2, 6>)> {
        let [fx, fy, ppx, ppy] = [self.lens.fx, self.lens.fy, self.lens.ppx, self.lens.ppy].map(f64::from);
        let turned = rotation * point;
        let at = turned + position_m;
        if at.z < 1e-3 {
            return None;
        }
        let (x, y) = (at.x / at.z, at.y / at.z);
        let residual = corner - Vector2::new(ppx + fx * x, ppy + fy * y);
        let by_place = Matrix2x3::new(fx, 0.0, -fx * x, 0.0, fy, -fy * y) / at.z;
        // w x R p = -[R p]x w
        let by_turn = -by_place * turned.cross_matrix();
        let mut derivatives = SMatrix::<f64, 2, 6>::zeros();
        derivatives.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_turn);
        derivatives.fixed_view_mut::<2, 3>(0, 3).copy_from(&by_place);
        Some((residual, derivatives))
    }

    /// Sums S, J^T r and J^T J at a pose.
    fn sums(
        &self,
        rotation: &Rotation3<f64>,
        position_m: &Vector3<f64>,
        corners: &[Vector2<f64>; 4],
    ) -> Option<(f64, Vector6<f64>, Matrix6<f64>)> {
        let (mut squares, mut gradient, mut information) = (0.0, Vector6::zeros(), Matrix6::zeros());
        for (point, corner) in self.points_m.iter().zip(corners) {
            let (residual, derivatives) = self.residual(rotation, position_m, point, corner)?;
            squares += residual.norm_squared();
            gradient += derivatives.transpose() * residual;
            information += derivatives.transpose() * derivatives;
        }
        Some((squares, gradient, information))
    }

    /// Gauss-Newton from a pose to a minimum, each step halved until S falls.
    fn refined(
        &self,
        (mut rotation, mut position_m): (Rotation3<f64>, Vector3<f64>),
        corners: &[Vector2<f64>; 4],
    ) -> Option<Minimum> {
        let (mut squares, mut gradient, mut information) = self.sums(&rotation, &position_m, corners)?;
        for _ in 0..STEPS {
            let mut step = information.cholesky()?.solve(&gradient);
            let mut lower = None;
            for _ in 0..8 {
                let turn = Rotation3::from_scaled_axis(step.fixed_rows::<3>(0).into_owned());
                let next = (turn * rotation, position_m + step.fixed_rows::<3>(3));
                if let Some(sums) = self.sums(&next.0, &next.1, corners).filter(|sums| sums.0 <= squares) {
                    lower = Some((next, sums));
                    break;
                }
                step *= 0.5;
            }
            let Some((next, sums)) = lower else { break };
            (rotation, position_m) = next;
            (squares, gradient, information) = sums;
            if step.fixed_rows::<3>(0).norm() + step.fixed_rows::<3>(3).norm() / position_m.norm() < CONVERGED
            {
                break;
            }
        }
        Some(Minimum { rotation, position_m, squares, information })
    }
}

#[cfg(test)]
mod tests;
