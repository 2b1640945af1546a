//! The program's table of turns, held against what the camera's side has seen.

use meniscus_hil::device::DEPTH;
use meniscus_hil::vhci::Witness;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::time::{SystemTime, UNIX_EPOCH};

/// Age of a frame at the end of its turn above which it is stale, microseconds: three intervals.
const STALE_US: u64 = 50_000;

/// One row.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Row {
    wall_us: u64,
    sequence: Option<u32>,
    mode: String,
}

fn rows(table: &str) -> Vec<Row> {
    let row = |line: &str| {
        let mut cells = line.split(',');
        let (wall, _camera, sequence, mode) = (cells.next()?, cells.next()?, cells.next()?, cells.next()?);
        Some(Row { wall_us: wall.parse().ok()?, sequence: sequence.parse().ok(), mode: mode.into() })
    };
    table.lines().skip(1).filter_map(row).collect()
}

fn us(time: SystemTime) -> u64 {
    time.duration_since(UNIX_EPOCH).map_or(0, |time| u64::try_from(time.as_micros()).unwrap_or(u64::MAX))
}

/// Figures of the table.
///
/// | key | meaning |
/// |---|---|
/// | `turns` | rows |
/// | `fps` | frames a second between the first and the last frame, by the guest's clock |
/// | `gaps` | frame numbers that are missing between the first and the last frame |
/// | `interval_p99_us` | 99th percentile of the time between two turns with a frame |
/// | `stale_as_fresh` | turns called tracking whose frame is not newer than every one before, was sent more than 50 ms ago for the first time, or was never sent |
/// | `unread` | depth payloads that found no read waiting, up to the last frame |
/// | `reattach_to_track_s` | from each attachment but the first to the first tracking turn behind it |
pub(crate) fn judge(table: &str, witness: &Witness) -> Value {
    let rows = rows(table);
    let frames: Vec<&Row> = rows.iter().filter(|row| row.sequence.is_some()).collect();
    let mut sent: HashMap<u32, u64> = HashMap::new();
    for payload in witness.sent.iter().filter(|payload| payload.endpoint == DEPTH) {
        sent.entry(payload.counter).or_insert(us(payload.at));
    }
    let (mut newest, mut stale, mut oldest_us) = (None, 0_u32, 0);
    for row in rows.iter().filter(|row| row.mode == "tracking") {
        let age_us =
            row.sequence.and_then(|sequence| Some(row.wall_us.saturating_sub(*sent.get(&sequence)?)));
        let fresh =
            row.sequence.is_some() && row.sequence > newest && age_us.is_some_and(|age| age <= STALE_US);
        stale += u32::from(!fresh);
        oldest_us = oldest_us.max(age_us.unwrap_or(0));
        newest = row.sequence.max(newest);
    }
    let mut intervals: Vec<u64> =
        frames.windows(2).map(|pair| pair[1].wall_us.saturating_sub(pair[0].wall_us)).collect();
    intervals.sort_unstable();
    let p99 = intervals.get(intervals.len() * 99 / 100).copied();
    let time_us: u64 = intervals.iter().sum();
    let fps = if time_us > 0 { intervals.len() as f64 * 1e6 / time_us as f64 } else { 0.0 };
    let gaps: i64 = frames
        .windows(2)
        .map(|pair| i64::from(pair[1].sequence.unwrap_or(0)) - i64::from(pair[0].sequence.unwrap_or(0)) - 1)
        .map(|gap| gap.max(0))
        .sum();
    let back = witness.attached.iter().skip(1).map(|at| {
        let at_us = us(*at);
        let tracking = rows.iter().find(|row| row.mode == "tracking" && row.wall_us > at_us);
        tracking.map(|row| (row.wall_us - at_us) as f64 * 1e-6)
    });
    // Behind the last frame the program reads no more; it has stopped, which the camera cannot know.
    let until_us = frames.last().map_or(0, |row| row.wall_us);
    let depth = witness.sent.iter().filter(|payload| payload.endpoint == DEPTH && us(payload.at) <= until_us);
    let unread = depth.filter(|payload| !payload.read).count();
    json!({
        "turns": rows.len(),
        "frames": frames.len(),
        "fps": fps,
        "gaps": gaps,
        "interval_p99_us": p99,
        "oldest_tracked_us": oldest_us,
        "stale_as_fresh": stale,
        "reattach_to_track_s": back.collect::<Vec<_>>(),
        "unread": unread,
        "last_mode": rows.last().map(|row| row.mode.as_str()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_hil::vhci::Sent;
    use std::time::Duration;

    fn at(us: u64) -> SystemTime {
        UNIX_EPOCH + Duration::from_micros(us)
    }

    fn judged(table: &[(u64, &str, &str)]) -> Value {
        let sent =
            |counter: u32| Sent { at: at(u64::from(counter) * 10_000), endpoint: DEPTH, counter, read: true };
        let witness = Witness {
            sent: (1..10).map(sent).collect(),
            attached: vec![at(0), at(25_000)],
            ..Witness::default()
        };
        let rows: Vec<String> =
            table.iter().map(|(wall, sequence, mode)| format!("{wall},0,{sequence},{mode},1,0,0")).collect();
        judge(&format!("head\n{}", rows.join("\n")), &witness)
    }

    #[test]
    fn a_fresh_stream_has_nothing_stale() {
        let facts =
            judged(&[(11_000, "1", "tracking"), (21_000, "2", "tracking"), (31_000, "3", "tracking")]);
        assert_eq!(
            (&facts["stale_as_fresh"], &facts["gaps"], &facts["fps"]),
            (&json!(0), &json!(0), &json!(100.0))
        );
        assert_eq!(facts["reattach_to_track_s"], json!([0.006]));
    }

    #[test]
    fn a_repeated_an_old_and_an_invented_frame_are_stale_and_a_skipped_one_is_a_gap() {
        assert_eq!(judged(&[(11_000, "1", "tracking"), (12_000, "1", "tracking")])["stale_as_fresh"], 1);
        assert_eq!(judged(&[(61_001, "1", "tracking")])["stale_as_fresh"], 1, "sent 51 ms ago");
        assert_eq!(judged(&[(61_001, "1", "coasting")])["stale_as_fresh"], 0, "nobody calls it fresh");
        assert_eq!(judged(&[(11_000, "77", "tracking"), (12_000, "", "tracking")])["stale_as_fresh"], 2);
        assert_eq!(judged(&[(11_000, "1", "tracking"), (31_000, "3", "tracking")])["gaps"], 1);
    }
}
