//! rosbag2 in SQLite of any program, as topics and messages.

use super::rows::{Row, Rows, explained};
use crate::BagError;
use crate::budget::{Budget, TIME};
use crate::ros::{Event, Source, Topic};
use std::collections::VecDeque;
use std::path::Path;

/// Topics at most.
const MOST: usize = 4096;

/// rosbag2 in SQLite.
pub(crate) struct Bag {
    rows: Rows,
    topics: VecDeque<Topic>,
}

impl Bag {
    /// Opens a bag.
    pub(crate) fn open(path: &Path) -> Result<Self, BagError> {
        let rows = Rows::open(path)?;
        let topics = topics(&rows).map_err(|why| rows.damaged(explained(&why)))?;
        Ok(Self { rows, topics })
    }

    /// Returns whether librealsense recorded the bag.
    pub(crate) fn is_librealsense(&self) -> bool {
        let ours = |topic: &Topic| topic.name.contains("/Depth_0/") || topic.name.starts_with("/device_");
        self.topics.is_empty() || self.topics.iter().any(ours)
    }
}

/// Returns the topics of a bag.
fn topics(rows: &Rows) -> rusqlite::Result<VecDeque<Topic>> {
    rows.database.allow(TIME);
    // Bags of librealsense have no type.
    let mut statement = rows.database.connection.prepare("SELECT * FROM topics ORDER BY id LIMIT ?1")?;
    let columns: Vec<String> = statement.column_names().map(str::to_owned).collect();
    let place = |name: &str| columns.iter().position(|column| column == name);
    let (id, name, kind, form) = (place("id"), place("name"), place("type"), place("serialization_format"));
    let text = |row: &rusqlite::Row<'_>, place: Option<usize>| -> rusqlite::Result<String> {
        Ok(place.map(|place| row.get::<_, Option<String>>(place)).transpose()?.flatten().unwrap_or_default())
    };
    let topic = |row: &rusqlite::Row<'_>| {
        let number = id.map(|id| row.get::<_, i64>(id)).transpose()?.unwrap_or(-1);
        let aligned = text(row, form)? != "ros1";
        Ok(u32::try_from(number).ok().map(|id| (id, aligned)).zip(Some((text(row, name)?, text(row, kind)?))))
    };
    let found = statement.query_map([MOST as i64], topic)?;
    let found = found.filter_map(Result::transpose).collect::<rusqlite::Result<Vec<_>>>()?;
    let one = |((id, aligned), (name, kind))| Topic { id, name, kind, aligned };
    Ok(found.into_iter().map(one).collect())
}

impl Source for Bag {
    fn next(&mut self) -> Result<Option<Event>, BagError> {
        if let Some(topic) = self.topics.pop_front() {
            return Ok(Some(Event::Topic(topic)));
        }
        let Some(Row { id, data, .. }) = self.rows.message()? else { return Ok(None) };
        // Numbers that no topic can have are those of nobody.
        Ok(Some(Event::Message { topic: u32::try_from(id).unwrap_or(u32::MAX), data }))
    }

    fn found_image(&mut self) {
        self.rows.images += 1;
        self.rows.budget = Budget::new();
    }

    fn damaged(&self, why: &str) -> BagError {
        self.rows.damaged(why)
    }
}
