//! Reasons for which there is no node.

use ros2_client::CreateError;
use std::net::IpAddr;

/// Largest domain whose ports exist.
pub(crate) const DOMAIN_MAX: u16 = 232;

/// Reason for which there is no node.
#[derive(Debug)]
pub enum RosError {
    /// The domain is none.
    Domain(u16),
    /// The address is not one of this machine.
    Network(IpAddr, std::io::Error),
    /// A setting is out of its range.
    Range(&'static str, f64),
    /// A name is none.
    Name(String),
    /// The middleware cannot start.
    Middleware(String),
}

impl std::fmt::Display for RosError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Domain(domain) => {
                write!(
                    f,
                    "there is no ROS domain {domain}: they are 0 to {DOMAIN_MAX}, by default ROS_DOMAIN_ID or 0"
                )
            }
            Self::Network(address, error) => {
                write!(f, "{address} is not an address of this machine ({error}): `ip address` lists them")
            }
            Self::Range(what, value) => write!(f, "{what} {value} is out of range"),
            Self::Name(error) => write!(f, "a name of the node is refused: {error}"),
            Self::Middleware(error) => {
                write!(f, "ROS 2 cannot start: {error}. Is the network up, and multicast allowed?")
            }
        }
    }
}

impl std::error::Error for RosError {}

impl From<CreateError> for RosError {
    fn from(error: CreateError) -> Self {
        Self::Middleware(error.to_string())
    }
}
