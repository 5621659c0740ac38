//! State that several tasks share.

use core::cell::RefCell;

/// State that several tasks share, for the length of a call, never across an await. A cell is enough, and the compiler sees to
/// it that no interrupt has one: all tasks are the one executor's, in thread mode, one at a time.
pub struct Shared<T>(RefCell<T>);

impl<T> Shared<T> {
    pub const fn new(state: T) -> Self {
        Self(RefCell::new(state))
    }

    /// Works on the state.
    pub fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        match self.0.try_borrow_mut() {
            Ok(mut state) => work(&mut state),
            Err(_) => nested(),
        }
    }
}

/// The one place for all: a panic in each costs 40 bytes of flash.
#[cold]
#[inline(never)]
fn nested() -> ! {
    panic!("shared state is used within its own use")
}
