//! Troubles that somebody imposes on a running camera, one after the other, for runs that are longer than one trouble.

use super::trouble::{At, Trouble};
use super::{Device, Life};

impl Device {
    /// Imposes a trouble of the streams now. It ends by its cure, as one of the camera's own does; an unplugged camera is back
    /// two seconds later, and a fault of the wire strikes the next frame.
    pub fn impose(&mut self, trouble: Trouble, now_us: u64) {
        match trouble {
            Trouble::Wire(kind) => self.wire.strike_next(kind),
            Trouble::Unplug(At::Stream, back) => self.unplug(now_us, back),
            _ => {
                (self.trouble, self.life, self.struck_us, self.left) =
                    (Some(trouble), Life::Struck, now_us, 1);
            }
        }
    }

    /// Returns the middles of all exposures so far on the bus's clock, microseconds.
    #[must_use]
    pub fn exposures_us(&self) -> &[u64] {
        &self.exposures
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{Back, Cure, DEPTH, TestCard};
    use crate::fault_list::{FaultKind, FaultList};

    /// Commits both streams, so that the first exposure is 30 ms later.
    fn start(device: &mut Device, now_us: u64) {
        for interface in [1, 2] {
            device.control(now_us, [0x21, 1, 0, 2, interface, 0], &[]);
        }
    }

    /// Depth payloads that are due up to a time.
    fn depth_until(device: &mut Device, until_us: u64) -> usize {
        std::iter::from_fn(|| device.due(until_us)).filter(|event| event.endpoint == DEPTH).count()
    }

    #[test]
    fn each_trouble_strikes_when_it_is_imposed_and_goes_with_its_cure() {
        let mut device = Device::new(Box::<TestCard>::default(), None, FaultList::default(), 1);
        start(&mut device, 0);
        assert_eq!(
            depth_until(&mut device, 1_000_000),
            58,
            "a second without 30 ms, and the last is on its way"
        );
        for round in 0..2_u64 {
            let now_us = 1_000_000 + 20_000_000 * round;
            depth_until(&mut device, now_us);
            device.impose(Trouble::Quiet(Cure::Restart), now_us);
            let before = device.exposures_us().len();
            assert!(depth_until(&mut device, now_us + 1_000_000) <= 1, "quiet");
            assert_eq!(device.exposures_us().len(), before + 60, "it takes frames and keeps them");
            // The hardware monitor's restart: gone a tenth of a second later, back six seconds later.
            device.cure(Cure::Restart);
            device.leave(now_us + 1_100_000, now_us + 7_000_000);
            assert!(device.seen(now_us + 2_000_000).is_none());
            start(&mut device, now_us + 8_000_000);
            assert!(depth_until(&mut device, now_us + 9_000_000) > 50, "round {round}");
            device.impose(Trouble::Unplug(At::Stream, Back::Same), now_us + 9_000_000);
            assert!(device.seen(now_us + 9_500_000).is_none() && device.seen(now_us + 11_100_000).is_some());
            start(&mut device, now_us + 12_000_000);
            assert!(depth_until(&mut device, now_us + 13_000_000) > 50, "round {round}");
            device.impose(Trouble::Wire(FaultKind::Drop), now_us + 13_000_000);
            assert_eq!(depth_until(&mut device, now_us + 14_000_000), 59, "one was dropped");
        }
    }
}
