//! The turns of a run as a table.

use crate::timed_turn::TimedTurn;
use meniscus::runtime::{Mode, Stages};
use std::fmt::Write;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Returns one row a turn, oldest first. `wall_us` is the end of the turn by the machine's clock, microseconds since
/// 1970; `camera_us` the middle of its exposure by the camera's; `sequence` its frame's number, empty where no
/// frame came; `seen` whether the liquid was seen in it. Then come the stages of the turn, and `camera_us` on the machine's clock
/// with its standard deviation.
#[must_use]
pub fn csv(all: &[TimedTurn]) -> String {
    let (now, wall) = (Instant::now(), SystemTime::now());
    let mut text = String::from(
        "wall_us,camera_us,sequence,mode,seen,latency_us,turn_us,surface_us,predict_us,encode_us,correct_us,field_us,host_us,host_std_us\n",
    );
    for logged in all {
        let turn = &logged.turn;
        let ended = wall - now.saturating_duration_since(logged.ended);
        let wall_us = ended.duration_since(UNIX_EPOCH).unwrap_or_default().as_micros();
        let sequence = turn.stamp.map_or(String::new(), |stamp| stamp.sequence.to_string());
        let seen = u8::from(matches!(turn.profile, Some(Ok(_))));
        let mode = match turn.estimate.mode {
            Mode::Filling => "filling",
            Mode::Tracking => "tracking",
            Mode::Coasting => "coasting",
            Mode::Halted => "halted",
        };
        let (latency_us, turn_us, stages) = (logged.latency_us, logged.turn_us, &turn.estimate.stages);
        let host =
            logged.host.map_or(",".into(), |host| format!("{},{}", host.unix_ns / 1000, host.std_ns / 1000));
        let Stages { surface_us, predict_us, encode_us, correct_us, field_us } = stages;
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "{wall_us},{},{sequence},{mode},{seen},{latency_us},{turn_us},{surface_us},{predict_us},{encode_us},{correct_us},{field_us},{host}",
            turn.time.0
        );
    }
    text
}
