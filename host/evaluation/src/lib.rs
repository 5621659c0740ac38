//! The paper's experiments next to the paper's own algorithm, recordings replayed, figures.

pub mod bound;
pub mod experiments;
pub mod false_contacts;
pub mod figures;
pub mod paper;
pub mod recordings;
pub mod reference;
pub mod replay;
pub mod score;
pub mod trace;
