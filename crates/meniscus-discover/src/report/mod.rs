//! Results of a discovery as JSON, scene file and page.

mod drawings;
pub mod html;
mod intervals;
mod law_json;
mod law_page;
pub mod scene;
mod sizing_json;
mod sizing_page;
pub mod verdict_json;
mod words;
