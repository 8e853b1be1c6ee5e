//! Columns that several threads change concurrently.

use std::cell::UnsafeCell;
use std::ops::Range;

/// A column that several threads change concurrently, no two of them the same entry.
pub struct Cells<'a, T> {
    entry: &'a [UnsafeCell<T>],
}

impl<T> Clone for Cells<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Cells<'_, T> {}

// SAFETY: entries are reached through `get`, `set` and `range` alone, whose callers promise that no other thread touches the entry.
unsafe impl<T: Send> Sync for Cells<'_, T> {}

impl<'a, T: Copy> Cells<'a, T> {
    /// Cells of a column.
    pub fn new(column: &'a mut [T]) -> Cells<'a, T> {
        let entry: *const [T] = column;
        // SAFETY: UnsafeCell<T> has the layout of T, and the column is borrowed for as long as the cells live.
        Cells { entry: unsafe { &*(entry as *const [UnsafeCell<T>]) } }
    }

    /// Read an entry.
    ///
    /// # Safety
    /// No other thread writes the entry meanwhile.
    #[inline(always)]
    pub unsafe fn get(&self, i: usize) -> T {
        // SAFETY: the caller's promise.
        unsafe { *self.entry[i].get() }
    }

    /// Write an entry.
    ///
    /// # Safety
    /// No other thread reads or writes the entry meanwhile.
    #[inline(always)]
    pub unsafe fn set(&self, i: usize, value: T) {
        // SAFETY: the caller's promise.
        unsafe { *self.entry[i].get() = value }
    }

    /// Entries to change.
    ///
    /// # Safety
    /// No other reference to these entries is used meanwhile, by this thread or another.
    #[expect(clippy::mut_from_ref, reason = "the caller's promise")]
    pub unsafe fn range(&self, range: Range<usize>) -> &mut [T] {
        let entry = &self.entry[range];
        // SAFETY: UnsafeCell<T> has the layout of T; the caller's promise.
        unsafe { std::slice::from_raw_parts_mut(entry.as_ptr() as *mut T, entry.len()) }
    }
}
