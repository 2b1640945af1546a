//! Messages that the peers received, held against what was published.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Turns that are looked at: ten seconds.
pub(crate) const WINDOW: u64 = 600;

/// Turns before them, in which a peer may still find the last of its publishers.
const SETTLING: u64 = 30;

/// Messages of a topic in the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Count {
    pub(crate) received: u64,
    pub(crate) published: u64,
}

/// Time from the end of a turn to the callback of a peer, ms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Latency {
    pub(crate) median: f64,
    pub(crate) p99: f64,
    pub(crate) most: f64,
}

/// Latency of a topic of the node, and of the same messages from rclpy to rclpy in the same seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compared {
    pub(crate) topic: &'static str,
    pub(crate) node: Latency,
    pub(crate) peers: Latency,
}

/// An estimate as rclpy received it.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    stamp_ns: u64,
    received_ns: u64,
    ended_ns: u64,
    has_frame: bool,
    has_tracers: bool,
    left_out: u64,
}

/// The window, by the numbers of the turns.
pub(crate) struct Arrivals {
    turns: BTreeMap<u64, Arrival>,
    first: u64,
}

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn rows(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("{value} is no list"))
}

impl Arrivals {
    /// Returns the window of a listener: 600 turns, from half a second behind the first one that both peers had.
    pub(crate) fn of(rclpy: &Value, cyclone: &Value) -> Self {
        let turns: BTreeMap<u64, Arrival> = rows(&rclpy["estimates"])
            .iter()
            .map(|row| {
                let (stamp_ns, latency_s) = (number(&row[1]), row[3].as_f64().expect("a latency"));
                let arrival = Arrival {
                    stamp_ns,
                    received_ns: number(&row[2]),
                    ended_ns: stamp_ns + (1e9 * latency_s) as u64,
                    has_frame: row[4] == true,
                    left_out: number(&row[5]),
                    has_tracers: row[6] == true,
                };
                (number(&row[0]), arrival)
            })
            .collect();
        let first_of_cyclone = number(&rows(&cyclone["came"]["liquid/estimate"])[0][2]);
        let first_of_rclpy = *turns.keys().next().expect("estimates came");
        Self { turns, first: first_of_rclpy.max(first_of_cyclone) + SETTLING }
    }

    fn window(&self) -> impl Iterator<Item = (u64, &Arrival)> {
        self.turns.range(self.first..self.first + WINDOW).map(|(turn, arrival)| (*turn, arrival))
    }

    /// Returns the messages of each topic. A turn that the node left out and counted was not published; a position of the glass
    /// is published for each frame.
    pub(crate) fn counts(&self, rclpy: &Value, cyclone: &Value) -> Vec<(&'static str, Count)> {
        let stamps: Vec<u64> = self.window().map(|(_, arrival)| arrival.stamp_ns).collect();
        let received = stamps.len() as u64;
        let left_out = |turn: Option<&Arrival>| turn.map_or(0, |arrival| arrival.left_out);
        let before = self.turns.range(..self.first).next_back().map(|(_, arrival)| arrival);
        let last = self.turns.range(..self.first + WINDOW).next_back().map(|(_, arrival)| arrival);
        let published = WINDOW - (left_out(last) - left_out(before));
        let among = |rows: &[Value], of: &[u64]| {
            let came: BTreeSet<u64> = rows.iter().map(|row| number(&row[0])).collect();
            of.iter().filter(|stamp| came.contains(stamp)).count() as u64
        };
        let frames: Vec<u64> = self
            .window()
            .filter(|(_, arrival)| arrival.has_frame)
            .map(|(_, arrival)| arrival.stamp_ns)
            .collect();
        let clouds_of: Vec<u64> = self
            .window()
            .filter(|(_, arrival)| arrival.has_tracers)
            .map(|(_, arrival)| arrival.stamp_ns)
            .collect();
        let came = &cyclone["came"];
        let numbers = rows(&came["liquid/estimate"]).iter().map(|row| number(&row[2]));
        let in_window: BTreeSet<u64> =
            numbers.filter(|turn| (self.first..self.first + WINDOW).contains(turn)).collect();
        let (begin, end) = (stamps.first().copied().unwrap_or(0), stamps.last().copied().unwrap_or(0));
        let reports = rows(&came["diagnostics"]).iter().map(|row| number(&row[0]));
        let reports = reports.filter(|stamp| (begin..end).contains(stamp)).count() as u64;
        let clouds = &rclpy["clouds"];
        let count = |received, published| Count { received, published };
        vec![
            ("/liquid/estimate, rclpy", count(received, published)),
            ("/liquid/estimate, Cyclone", count(in_window.len() as u64, published)),
            (
                "/liquid/tracers, rclpy",
                count(among(rows(&clouds["tracers"]), &clouds_of), clouds_of.len() as u64),
            ),
            ("/liquid/surface, rclpy", count(among(rows(&clouds["surface"]), &stamps), published)),
            ("/tf, Cyclone", count(among(rows(&came["tf"]), &frames), frames.len() as u64)),
            // Ten seconds begin anywhere between two of them.
            ("/diagnostics, Cyclone", count(reports.min(9), 9)),
        ]
    }

    /// Returns the latency of each topic in the window, beside that of what a talker sent to the listener `peers` meanwhile.
    pub(crate) fn latencies(&self, rclpy: &Value, cyclone: &Value, peers: &Value) -> Vec<Compared> {
        let ended: BTreeMap<u64, u64> =
            self.window().map(|(_, arrival)| (arrival.stamp_ns, arrival.ended_ns)).collect();
        let of = |rows: &[Value]| {
            let passed = rows.iter().filter_map(|row| {
                let ended = ended.get(&number(&row[0]))?;
                Some(1e-6 * (number(&row[1]) as f64 - *ended as f64))
            });
            latency(passed.collect())
        };
        let own =
            self.window().map(|(_, arrival)| 1e-6 * (arrival.received_ns as f64 - arrival.ended_ns as f64));
        let times = || self.window().map(|(_, arrival)| arrival.received_ns);
        let meanwhile = times().min().unwrap_or(0)..times().max().unwrap_or(0);
        // A talker's stamp is the time at which it begins to publish.
        let between = |rows: &[Value], stamp: usize, received: usize| {
            let rows = rows.iter().map(|row| (number(&row[stamp]), number(&row[received])));
            let passed = rows
                .filter(|(_, received)| meanwhile.contains(received))
                .map(|(stamp, received)| 1e-6 * (received as f64 - stamp as f64));
            latency(passed.collect())
        };
        let (clouds, came) = (&rclpy["clouds"], &cyclone["came"]);
        let estimates = between(rows(&peers["estimates"]), 1, 2);
        let [once, surface, tracers] =
            [&peers["once"], &peers["clouds"]["surface"], &peers["clouds"]["tracers"]]
                .map(|topic| between(rows(topic), 0, 1));
        let compared = |topic, node, peers| Compared { topic, node, peers };
        vec![
            compared("/liquid/estimate, rclpy", latency(own.collect()), estimates),
            compared("/liquid/estimate, Cyclone", of(rows(&came["liquid/estimate"])), estimates),
            compared("/tf, Cyclone", of(rows(&came["tf"])), estimates),
            compared("/liquid/tracers, as sensor data", of(rows(&rclpy["once"])), once),
            compared("/liquid/surface, rclpy", of(rows(&clouds["surface"])), surface),
            compared("/liquid/tracers, rclpy", of(rows(&clouds["tracers"])), tracers),
        ]
    }

    /// Returns the tracers' clouds of the window that a reader of sensor data had, for which no lost part is sent again.
    pub(crate) fn sent_once(&self, rclpy: &Value) -> usize {
        let came: BTreeSet<u64> = rows(&rclpy["once"]).iter().map(|row| number(&row[0])).collect();
        self.window().filter(|(_, arrival)| came.contains(&arrival.stamp_ns)).count()
    }

    /// Returns the clouds of tracers and the turns that came behind `since_ns`.
    pub(crate) fn behind(&self, rclpy: &Value, since_ns: u64) -> [usize; 2] {
        let clouds =
            rows(&rclpy["clouds"]["tracers"]).iter().filter(|row| number(&row[1]) > since_ns).count();
        [clouds, self.turns.values().filter(|arrival| arrival.received_ns > since_ns).count()]
    }
}

fn latency(mut passed: Vec<f64>) -> Latency {
    passed.sort_by(f64::total_cmp);
    let at = |share: f64| passed.get((share * passed.len() as f64) as usize).copied().unwrap_or(f64::NAN);
    Latency { median: at(0.5), p99: at(0.99), most: passed.last().copied().unwrap_or(f64::NAN) }
}

/// Holds the last messages against what the run has to have in them; `left_out` are the turns that it left out by a full queue
/// up to its end.
pub(crate) fn check_content(rclpy: &Value, cyclone: &Value, left_out: u64) {
    let described = &rclpy["described"];
    let names = ["x", "y", "z", "vx", "vy", "vz", "energy", "sxx", "syy", "szz", "sxy", "syz", "szx"];
    let tracers = &described["tracers"];
    assert_eq!(tracers["fields"], serde_json::json!(names));
    assert_eq!(
        (&tracers["frame"], &tracers["points"], &tracers["step"]),
        (&"glass".into(), &2134.into(), &52.into())
    );
    let first: Vec<f64> = rows(&tracers["first"]).iter().filter_map(Value::as_f64).collect();
    let radius = first[0].hypot(first[1]);
    assert!(radius <= 0.035 && (0.0..0.11).contains(&first[2]), "a tracer is in the glass: {first:?}");
    // Hydrostatics: about -rho g h at the bottom of 70 mm of glycerine.
    assert!((-1500.0..-500.0).contains(&first[9]) && first[2] < 0.02, "{first:?}");
    let surface = &described["surface"];
    assert_eq!(surface["fields"], serde_json::json!(["x", "y", "z", "half_width", "measured"]));
    assert_eq!((&surface["frame"], &surface["points"]), (&"glass".into(), &21.into()));
    let first: Vec<f64> = rows(&surface["first"]).iter().take(5).filter_map(Value::as_f64).collect();
    // The first point is at -0.9 of the radius on the wall that faces the camera.
    assert!((first[0] + 0.9 * 0.035).abs() < 1e-6 && first[1] < 0.0, "{first:?}");
    assert!((first[0].hypot(first[1]) - 0.035).abs() < 1e-6, "{first:?}");
    assert!((first[2] - first[4]).abs() < 0.005, "estimated and measured height: {first:?}");
    assert_eq!(rclpy["finite"], true, "modes and covariances are numbers");
    let crest = rows(&rclpy["crest"]);
    assert!((0.06..0.11).contains(&crest[0].as_f64().expect("a crest")), "{crest:?}");
    let tf = rows(&cyclone["tf"]);
    assert_eq!((&tf[0], &tf[1]), (&"meniscus_camera".into(), &"glass".into()));
    // The simulated camera is level, 400 mm before the glass and 30 mm above its foot.
    let place: Vec<f64> = rows(&tf[2]).iter().filter_map(Value::as_f64).collect();
    assert!(
        (place[1] - 0.03).abs() < 1e-6 && (place[2] - 0.4).abs() < 1e-6 && place[0].abs() < 0.2,
        "{place:?}"
    );
    let reports = rows(&cyclone["reports"]);
    // On a slow machine a frame may be missing just when the report is made.
    let tracking = reports.iter().filter(|report| report["meniscus: estimate"][1] == "tracking").count();
    assert!(2 * tracking > reports.len(), "{tracking} of {} reports", reports.len());
    let status = reports.last().expect("a report");
    assert_eq!(status["meniscus: ROS 2"][2]["readers of estimate"], "2", "{status:#}");
    let reported = &status["meniscus: ROS 2"][2]["turns left out by a full queue"];
    let reported: u64 = reported.as_str().and_then(|count| count.parse().ok()).expect("a count");
    assert!(reported <= left_out, "{reported} of {left_out}: {status:#}");
}
