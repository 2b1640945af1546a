//! A network namespace for a scene: a loopback interface with multicast, or a cable to a peer in another namespace.

use crate::peers::Peer;
use std::path::Path;
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Address of this end of the cable.
pub(crate) const NEAR: &str = "10.9.0.1";

/// Commands of the other end before the peer: the cable comes, and gets its address.
const FAR: &str = "until ip link show far >/dev/null 2>&1; do sleep 0.02; done
ip link set lo up && ip address add 10.9.0.2/24 dev far && ip link set far up multicast on \\
&& ip route add 224.0.0.0/4 dev far && exec \"$@\"";

/// Configuration of Cyclone at the other end.
const FAR_CYCLONE: &str =
    "<General><Interfaces><NetworkInterface name='far' multicast='true'/></Interfaces></General>";

/// Variable that says that a scene is in its namespace.
const INSIDE: &str = "MENISCUS_ROS2_SCENE";

/// Runs the ignored test `scene` of this program in a network namespace of its own.
pub(crate) fn enter(scene: &str) {
    // One after the other: they are held to times.
    static ONE: Mutex<()> = Mutex::new(());
    let _turn = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(why) = crate::peers::missing() {
        return crate::optional::skip(&why);
    }
    crate::peers::prepare();
    let program = std::env::current_exe().expect("this program");
    // As root the scene goes before the other work of the machine, so that times are the node's. Other users get a namespace of
    // users as well, and a warning of `nice`.
    let root = Command::new("unshare").args(["-n", "true"]).status().is_ok_and(|status| status.success());
    let output = Command::new("nice")
        .args(["-n", "-15", "unshare", if root { "-n" } else { "-rn" }, "--"])
        .arg(&program)
        .args(["--exact", scene, "--ignored", "--nocapture"])
        .env(INSIDE, "1")
        .output()
        .expect("nice is everywhere");
    let text =
        format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    println!("{text}");
    // The reason once more behind everything: a log may be cut at its begin.
    let why = text.split("panicked at ").nth(1).and_then(|behind| behind.split("stack backtrace").next());
    assert!(output.status.success(), "{scene} failed: {}", why.unwrap_or("above is what it said"));
    assert!(text.contains("1 passed"), "{scene} was not found");
}

/// Brings the loopback interface up.
pub(crate) fn set_up() {
    assert!(
        std::env::var_os(INSIDE).is_some(),
        "a scene changes the network: it is for a namespace of its own"
    );
    ip(&["link", "set", "lo", "up"]);
    ip(&["link", "set", "lo", "multicast", "on"]);
    ip(&["route", "add", "224.0.0.0/4", "dev", "lo"]);
    ip(&["route", "add", "default", "dev", "lo"]);
}

/// A cable between two namespaces.
pub(crate) struct Cable;

impl Cable {
    /// Starts a peer in a namespace of its own, and connects both.
    pub(crate) fn plug(source: &str, arguments: &[&str]) -> Peer {
        assert!(
            std::env::var_os(INSIDE).is_some(),
            "a scene changes the network: it is for a namespace of its own"
        );
        let mut command = Command::new("unshare");
        command.args(["-n", "sh", "-c", FAR, "sh"]).env("CYCLONEDDS_URI", FAR_CYCLONE);
        let peer = Peer::start_by(command, source, arguments);
        let space = |pid: &str| {
            std::fs::read_link(Path::new("/proc").join(pid).join("ns/net")).expect("its namespace")
        };
        let pid = peer.id();
        while space(&pid) == space("self") {
            std::thread::sleep(Duration::from_millis(10));
        }
        ip(&["link", "set", "lo", "up"]);
        ip(&["link", "add", "near", "type", "veth", "peer", "name", "far", "netns", &pid]);
        ip(&["address", "add", &format!("{NEAR}/24"), "dev", "near"]);
        Self::put_back();
        peer
    }

    /// Puts the cable in.
    pub(crate) fn put_back() {
        ip(&["link", "set", "near", "up", "multicast", "on"]);
        ip(&["route", "add", "224.0.0.0/4", "dev", "near"]);
    }

    /// Pulls it out.
    pub(crate) fn pull() {
        ip(&["link", "set", "near", "down"]);
    }
}

/// Runs `ip`.
fn ip(arguments: &[&str]) {
    let output = Command::new("ip").args(arguments).output().expect("ip is there (apt-get install iproute2)");
    assert!(output.status.success(), "ip {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}
