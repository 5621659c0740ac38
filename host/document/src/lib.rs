//! What programs write into documents: charts as SVG, Markdown tables, and sections between markers.

pub mod chart;
mod look;
pub mod scatter;
pub mod section;
pub mod table;

pub use look::DrawError;
