//! The scenes of `scenes/*.toml` as types, for programs that handle more than one: a firmware has its own alone.
//!
//! ```
//! use palpate::scene::Scene;
//!
//! fn travel_rad<S: Scene>() -> f32 {
//!     S::TRAVEL_RAD
//! }
//!
//! let name = palpate_scenes::NAMES[0];
//! assert!(palpate_scenes::for_scene!(name, |S| travel_rad::<S>()).is_some());
//! assert!(palpate_scenes::for_scene!("no-such-finger", |S| travel_rad::<S>()).is_none());
//! ```

mod kept;

pub use kept::kept;

include!(concat!(env!("OUT_DIR"), "/scenes.rs"));
