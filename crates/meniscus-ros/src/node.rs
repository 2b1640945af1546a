//! The node: its threads, and the order in which they end.

use crate::counters::{Counters, Counts};
use crate::error::{DOMAIN_MAX, RosError};
use crate::message::{PlanRequest, PlanResponse};
use crate::motion::{MotionReader, RosMotion};
use crate::outlet::{TurnOutlet, TurnQueue, turn_queue};
use crate::parameters::{self, Facts, LiveSettings};
use crate::plan_service::PlanService;
use crate::publishing::Publishing;
use crate::topics::Topics;
use crate::tracers::TracerLayout;
use crate::unsent;
use futures::channel::oneshot;
use futures::executor::block_on;
use meniscus::blob::Model;
use meniscus::latent::decoder::Selection;
use meniscus::surface::Config;
use meniscus_service::controller::SharedPlan;
use meniscus_service::run::Viewer;
use meniscus_service::snapshot::SnapshotOutlet;
use ros2_client::dds::rustdds::{DomainParticipant, DomainParticipantBuilder};
use ros2_client::qos::{History, WhenFull};
use ros2_client::{
    Context, Name, Node, NodeName, QosProfile, Server, ServiceMapping, ServiceTypeName, Spinner,
};
use std::net::{IpAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Settings of the node.
#[derive(Clone, Debug)]
pub struct RosSettings {
    /// ROS domain, 0 to 232.
    pub domain: u16,
    /// Addresses of this machine whose networks are used; none for all.
    pub networks: Vec<IpAddr>,
    /// Rate of the tracers' cloud, Hz.
    pub tracers_hz: f64,
    /// Probability of spilling above which the node warns.
    pub spill_limit: f64,
    /// Facts of the run.
    pub facts: Facts,
    /// Groups of the field that are decoded.
    pub decoded: Selection,
    /// Direction of the line of the model in the axes of the plans, of length one.
    pub line: [f64; 3],
    /// Reader of the camera's images, which knows where the camera stands.
    pub config: Config,
}

/// Parts that the thread of the node takes over.
struct Parts {
    node: Node,
    spinner: Spinner,
    topics: Topics,
    server: Server<PlanRequest, PlanResponse>,
    queue: TurnQueue,
    participant: DomainParticipant,
    motion: Option<RosMotion>,
}

/// A node, open, as a viewer of the run.
pub struct RosNode {
    parts: Mutex<Option<Parts>>,
    settings: RosSettings,
    layout: Option<TracerLayout>,
    snapshots: SnapshotOutlet,
    plan: SharedPlan,
    live: Arc<LiveSettings>,
    counters: Arc<Counters>,
    note: Mutex<String>,
    closing: AtomicBool,
}

impl std::fmt::Debug for RosNode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RosNode").field("settings", &self.settings).finish_non_exhaustive()
    }
}

impl RosNode {
    /// Opens the node `/meniscus` for a run of `model` that follows `plan` and takes `motion`; returns the worker's end and the node.
    ///
    /// # Errors
    /// [`RosError`].
    pub fn open(
        settings: RosSettings,
        model: &Model<'_>,
        plan: SharedPlan,
        motion: Option<RosMotion>,
    ) -> Result<(TurnOutlet, Self), RosError> {
        check(&settings)?;
        let live = Arc::new(LiveSettings::new(settings.tracers_hz, settings.spill_limit));
        let counters = Arc::new(Counters::default());
        let failed = |error: &dyn std::fmt::Display| RosError::Middleware(error.to_string());
        let mut participant = DomainParticipantBuilder::new(settings.domain);
        if !settings.networks.is_empty() {
            participant = participant.with_only_networks(settings.networks.iter().copied());
        }
        let participant = participant.build().map_err(|error| failed(&error))?;
        let context = Context::from_domain_participant(participant.clone())?;
        let name = NodeName::new("/", "meniscus").map_err(|error| RosError::Name(error.to_string()))?;
        let options = parameters::options(&settings.facts, &model.header, &live);
        let mut node = context.new_node(name, options).map_err(|error| failed(&error))?;
        let topics = Topics::open(&mut node, &counters)?;
        let server = plan_server(&mut node)?;
        let spinner = node.spinner()?;
        // What the middleware says about its own start is no trouble of the network.
        unsent::count_from_now();
        let layout = TracerLayout::of(model, settings.decoded);
        let field_len = layout.as_ref().map_or(0, TracerLayout::field_len);
        let (outlet, queue) = turn_queue(field_len, Arc::clone(&live), Arc::clone(&counters));
        let node = Self {
            parts: Mutex::new(Some(Parts { node, spinner, topics, server, queue, participant, motion })),
            settings,
            layout,
            // Nobody has a use for images.
            snapshots: SnapshotOutlet::new(0),
            plan,
            live,
            counters,
            note: Mutex::default(),
            closing: AtomicBool::new(false),
        };
        Ok((outlet, node))
    }

    /// Whether there is a cloud of tracers.
    #[must_use]
    pub fn has_tracers(&self) -> bool {
        self.layout.is_some()
    }

    /// Returns the counters with the reason of the last datagram that could not be sent.
    #[must_use]
    pub fn counts(&self) -> (Counts, String) {
        (self.counters.counts(), unsent::last())
    }
}

/// Checks the settings.
fn check(settings: &RosSettings) -> Result<(), RosError> {
    if settings.domain > DOMAIN_MAX {
        return Err(RosError::Domain(settings.domain));
    }
    for address in &settings.networks {
        UdpSocket::bind((*address, 0)).map_err(|error| RosError::Network(*address, error))?;
    }
    for (what, value, range) in [
        ("tracers_hz", settings.tracers_hz, parameters::TRACERS_HZ_RANGE),
        ("spill_limit", settings.spill_limit, parameters::SPILL_LIMIT_RANGE),
    ] {
        if !range.contains(&value) {
            return Err(RosError::Range(what, value));
        }
    }
    Ok(())
}

/// Opens the service of plans.
fn plan_server(node: &mut Node) -> Result<Server<PlanRequest, PlanResponse>, RosError> {
    let name = Name::new("/liquid", "plan").map_err(|error| RosError::Name(error.to_string()))?;
    let kind = ServiceTypeName::new("meniscus_msgs", "Plan");
    let qos = QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Fail)
        .history(History::KeepLast { depth: 10 });
    Ok(node.create_server(ServiceMapping::Enhanced, &name, &kind, qos.clone(), qos)?)
}

impl Viewer for RosNode {
    /// The newest turn, for the service of plans.
    fn sink(&self) -> SnapshotOutlet {
        self.snapshots.clone()
    }

    fn show(&self, model: &Model<'_>) {
        let parts = self.parts.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(Parts { node, spinner, topics, server, queue, participant, mut motion }) = parts else {
            return;
        };
        let node = Mutex::new(node);
        let (stop, stopped) = oneshot::channel();
        std::thread::scope(|scope| {
            // It answers for the parameters.
            scope.spawn(move || drop(block_on(spinner.spin())));
            let service = PlanService {
                server: &server,
                snapshots: &self.snapshots,
                plan: &self.plan,
                line: self.settings.line,
                counters: &self.counters,
            };
            scope.spawn(move || block_on(service.attend(model, stopped)));
            if let Some(motion) = &mut motion {
                let reader = MotionReader::of(motion, participant);
                scope.spawn(|| reader.run(&node, &self.closing));
            }
            let publishing = Publishing {
                model,
                config: &self.settings.config,
                layout: self.layout.as_ref(),
                node: &node,
                topics: &topics,
                queue: &queue,
                plan: &self.plan,
                live: &self.live,
                counters: &self.counters,
                camera: &self.settings.facts.camera,
                note: &self.note,
            };
            publishing.run(&self.closing);
            // All threads are waited for at the end of the scope.
            drop(stop);
            node.lock().unwrap_or_else(PoisonError::into_inner).stop_spinner();
        });
    }

    fn tell(&self, note: &str) {
        note.clone_into(&mut self.note.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn end(&self) {
        self.closing.store(true, Ordering::Relaxed);
    }
}
