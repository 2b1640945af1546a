//! Control requests from the device's side: descriptors, clear-halt, hardware monitor, probe, commit.

use super::descriptors::{self, COLOUR_CONTROL, COLOUR_STREAMING, COLOUR_TERMINAL};
use super::firmware::Heard;
use super::trouble::{At, Cure, Trouble};
use super::{Device, Life, Reply};

impl Device {
    /// A control request: setup packet without its length, and the bytes sent.
    pub fn control(&mut self, now_us: u64, setup: [u8; 6], sent: &[u8]) -> Reply {
        if self.is_away(now_us) {
            return Reply::Gone;
        }
        let step = match setup {
            [0x80, 6, ..] => Some(At::Open),
            [_, _, 0, 1, 0, 3] => Some(At::Calibration),
            [_, _, 0, 1, _, 0] => Some(At::Probe),
            [_, _, 0, 2, _, 0] => Some(At::Commit),
            [0x02, 1, ..] => Some(At::Start),
            _ => None,
        };
        if let (Some(Trouble::Unplug(at, back)), Life::Ahead) = (self.trouble, self.life)
            && step == Some(at)
        {
            self.unplug(now_us, back);
            return Reply::Gone;
        }
        if let Some(replay) = &mut self.replay
            && let Some(reply) = replay.control(setup, sent)
        {
            self.note_commit(now_us, setup);
            return reply;
        }
        match setup {
            [0x80, 6, 0, 2, 0, 0] if self.trouble == Some(Trouble::SilentDescriptors) => Reply::Silence,
            [0x80, 6, 0, 2, 0, 0] => Reply::Data(descriptors::configuration(self.usb2(now_us), self.trouble)),
            [0x02, 1, 0, 0, endpoint, 0] => self.clear_halt(endpoint),
            [request_type, _, 0, 1, 0, 3] => self.monitor(now_us, request_type == 0x21, sent),
            [0x21, 1, 0, _, 0, 3] => Reply::Done,
            // Exposure mode and priority of the colour function's camera terminal.
            [0x21, 1, 0, 2 | 3, COLOUR_CONTROL, COLOUR_TERMINAL] => Reply::Done,
            [0x21, 1, 0, 1, interface @ (1 | 2 | COLOUR_STREAMING), 0] => self.probe(interface, sent),
            // The current record, the least or the greatest: a kernel's driver asks for all three.
            [0xa1, 0x81..=0x83, 0, 1, interface @ (1 | 2 | COLOUR_STREAMING), 0] => {
                self.probe_answer(interface, setup[1] == 0x83)
            }
            [0x21, 1, 0, 2, interface @ (1 | 2 | COLOUR_STREAMING), 0] => {
                self.commit(now_us, interface, setup)
            }
            _ => Reply::Stall,
        }
    }

    /// The configuration descriptor as a kernel reads it while it enumerates, before any program's request.
    #[must_use]
    pub fn enumerated(&self, now_us: u64) -> Vec<u8> {
        descriptors::configuration(self.usb2(now_us), self.trouble)
    }

    fn clear_halt(&mut self, endpoint: u8) -> Reply {
        if self.trouble == Some(Trouble::ClearHaltRefused) && self.life == Life::Struck {
            return Reply::Stall;
        }
        self.halted.remove(&endpoint);
        self.cure(Cure::ClearHalt);
        Reply::Done
    }

    fn monitor(&mut self, now_us: u64, command: bool, sent: &[u8]) -> Reply {
        if self.trouble == Some(Trouble::MonitorSilent) {
            return Reply::Silence;
        }
        if matches!(self.trouble, Some(Trouble::MonitorStalls(_))) && self.strike() {
            return Reply::Stall;
        }
        if !command {
            return Reply::Data(self.firmware.answer());
        }
        if let Heard::Restart = self.firmware.take(sent) {
            let deaf = self.life == Life::Struck && self.cure_of().is_some_and(|cure| cure > Cure::Restart);
            if !deaf {
                self.cure(Cure::Restart);
                self.leave(now_us + 100_000, now_us + 6_000_000);
            }
        }
        Reply::Done
    }

    fn probe(&mut self, interface: u8, sent: &[u8]) -> Reply {
        let trouble = self.trouble;
        match trouble {
            Some(Trouble::ProbeSilent) => return Reply::Silence,
            Some(Trouble::ProbeStalls(_)) if self.strike() => return Reply::Stall,
            _ => {}
        }
        self.probes.insert(interface, sent.to_vec());
        Reply::Done
    }

    /// The record of the last probe with the sizes filled in.
    fn probe_answer(&mut self, interface: u8, most: bool) -> Reply {
        let mut record = self.probes.get(&interface).cloned().unwrap_or_else(|| vec![0; 48]);
        record.resize(48, 0);
        let modes = descriptors::modes(self.trouble == Some(Trouble::Usb2), self.trouble);
        let mode = modes.get(usize::from(record[3]).wrapping_sub(1));
        let (width, height) = match mode {
            _ if interface == COLOUR_STREAMING => (640, 480),
            Some((width, height, _)) => (*width, *height),
            None => (1280, 720),
        };
        let frame = u32::from(width) * u32::from(height) * if interface == 2 { 1 } else { 2 };
        record[18..22].copy_from_slice(&frame.to_le_bytes());
        record[22..26].copy_from_slice(&(frame + 1024).to_le_bytes());
        record[26..30].copy_from_slice(&1_000_000_u32.to_le_bytes());
        let trouble = self.trouble;
        match trouble {
            Some(Trouble::ProbeCut) => record.truncate(26),
            Some(Trouble::ProbeFormat) => record[2] = 7,
            Some(Trouble::ProbeInterval(_)) if !most && self.strike() => {
                record[4..8].copy_from_slice(&333_333_u32.to_le_bytes());
            }
            Some(Trouble::ProbeSize) => record[18..22].copy_from_slice(&460_800_u32.to_le_bytes()),
            _ => {}
        }
        Reply::Data(record)
    }

    fn commit(&mut self, now_us: u64, interface: u8, setup: [u8; 6]) -> Reply {
        if matches!(self.trouble, Some(Trouble::CommitStalls(_))) && self.strike() {
            return Reply::Stall;
        }
        // The second stream's commit cures: a new agreement is one on both.
        if interface != 1 {
            self.cure(Cure::Commit);
        }
        self.note_commit(now_us, setup);
        Reply::Done
    }

    fn note_commit(&mut self, now_us: u64, setup: [u8; 6]) {
        if let [0x21, 1, 0, 2, interface, 0] = setup {
            self.committed.insert(interface);
            if interface == COLOUR_STREAMING {
                self.even.resize(640 * 480 * 2, 128);
            }
            // A program for depth commits that first; a webcam's driver commits colour alone.
            let all = self.committed.len() == 2 || interface == COLOUR_STREAMING;
            if all && self.started_us.is_none() {
                self.started_us = Some(now_us + 30_000);
                self.shots_of_start = 0;
            }
        }
    }
}
