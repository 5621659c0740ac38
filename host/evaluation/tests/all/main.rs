//! Tests of experiments, recordings and replay in one program: what is generic is compiled once for all of them.

mod bound;
mod documents;
mod held_twice;
mod oracle;
mod recordings;
mod replay;
mod replay_page;
mod second_bound;
