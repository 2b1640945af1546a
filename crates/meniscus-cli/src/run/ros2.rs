//! `--ros2`: the run as a ROS 2 node.

use super::config::RosConfig;
use anyhow::{Context, ensure};
use std::net::IpAddr;

#[cfg(feature = "ros2")]
pub(super) use open_node::{Ros, open};

/// Default of --ros2-tracers-hz.
const TRACERS_HZ: f64 = 60.0;

/// Default of --ros2-spill-limit.
const SPILL_LIMIT: f64 = 0.05;

/// Variable of ROS 2 with the domain.
const DOMAIN_VARIABLE: &str = "ROS_DOMAIN_ID";

/// Flags of the node.
#[derive(clap::Args)]
pub(super) struct RosArguments {
    /// Be the ROS 2 node /meniscus in this domain [default: by ROS_DOMAIN_ID].
    ///
    /// Topics /liquid/estimate, /liquid/tracers, /liquid/surface, /tf and /diagnostics, parameters, and the service
    /// /liquid/plan; docs/robots.md has them. No ROS has to be installed. Everybody in the domain may read, and nobody can
    /// change the estimate. Needs a program built with --features ros2.
    #[arg(
        long,
        value_name = "DOMAIN",
        num_args = 0..=1,
        default_missing_value = "",
        help_heading = "ROS2",
        value_parser = domain
    )]
    ros2: Option<u16>,
    /// With --ros2: own address whose network is used; may be repeated.
    ///
    /// 127.0.0.1 for this machine alone. Without it every network is used, as ROS 2 does.
    #[arg(long, value_name = "ADDRESS", requires = "ros2", help_heading = "ROS2")]
    ros2_network: Vec<IpAddr>,
    /// With --ros2: rate of /liquid/tracers, Hz, 0 to 60 [default: 60].
    ///
    /// At 60 Hz it takes 7 MB/s. The parameter tracers_hz changes it while the run goes.
    #[arg(long, value_name = "HZ", requires = "ros2", help_heading = "ROS2")]
    ros2_tracers_hz: Option<f64>,
    /// With --ros2: probability of spilling, 0 to 1, above which /liquid/estimate warns [default: 0.05].
    ///
    /// The parameter spill_limit changes it while the run goes.
    #[arg(long, value_name = "PROBABILITY", requires = "ros2", help_heading = "ROS2")]
    ros2_spill_limit: Option<f64>,
}

/// Returns the domain that `text` spells, or that of the environment.
fn domain(text: &str) -> Result<u16, String> {
    let (text, from) = match (text, std::env::var(DOMAIN_VARIABLE)) {
        ("", Ok(variable)) => (variable, format!("{DOMAIN_VARIABLE}=")),
        ("", Err(_)) => return Ok(0),
        (text, _) => (text.to_owned(), String::new()),
    };
    let domain = text.trim().parse().ok().filter(|domain| (0..=232).contains(domain));
    domain.ok_or_else(|| format!("{from}{text} is no ROS domain: write a number from 0 to 232"))
}

impl RosArguments {
    /// Returns the configuration; `None` without the node.
    pub(super) fn config(&self) -> anyhow::Result<Option<RosConfig>> {
        let Some(domain) = self.ros2 else { return Ok(None) };
        ensure!(
            cfg!(feature = "ros2"),
            "this program was built without ROS 2; from the repository: cargo run --release --features ros2 -- run --ros2"
        );
        let tracers_hz = self.ros2_tracers_hz.unwrap_or(TRACERS_HZ);
        ensure!(
            (0.0..=60.0).contains(&tracers_hz),
            "--ros2-tracers-hz {tracers_hz} is out of range: 0 to 60"
        );
        let spill_limit = self.ros2_spill_limit.unwrap_or(SPILL_LIMIT);
        ensure!(
            (0.0..=1.0).contains(&spill_limit),
            "--ros2-spill-limit {spill_limit} is out of range: 0 to 1"
        );
        for address in &self.ros2_network {
            std::net::UdpSocket::bind((*address, 0)).with_context(|| {
                format!("--ros2-network {address} is no address of this machine (`ip address` lists them)")
            })?;
        }
        Ok(Some(RosConfig { domain, networks: self.ros2_network.clone(), tracers_hz, spill_limit }))
    }
}

#[cfg(feature = "ros2")]
mod open_node {
    use super::super::config::RunConfig;
    use super::super::motion_source::MotionSource;
    use super::super::motion_topic::TopicMotion;
    use anyhow::Context;
    use meniscus::blob::Model;
    use meniscus::surface::Config;
    use meniscus_ros::{Facts, FramePair, MotionTopic, RosMotion, RosNode, RosSettings, TurnOutlet};
    use meniscus_service::commanded_motion::MotionInlet;
    use meniscus_service::controller::SharedPlan;
    use meniscus_service::run::Viewer;
    use meniscus_service::sink::TurnSink;

    /// The worker's end and the node behind it.
    pub(in super::super) struct Ros {
        outlet: TurnOutlet,
        node: RosNode,
    }

    /// Opens the node; `None` where it is not wanted.
    pub(in super::super) fn open(
        config: &RunConfig,
        model: &Model<'_>,
        reader: Config,
        camera: &str,
        plan: &SharedPlan,
        inlet: Option<MotionInlet>,
    ) -> anyhow::Result<Option<Ros>> {
        let Some(ros) = &config.ros2 else { return Ok(None) };
        let motion = inlet.and_then(|inlet| Some(RosMotion { topic: topic(config)?, inlet }));
        let settings = RosSettings {
            domain: ros.domain,
            networks: ros.networks.clone(),
            tracers_hz: ros.tracers_hz,
            spill_limit: ros.spill_limit,
            facts: Facts { model: config.model_name.clone(), camera: camera.into() },
            decoded: config.fields,
            line: config.motion_line,
            config: reader,
        };
        let (outlet, node) = RosNode::open(settings, model, plan.clone(), motion).context("--ros2")?;
        let without =
            if node.has_tracers() { "" } else { "; no /liquid/tracers, as their positions are not decoded" };
        eprintln!("ROS 2: node /meniscus in domain {}{without}", ros.domain);
        Ok(Some(Ros { outlet, node }))
    }

    /// Returns the topic of the motion; `None` of another motion.
    fn topic(config: &RunConfig) -> Option<MotionTopic> {
        let Some(MotionSource::Topic(motion)) = &config.motion else { return None };
        let TopicMotion { topic, frames, joint, axis, clock, .. } = motion.clone();
        let frames = frames.map(|frames| FramePair { parent: frames.parent, child: frames.child });
        Some(MotionTopic { topic, frames, joint, axis, clock })
    }

    impl Ros {
        /// The worker's end, and the node as a viewer.
        pub(in super::super) fn parts(&mut self) -> (&mut dyn TurnSink, &dyn Viewer) {
            (&mut self.outlet, &self.node)
        }

        /// Says what became of the turns.
        pub(in super::super) fn close(self) {
            let (counts, reason) = self.node.counts();
            eprintln!(
                "ROS 2: {} turns published, {} plans answered; left out {} turns by a full queue, {} that a frame overtook, \
                 {} messages refused by the middleware",
                counts.turns, counts.plans, counts.queue_full, counts.overtaken, counts.refused
            );
            if counts.unsent > 0 {
                eprintln!("ROS 2: {} datagrams could not be sent; the last: {reason}", counts.unsent);
            }
        }
    }
}

/// A program without ROS 2 has none of these.
#[cfg(not(feature = "ros2"))]
pub(super) enum Ros {}

#[cfg(not(feature = "ros2"))]
impl Ros {
    pub(super) fn parts(
        &mut self,
    ) -> (&mut dyn meniscus_service::sink::TurnSink, &dyn meniscus_service::run::Viewer) {
        match *self {}
    }

    pub(super) fn close(self) {
        match self {}
    }
}

/// Opens nothing: the configuration has refused ROS 2.
#[cfg(not(feature = "ros2"))]
pub(super) fn open(
    _: &super::config::RunConfig,
    _: &meniscus::blob::Model<'_>,
    _: meniscus::surface::Config,
    _: &str,
    _: &meniscus_service::controller::SharedPlan,
    _: Option<meniscus_service::commanded_motion::MotionInlet>,
) -> anyhow::Result<Option<Ros>> {
    Ok(None)
}
