//! Results of a discovery as JSON, scene file and page.

mod drawings;
pub mod html;
pub mod scene;
pub mod verdict_json;
