//! State that several tasks share, at no cost: a task reaches it with its [`Turn`], for the length of a call.
//!
//! Tasks run one at a time, in thread mode, and change over at an await alone. A lock would have nothing to do there but
//! find that it is nested; here the compiler does: [`Shared::lock`] borrows the turn, of which each task has one.

use core::cell::UnsafeCell;
use core::marker::PhantomData;

/// A task's leave to reach what is shared, while it is the one that runs.
///
/// Neither `Send` nor `Sync`: it stays in thread mode.
pub struct Turn(PhantomData<*mut ()>);

impl Turn {
    /// A turn for a task.
    ///
    /// # Safety
    /// Each task of the one executor in thread mode gets one at most, and no one else any.
    pub unsafe fn new() -> Self {
        Self(PhantomData)
    }
}

/// State that several tasks share.
pub struct Shared<T>(UnsafeCell<T>);

// SAFETY: only `lock` reaches the value, and it takes a turn. Turns stay in thread mode, and thread mode runs one task at a
// time; whichever that is has one turn, which `lock` borrows until the reference is gone again.
unsafe impl<T: Send> Sync for Shared<T> {}

impl<T> Shared<T> {
    /// Ready to be shared.
    pub const fn new(value: T) -> Self {
        Self(UnsafeCell::new(value))
    }

    /// Calls with the value, which no one else has meanwhile. Shared states do not nest: one at a time.
    pub fn lock<R>(&self, _turn: &mut Turn, call: impl FnOnce(&mut T) -> R) -> R {
        // SAFETY: see `Sync`: this task runs and has lent its only turn, so that there is no other reference.
        call(unsafe { &mut *self.0.get() })
    }
}
