//! The paper's experiments beside the paper's own algorithm, recordings replayed, figures.

pub mod experiments;
pub mod figures;
pub mod paper;
pub mod recordings;
pub mod reference;
pub mod replay;
pub mod score;
pub mod trace;
