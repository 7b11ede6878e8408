//! Vertices shared by the corners of faces that agree in everything.

use std::collections::HashMap;
use std::hash::Hash;

/// Corners at one position are searched one by one up to so many, and by hash beyond.
const LONGEST: usize = 16;
const END: u32 = u32::MAX;

/// Vertices made so far, chained by position: `first[p]` heads the list of the vertices at position `p`. `K` is what
/// else a corner has.
#[derive(Default)]
pub struct Corners<K> {
    first: Vec<u32>,
    next: Vec<u32>,
    keys: Vec<K>,
    crowded: HashMap<(u32, K), u32>,
}

impl<K: Copy + Eq + Hash> Corners<K> {
    /// The vertex of a corner, numbered in the order of first use, and whether this is its first.
    pub fn vertex(&mut self, position: u32, key: K) -> (u32, bool) {
        if self.first.len() <= position as usize {
            self.first.resize(position as usize + 1, END);
        }
        let head = self.first[position as usize];
        let (mut vertex, mut length) = (head, 0);
        while vertex != END {
            if self.keys[vertex as usize] == key {
                return (vertex, false);
            }
            vertex = self.next[vertex as usize];
            length += 1;
        }
        let new = self.keys.len() as u32;
        if length < LONGEST {
            self.first[position as usize] = new;
            self.next.push(head);
        } else {
            let known = *self.crowded.entry((position, key)).or_insert(new);
            if known != new {
                return (known, false);
            }
            self.next.push(END);
        }
        self.keys.push(key);
        (new, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_corners_share_a_vertex_however_many_there_are() {
        let mut corners = Corners::default();
        for round in 0..2 {
            for key in 0..100 {
                assert_eq!(corners.vertex(7, key), (2 * key, round == 0));
                assert_eq!(corners.vertex(key, 1000 + key), (2 * key + 1, round == 0));
            }
        }
    }
}
