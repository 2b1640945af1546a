//! Reports of a study: checks against targets, tables, charts, HTML pages and plots.

pub mod checks;
pub mod html;
pub mod plot;
