//! Split of the recordings of one glass into those that are fitted and the one that is held out.

use super::record::Record;

/// Fewest recordings of which one is held out: three are needed to distinguish kinds of damping by their amplitude.
const FEWEST_TO_HOLD_OUT: usize = 4;

/// Recordings of one glass, split once and handed to every stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// Recordings that are fitted, in their order.
    pub fitted: Vec<Record>,
    /// The recording on which only the gap is measured; none of fewer than four.
    pub held_out: Option<Record>,
}

impl Split {
    /// Holds out the second strongest of four or more `records`, so that it lies inside the range that is fitted.
    #[must_use]
    pub fn of(records: &[Record]) -> Self {
        if records.len() < FEWEST_TO_HOLD_OUT {
            return Self { fitted: records.to_vec(), held_out: None };
        }
        let mut order: Vec<usize> = (0..records.len()).collect();
        order.sort_by(|a, b| strength(&records[*b]).total_cmp(&strength(&records[*a])));
        let held_out = order[1];
        let others = records.iter().enumerate().filter(|(i, _)| *i != held_out);
        Self {
            fitted: others.map(|(_, record)| record.clone()).collect(),
            held_out: Some(records[held_out].clone()),
        }
    }
}

/// Returns the mean square of the horizontal specific force of a recording, m2/s4.
fn strength(record: &Record) -> f64 {
    let drive = &record.drive.along_m_s2;
    drive.iter().flatten().map(|a| a * a).sum::<f64>() / drive.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recordings::record::{Channel, Drive, Quantity};

    fn record(name: &str, force_m_s2: f64) -> Record {
        Record {
            name: name.into(),
            interval_s: 1.0 / 60.0,
            channels: vec![Channel { quantity: Quantity::Peak, value: vec![Some(0.0); 4] }],
            drive: Drive {
                rate_hz: 240.0,
                along_m_s2: vec![[force_m_s2, 0.0]; 8],
                tilted_m_s2: vec![[0.0; 2]; 8],
                lift_m_s2: vec![0.0; 8],
                place_m: vec![0.0; 8],
            },
            rest_frames: 1,
        }
    }

    #[test]
    fn the_second_strongest_of_four_is_held_out_and_the_others_keep_their_order() {
        let records =
            [("a", 0.6), ("b", -1.25), ("c", 2.2), ("d", 1.7)].map(|(name, force)| record(name, force));
        let split = Split::of(&records);
        assert_eq!(split.held_out.map(|record| record.name).as_deref(), Some("d"));
        let names: Vec<&str> = split.fitted.iter().map(|record| record.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "c"]);
    }

    #[test]
    fn of_three_recordings_all_are_fitted() {
        let records = [record("a", 0.6), record("b", 1.0), record("c", 2.0)];
        let split = Split::of(&records);
        assert_eq!((split.fitted.len(), split.held_out), (3, None));
    }
}
