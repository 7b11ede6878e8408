//! Windows of OpenEXR: the picture is the display window, of which the file holds the data window.

use std::fmt;

/// A rectangle of pixels in the plane that all files of one picture share; x to the right, y down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First column and row.
    pub min: [i32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

impl Window {
    /// One past the last column and row.
    fn end(&self) -> [i64; 2] {
        [0, 1].map(|i| i64::from(self.min[i]) + i64::from(self.size[i]))
    }

    fn contains(&self, other: &Self) -> bool {
        (0..2).all(|i| self.min[i] <= other.min[i] && self.end()[i] >= other.end()[i])
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let ([x, y], [right, bottom]) = (self.min, self.end());
        write!(f, "({x}, {y}) to ({}, {})", right - 1, bottom - 1)
    }
}

/// Where a picture lies, and what of it the file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Windows {
    /// The picture.
    pub display: Window,
    /// The pixels in the file: black outside of them, cut off outside of the display window.
    pub data: Window,
    /// Whether the display window may be a part of a film, with its place there: `render image --crop` writes it so.
    pub placed: bool,
}

impl Windows {
    /// Whether the file holds only a part of the picture.
    pub fn is_part(&self) -> bool {
        !self.data.contains(&self.display)
    }

    /// Whether these are different parts of one picture, which have nothing to be compared in.
    pub fn are_other_parts_than(&self, other: &Self) -> bool {
        if self.placed
            && other.placed
            && self.display.size == other.display.size
            && self.display.min != other.display.min
        {
            return true;
        }
        self.display == other.display && self.is_part() && other.is_part() && self.data != other.data
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_one_picture() {
        let display = Window { min: [-4, 0], size: [32, 16] };
        let part = |x, y, width, height| Windows {
            display,
            data: Window { min: [x, y], size: [width, height] },
            placed: false,
        };
        let (left, right) = (part(-4, 0, 16, 16), part(12, 0, 16, 16));
        assert!(left.are_other_parts_than(&right) && !left.are_other_parts_than(&left));
        // A file that holds the whole picture, or more, can be compared with any part.
        for whole in [part(-4, 0, 32, 16), part(-10, -1, 40, 18)] {
            assert!(!whole.is_part() && !whole.are_other_parts_than(&left) && !left.are_other_parts_than(&whole));
        }
        let elsewhere = Windows { display: Window { min: [0, 0], ..display }, ..right };
        assert!(!left.are_other_parts_than(&elsewhere));
        // Two crops of one size by `render image` are the same part only in the same place; others may lie anywhere.
        let crop = |x, placed| {
            let window = Window { min: [x, 2], size: [5, 4] };
            Windows { display: window, data: window, placed }
        };
        assert!(crop(0, true).are_other_parts_than(&crop(3, true)));
        assert!(!crop(3, true).are_other_parts_than(&crop(3, true)));
        assert!(!crop(3, true).are_other_parts_than(&crop(0, false)));
        assert_eq!(right.data.to_string(), "(12, 0) to (27, 15)");
    }
}
