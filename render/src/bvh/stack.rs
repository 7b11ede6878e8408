//! What a ray has yet to visit.

use super::WIDTH;

/// Entries the stack holds without touching the heap; more than a node's children.
const INLINE: usize = 48;

/// Pending subtrees of a ray, reused from ray to ray: entry distance (as ordered bits) above the reference. Trees of any
/// depth fit: what comes when the inline part is full goes to the heap, and is taken from there first.
#[derive(Clone, Debug)]
pub struct Stack {
    len: usize,
    inline: [u64; INLINE],
    spill: Vec<u64>,
}

impl Default for Stack {
    #[inline(always)]
    fn default() -> Self {
        Self { len: 0, inline: [0; INLINE], spill: Vec::new() }
    }
}

impl Stack {
    /// Forgets what an earlier ray left.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.len = 0;
        self.spill.clear();
    }

    /// Pushes entries, at most as many as a node has children, so that the smallest is popped first.
    #[inline(always)]
    pub(super) fn push(&mut self, entries: impl Iterator<Item = u64>) {
        let Some(free) = self.inline.get_mut(self.len..).and_then(<[u64]>::first_chunk_mut::<WIDTH>) else {
            let start = self.spill.len();
            self.spill.extend(entries);
            self.spill[start..].sort_unstable_by(|a, b| b.cmp(a));
            return;
        };
        // Insertion without a branch on the values: processors foresee the number of steps, but no distances.
        let mut count = 0;
        for mut entry in entries {
            for i in (1..=count).rev() {
                (free[i], entry) = (free[i - 1].min(entry), free[i - 1].max(entry));
            }
            free[0] = entry;
            count += 1;
        }
        self.len += count;
    }

    /// Pushes entries, at most as many as a node has children, in no order.
    #[inline(always)]
    pub(super) fn push_any(&mut self, entries: impl Iterator<Item = u64>) {
        let Some(free) = self.inline.get_mut(self.len..).and_then(<[u64]>::first_chunk_mut::<WIDTH>) else {
            self.spill.extend(entries);
            return;
        };
        let mut count = 0;
        for entry in entries {
            free[count] = entry;
            count += 1;
        }
        self.len += count;
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<u64> {
        if !self.spill.is_empty() {
            return self.spill.pop();
        }
        self.len = self.len.checked_sub(1)?;
        self.inline.get(self.len).copied()
    }
}

/// The lanes of a bit mask, lowest first.
pub(crate) struct Lanes(pub u32);

impl Iterator for Lanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        let any = self.0 != 0;
        self.0 &= self.0.wrapping_sub(1);
        any.then_some(lane)
    }
}
