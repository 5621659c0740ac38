//! Data that survives a power cut: one record, and the pages of flash that it is kept in.

pub mod record;
pub mod store;
