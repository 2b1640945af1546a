//! A list of lists in two arrays, and the pieces in which a long one is worked on.

use rayon::prelude::*;
use std::ops::Range;

/// Chunks of the pair list; a constant, so that sums do not depend on the number of threads.
pub(crate) const CHUNKS: usize = 8;

/// Particles that one thread takes at once: a constant, so that sums do not depend on the number of threads.
pub(crate) const PIECE: usize = 256;

/// Particles of each thread in a pass of few operations. A second thread made such passes over 2155 particles no faster.
pub(crate) const LIGHT: usize = 2048;

/// A list of lists: the entries of row `i` are `entry[start[i]..start[i + 1]]`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    pub(super) start: Vec<u32>,
    pub(super) entry: Vec<u32>,
}

impl Rows {
    /// Entries of row `i`.
    pub(crate) fn row(&self, i: usize) -> &[u32] {
        &self.entry[self.range(i)]
    }

    /// Where the entries of row `i` are among all.
    pub(crate) fn range(&self, i: usize) -> Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }

    /// Removes all rows.
    pub(super) fn clear(&mut self) {
        self.start.clear();
        self.entry.clear();
        self.start.push(0);
    }

    /// Adds a row of the entries that were added since the last one.
    pub(super) fn end_row(&mut self) {
        self.start.push(self.entry.len() as u32);
    }

    /// Adds entries to the row that is not yet ended.
    pub(super) fn extend(&mut self, entries: &[u32]) {
        self.entry.extend_from_slice(entries);
    }

    /// Adds the first `count` of `entries` to the row that is not yet ended.
    pub(super) fn extend_some(&mut self, entries: &[u32; 8], count: usize) {
        let all = self.entry.len() + count;
        self.entry.extend_from_slice(entries);
        self.entry.truncate(all);
    }

    /// Takes the rows of `parts`, one part behind the other, in place of its own.
    pub(super) fn join(&mut self, parts: &[Self]) {
        self.start.resize(1 + parts.iter().map(Self::len).sum::<usize>(), 0);
        self.entry.resize(parts.iter().map(|part| part.entry.len()).sum(), 0);
        let (mut starts, mut entries, mut before) = (&mut self.start[1..], &mut self.entry[..], 0);
        let places: Vec<_> = parts
            .iter()
            .map(|part| {
                let start = starts.split_off_mut(..part.len()).unwrap_or_default();
                let entry = entries.split_off_mut(..part.entry.len()).unwrap_or_default();
                let place = (start, entry, before);
                before += part.entry.len() as u32;
                place
            })
            .collect();
        parts.par_iter().zip(places).for_each(|(part, (start, entry, before))| {
            for (to, own) in start.iter_mut().zip(&part.start[1..]) {
                *to = before + own;
            }
            entry.copy_from_slice(&part.entry);
        });
    }

    /// Number of rows that are ended.
    fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Entries of the rows from `first` to `last`.
    pub(super) fn rows(&self, first: usize, last: usize) -> Range<usize> {
        self.start[first] as usize..self.start[last + 1] as usize
    }

    /// The entries of all rows.
    pub(super) fn entries(&self) -> &[u32] {
        &self.entry
    }

    /// Which rows name each of `columns` entries.
    pub(crate) fn transposed(&self, columns: usize) -> Self {
        let mut start = vec![0_u32; columns + 1];
        for &e in &self.entry {
            start[e as usize + 1] += 1;
        }
        for c in 0..columns {
            start[c + 1] += start[c];
        }
        let mut next = start.clone();
        let mut entry = vec![0; self.entry.len()];
        for i in 0..self.len() {
            for &e in self.row(i) {
                entry[next[e as usize] as usize] = i as u32;
                next[e as usize] += 1;
            }
        }
        Self { start, entry }
    }
}
