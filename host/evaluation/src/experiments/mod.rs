//! The paper's experiments in the simulation, ours next to the paper's algorithm on the same samples.

pub mod ablation;
pub mod calibration;
pub mod catalogue;
pub mod document;
pub mod effects;
pub mod fingerprint;
pub mod fingers;
pub mod following;
pub mod job;
pub mod joint_sensor;
pub mod judge;
pub mod live;
pub mod objects;
pub mod result;
pub mod run;
pub mod sensitivity;
pub mod session;
pub mod soft_objects;
