//! Statistics of a run that need no truth, over all of its turns: times, stages, losses, modes.

use crate::commanded_motion::TagCounts;
use crate::live::{Log, STAGES};
use serde_json::{Value, json};

/// Quantiles of the times of all turns, microseconds, to a thousandth; zero for a run without turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TurnTimes {
    /// Median.
    pub median: u64,
    /// 99th percentile.
    pub p99: u64,
    /// Longest.
    pub max: u64,
}

impl TurnTimes {
    /// Returns the quantiles of a log.
    #[must_use]
    pub fn of(log: &Log) -> Self {
        let within = |share| log.totals.turn_within_us(share);
        Self { median: within(0.5), p99: within(0.99), max: within(1.0) }
    }
}

/// Returns the median time of each stage over the turns that tracked, microseconds, as a JSON object.
#[must_use]
pub fn stages_json(log: &Log) -> Value {
    let medians = STAGES.iter().zip(log.totals.stage_medians_us());
    medians.map(|(stage, us)| (stage.name.to_owned(), json!(us))).collect()
}

/// Returns the same as a line for a person.
#[must_use]
pub fn stages_line(log: &Log) -> String {
    let medians = STAGES.iter().zip(log.totals.stage_medians_us());
    let stages: Vec<String> = medians.map(|(stage, us)| format!("{} {us}", stage.name)).collect();
    format!("stages, median us: {}\n", stages.join(", "))
}

/// Returns the turns by the origin of their motion as JSON, `null` without a commanded motion. Scripts read the names
/// `commanded` and `tracked`.
#[must_use]
pub fn motion_json(log: &Log) -> Value {
    log.motion.map_or(Value::Null, |turns| {
        json!({ "commanded": turns.commanded, "tracked": turns.tracked, "contradicted": turns.contradicted,
                "contradictions": turns.contradictions, "refused": turns.refused, "stamped": turns.stamped,
                "tag": turns.tag })
    })
}

/// Returns what is known of the camera's clock as JSON.
#[must_use]
pub fn clock_json(log: &Log) -> Value {
    let clock = &log.clock;
    json!({ "drift_ppm": clock.drift_ppm, "steps": clock.steps, "restarts": clock.restarts })
}

/// Returns the same as a line for a person; empty without a commanded motion.
#[must_use]
pub fn motion_line(log: &Log) -> String {
    log.motion.map_or(String::new(), |turns| {
        let (commanded, tracked) = (turns.commanded, turns.tracked);
        let denied = match turns.contradictions {
            0 => String::new(),
            _ => format!("; the image contradicted the commanded motion in {} turns", turns.contradicted),
        };
        let refused = match turns.refused {
            0 => String::new(),
            refused => format!("; {refused} datagrams refused"),
        };
        let tag = turns.tag.map_or(String::new(), |tag| tag_line(&tag));
        format!("motion: commanded in {commanded} turns, tracked in {tracked}{denied}{refused}\n{tag}")
    })
}

/// Returns the images of a tag as a line for a person.
fn tag_line(tag: &TagCounts) -> String {
    let TagCounts { images, seen, image_us_mean, image_us_max, .. } = *tag;
    let course = tag.travel.map_or_else(
        || "; never at rest, so that no lift or inclination is known".into(),
        |travel| {
            format!(
                "; farthest from the rest: along {:.1} mm, away {:.1} mm, lift {:.1} mm (std {:.2} mm), inclination {:.1} degrees \
                 (std {:.1})",
                travel.along_mm,
                travel.away_mm,
                travel.lift_mm,
                travel.position_std_mm,
                travel.inclination_deg,
                travel.attitude_std_deg
            )
        },
    );
    format!(
        "tag: seen in {seen} of {images} images, {image_us_mean} us each, {image_us_max} us at the most{course}\n"
    )
}

/// Returns the losses of the camera's streams as JSON.
#[must_use]
pub fn losses_json(log: &Log) -> Value {
    json!({ "depth": log.losses.0, "infrared": log.losses.1, "solitary": log.solitary,
            "payloads_dropped": log.payloads_dropped })
}

/// Returns the number of turns in each mode as JSON.
#[must_use]
pub fn modes_json(log: &Log) -> Value {
    let health = &log.health;
    json!({ "filling": health.filling, "tracking": health.tracking, "coasting": health.coasting,
            "halted": health.halted })
}
