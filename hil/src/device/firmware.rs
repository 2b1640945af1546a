//! The hardware monitor from the camera's side: 1024 bytes in, 1024 bytes out, and the tables behind.

use super::trouble::Trouble;

/// Intrinsics of 640x480, as in public logs of a D435.
pub const INTRINSICS: [f32; 4] = [384.21, 384.21, 319.48, 236.35];
/// Intrinsics of 480x270 that belong to them: the same optics, cropped and binned (848x480 scaled).
pub const INTRINSICS_SMALL: [f32; 4] = [240.13, 240.13, 239.6, 132.9];

/// Intrinsics of 640x480 in colour, as in public logs of a D435.
pub const COLOUR_INTRINSICS: [f32; 4] = [612.4, 610.6, 322.1, 244.7];
/// Where the colour lens stands as seen from the depth lens: right, down, forward, metres.
pub const COLOUR_LENS_M: [f32; 3] = [-0.0148, 0.0002, 0.0003];
/// Pitch of the colour lens against the depth lens, upwards, radians.
pub const COLOUR_PITCH_RAD: f32 = 0.004;

/// State of the hardware monitor.
#[derive(Clone, Debug)]
pub(super) struct Firmware {
    trouble: Option<Trouble>,
    depth_unit_um: u32,
    command: Vec<u8>,
    refusals: u32,
}

/// Result of a command.
pub(super) enum Heard {
    Command,
    Restart,
}

impl Firmware {
    pub(super) fn new(trouble: Option<Trouble>) -> Self {
        let refusals = match trouble {
            Some(Trouble::MonitorRefuses(_, times)) => times,
            _ => 0,
        };
        Self { trouble, depth_unit_um: 1000, command: Vec::new(), refusals }
    }

    /// A command message.
    pub(super) fn take(&mut self, message: &[u8]) -> Heard {
        self.command = message.to_vec();
        if self.word(4) == 0x20 { Heard::Restart } else { Heard::Command }
    }

    fn word(&self, at: usize) -> u32 {
        self.command.get(at..at + 4).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    }

    /// The message that answers the last command.
    pub(super) fn answer(&mut self) -> Vec<u8> {
        let opcode = self.word(4);
        let sound = self.word(0) & 0xffff_0000 == 0xcdab_0000;
        let answered = if sound { self.payload(opcode) } else { Err(-1) };
        let mut message = vec![0; 1024];
        let (head, length) = match &answered {
            Ok(payload) => {
                message[4..4 + payload.len()].copy_from_slice(payload);
                (opcode, payload.len() as u32)
            }
            Err(number) => (number.cast_unsigned(), 0),
        };
        message[..4].copy_from_slice(&head.to_le_bytes());
        message[1020..].copy_from_slice(&length.to_le_bytes());
        match self.trouble {
            Some(Trouble::MonitorCut) => message.truncate(1000),
            Some(Trouble::MonitorLength) => message[1020..].copy_from_slice(&2000_u32.to_le_bytes()),
            Some(Trouble::MonitorEcho) => message[0] ^= 0x41,
            Some(Trouble::MonitorRefuses(number, _)) if self.refusals > 0 => {
                self.refusals -= 1;
                message[..4].copy_from_slice(&number.to_le_bytes());
            }
            _ => {}
        }
        message
    }

    fn payload(&mut self, opcode: u32) -> Result<Vec<u8>, i32> {
        match opcode {
            0x10 => Ok(self.information()),
            0x15 if self.word(8) == 25 => Ok(self.coefficients()),
            0x15 if self.word(8) == 32 => Ok(self.colour()),
            0x7e if self.trouble == Some(Trouble::NoList) => Err(-1),
            0x7e => Ok(self.list()),
            0x30 => Ok(vec![u8::from(self.trouble != Some(Trouble::AdvancedOff))]),
            0x2c if self.word(8) == 9 => Ok(self.depth_table()),
            0x2b if self.word(8) == 9 => {
                if self.trouble != Some(Trouble::UnitStuck) {
                    self.depth_unit_um = self.word(24);
                }
                Ok(vec![])
            }
            0x15 => Err(-21),
            0x2b | 0x2c => Err(-6),
            _ => Err(-1),
        }
    }

    fn information(&self) -> Vec<u8> {
        let mut payload = vec![0; 240];
        let firmware =
            if self.trouble == Some(Trouble::OldFirmware) { [0, 8, 5, 5] } else { [100, 0, 16, 5] };
        payload[12..16].copy_from_slice(&firmware);
        payload[48..54].copy_from_slice(&[0x84, 0x31, 0x12, 0x07, 0x10, 0x99]);
        payload[64..70].copy_from_slice(&[0x83, 0x92, 0x13, 0x06, 0x12, 0x34]);
        payload[166] = 2;
        payload
    }

    fn depth_table(&self) -> Vec<u8> {
        [self.depth_unit_um, 0, 65_536, 0, 0].iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    fn intrinsics(&self, values: [f32; 4]) -> [f32; 4] {
        if self.trouble == Some(Trouble::TableWild) { [f32::NAN, -1.0, 1e30, 0.0] } else { values }
    }

    fn list(&self) -> Vec<u8> {
        let mut payload = Vec::new();
        for (width, height, values) in [
            (848_u16, 480_u16, [424.2, 424.2, 423.4, 236.3]),
            (640, 480, INTRINSICS),
            (480, 270, INTRINSICS_SMALL),
        ] {
            payload.extend(width.to_le_bytes());
            payload.extend(height.to_le_bytes());
            self.intrinsics(values).iter().for_each(|value| payload.extend(value.to_le_bytes()));
        }
        payload
    }

    /// Table 25: header, baseline at 160, slots from 256, 512 bytes in all.
    fn coefficients(&self) -> Vec<u8> {
        let mut table = vec![0_u8; 512];
        table[160..164].copy_from_slice(&(-50.06_f32).to_le_bytes());
        for (slot, values) in [(2, INTRINSICS), (7, INTRINSICS_SMALL)] {
            for (k, value) in self.intrinsics(values).iter().enumerate() {
                let at = 256 + 16 * slot + 4 * k;
                table[at..at + 4].copy_from_slice(&value.to_le_bytes());
            }
        }
        seal(&mut table, if self.trouble == Some(Trouble::TableOther) { 32 } else { 25 });
        match self.trouble {
            Some(Trouble::TableCrc) => table[300] ^= 1,
            Some(Trouble::TableCut) => table.truncate(200),
            _ => {}
        }
        table
    }

    /// Table 32: normalised camera matrix, no distortion, calibrated at 1920x1080, rotation and translation from
    /// colour to depth.
    fn colour(&self) -> Vec<u8> {
        let mut table = vec![0_u8; 256];
        let [fx, fy, ppx, ppy] = self.intrinsics(COLOUR_INTRINSICS);
        // 4:3 is cut out of 16:9: the width that is normalised by is 4/3 of the image's.
        let matrix = [fx / 320.0 * 0.75, 0.0, (ppx / 320.0 - 1.0) * 0.75, 0.0, fy / 240.0, ppy / 240.0 - 1.0];
        let (sin, cos) = COLOUR_PITCH_RAD.sin_cos();
        // Looking up, the colour lens' down and forward are (cos, sin) and (-sin, cos) of the depth lens'.
        let rotation = [1.0, 0.0, 0.0, 0.0, cos, sin, 0.0, -sin, cos];
        let place = COLOUR_LENS_M.map(|metres| -1e3 * metres);
        for (at, values) in [(16, &matrix[..]), (184, &rotation), (220, &place)] {
            for (k, value) in values.iter().enumerate() {
                table[at + 4 * k..at + 4 * k + 4].copy_from_slice(&value.to_le_bytes());
            }
        }
        table[144..146].copy_from_slice(&1920_u16.to_le_bytes());
        table[146..148].copy_from_slice(&1080_u16.to_le_bytes());
        seal(&mut table, 32);
        if self.trouble == Some(Trouble::TableCrc) {
            table[200] ^= 1;
        }
        table
    }
}

/// Writes a table's header.
fn seal(table: &mut [u8], id: u16) {
    table[..2].copy_from_slice(&[4, 0]);
    table[2..4].copy_from_slice(&id.to_le_bytes());
    let length = (table.len() - 16) as u32;
    table[4..8].copy_from_slice(&length.to_le_bytes());
    let crc = crc32(&table[16..]);
    table[12..16].copy_from_slice(&crc.to_le_bytes());
}

/// CRC-32 of IEEE 802.3, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_has_the_check_value() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }
}
