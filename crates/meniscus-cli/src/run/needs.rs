//! Needs of a run from the system around it: addresses, devices, folders, files.

use super::config::{Controlling, Encryption, RunConfig};
use super::motion_source::MotionSource;
use meniscus_service::publish::Destination;
use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};

/// Needs of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Needs {
    /// Addresses that are sent to or heard; an unspecified one stands for everybody in the local networks.
    pub(crate) peers: BTreeSet<IpAddr>,
    /// Whether multicast is sent and heard.
    pub(crate) multicast: bool,
    /// Serial devices.
    pub(crate) serial: BTreeSet<PathBuf>,
    /// Unix sockets.
    pub(crate) sockets: BTreeSet<PathBuf>,
    /// Folders that are written.
    pub(crate) written: BTreeSet<PathBuf>,
    /// Files and folders that are read.
    pub(crate) read: BTreeSet<PathBuf>,
}

impl Needs {
    /// Needs of a run of `config`.
    pub(super) fn of(config: &RunConfig) -> Self {
        let mut needs = Self::default();
        for destination in &config.publishing.destinations {
            match destination {
                Destination::Unix(path) => drop(needs.sockets.insert(path.clone())),
                Destination::Udp(address) => drop(needs.peers.insert(address.ip())),
                Destination::Serial(device, _) => drop(needs.serial.insert(device.clone())),
            }
        }
        if let Some(page) = &config.page {
            needs.listens(page.listen, None);
            needs.read.extend(page.token_file.clone());
            if let Encryption::Given { certificate, key } = &page.encryption {
                needs.read.extend([certificate.clone(), key.clone()]);
            }
        }
        if let Some(address) = config.foxglove.address {
            needs.listens(address, None);
        }
        if let Some(ros) = &config.ros2 {
            // Peers announce themselves: their addresses are not known before.
            let alone = !ros.networks.is_empty() && ros.networks.iter().all(IpAddr::is_loopback);
            let peers = if alone { Ipv4Addr::LOCALHOST } else { Ipv4Addr::UNSPECIFIED };
            needs.peers.insert(peers.into());
            needs.multicast = true;
        }
        match &config.motion {
            Some(MotionSource::Udp(wire)) => needs.listens(wire.address, wire.expected.address),
            Some(MotionSource::Table(table)) => needs.reads(Path::new(table)),
            // A topic is heard by the node, a tag is in the camera's images.
            Some(MotionSource::Truth | MotionSource::Topic(_) | MotionSource::Tag(_)) | None => {}
        }
        if let Controlling::On(Some(plans)) = &config.publishing.controller {
            needs.listens(plans.address, plans.expected.address);
        }
        needs.written.insert(config.out.clone());
        let files = [&config.turn_table, &config.estimates, &config.foxglove.file];
        needs
            .written
            .extend(files.into_iter().flatten().filter_map(|file| file.parent()).map(Path::to_path_buf));
        needs.read.extend(config.setup.clone());
        needs.reads(&config.model);
        config.among.iter().for_each(|name| needs.reads(Path::new(name)));
        needs
    }

    /// A server at `address`, asked by `from` alone where that is known.
    fn listens(&mut self, address: SocketAddr, from: Option<IpAddr>) {
        self.peers.insert(from.unwrap_or(address.ip()));
    }

    /// A file, where the name is one; `shipped` and the names of motions are none.
    fn reads(&mut self, path: &Path) {
        if path.is_absolute() {
            self.read.insert(path.into());
        }
    }
}
