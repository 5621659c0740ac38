//! Tests of the simulated firmware in one program: what is generic is compiled once for all of them.

mod changes;
mod current;
mod direct;
mod endurance;
mod engines;
mod grasps;
mod guided;
mod healthy;
mod hidden;
mod identify;
mod joint;
mod preparation;
mod restart;
mod returned;
mod rigid;
mod scenes;
mod second;
mod settings;
mod skin;
mod soft;
mod softer;
mod speed;
mod support;
mod travel;
mod weight;
mod wrapped;
