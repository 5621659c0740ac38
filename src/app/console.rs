//! The command line: what a user may type and set, and the text of the answers.

pub mod command;
pub mod lines;
pub mod settings;
pub mod text;
