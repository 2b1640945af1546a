//! Messages and services as they go over the wire: fields in the order of their definitions.

mod cloud;
mod diagnostics;
mod estimate;
mod header;
mod motion;
mod plan;
mod transform;

pub use cloud::{PointCloud2, PointField};
pub use diagnostics::{DiagnosticArray, DiagnosticStatus, KeyValue, Level};
pub use estimate::Estimate;
pub(crate) use estimate::EstimateParts;
pub(crate) use header::GLASS;
pub use header::{Header, Octets, Stamp};
pub use motion::{
    Covariance, Imu, JointState, Odometry, Pose, PoseStamped, PoseWithCovariance, Twist, TwistWithCovariance,
};
pub use plan::{PlanRequest, PlanResponse, PlanSample, Point, SurfaceForecast};
pub use transform::{Quaternion, TransformMessage, TransformStamped, Vector3};
