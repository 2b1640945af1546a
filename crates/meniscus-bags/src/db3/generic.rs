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
    let connection = &rows.database.connection;
    let is_there = "SELECT count(*) FROM pragma_table_info('topics') WHERE name = ?1";
    // Bags of librealsense have no type. No column is read but those named here: rusqlite panics at a name that is no UTF-8.
    let column = |name: &'static str| -> rusqlite::Result<&str> {
        let there = connection.query_row(is_there, [name], |row| row.get::<_, i64>(0))? > 0;
        Ok(if there { name } else { "NULL" })
    };
    let columns =
        [column("id")?, column("name")?, column("type")?, column("serialization_format")?].join(", ");
    let sql = format!("SELECT {columns} FROM topics ORDER BY 1 LIMIT ?1");
    let mut statement = connection.prepare(&sql)?;
    let text = |row: &rusqlite::Row<'_>, place: usize| -> rusqlite::Result<String> {
        Ok(row.get::<_, Option<String>>(place)?.unwrap_or_default())
    };
    let topic = |row: &rusqlite::Row<'_>| {
        let number = row.get::<_, Option<i64>>(0)?.unwrap_or(-1);
        let (name, kind, aligned) = (text(row, 1)?, text(row, 2)?, text(row, 3)? != "ros1");
        Ok(u32::try_from(number).ok().map(|id| Topic { id, name, kind, aligned }))
    };
    let found = statement.query_map([MOST as i64], topic)?;
    found.filter_map(Result::transpose).collect()
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
