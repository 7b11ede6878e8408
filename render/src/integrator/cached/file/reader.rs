//! The bytes of records.

use super::error::CacheFileError;

/// What is left of a file.
pub struct Reader<'a> {
    pub(super) bytes: &'a [u8],
    /// Materials of the scene, and what stands for one.
    pub(super) materials: u32,
}

impl<'a> Reader<'a> {
    /// The next bytes.
    ///
    /// # Errors
    /// A file that ends before.
    pub fn take(&mut self, n: usize) -> Result<&'a [u8], CacheFileError> {
        let (head, rest) = self.bytes.split_at_checked(n).ok_or(CacheFileError::Format("it is truncated"))?;
        self.bytes = rest;
        Ok(head)
    }

    /// The next number of four bytes.
    ///
    /// # Errors
    /// A file that ends before.
    pub fn word(&mut self) -> Result<u32, CacheFileError> {
        Ok(u32::from_le_bytes(self.take(4)?.try_into().expect("four bytes")))
    }

    /// N finite numbers.
    ///
    /// # Errors
    /// One that is not.
    pub fn numbers<const N: usize>(&mut self) -> Result<[f32; N], CacheFileError> {
        let mut numbers = [0.0; N];
        for x in &mut numbers {
            *x = f32::from_bits(self.word()?);
            if !x.is_finite() {
                return Err(CacheFileError::Format("a number is not finite"));
            }
        }
        Ok(numbers)
    }

    /// Refuses an index of no material.
    ///
    /// # Errors
    /// Such an index.
    pub fn check_material(&self, material: u32) -> Result<(), CacheFileError> {
        if material < self.materials { Ok(()) } else { Err(CacheFileError::Format("a record of no material")) }
    }
}

/// Appends numbers, little-endian.
pub fn write_numbers(bytes: &mut Vec<u8>, numbers: impl IntoIterator<Item = f32>) {
    numbers.into_iter().for_each(|x| bytes.extend(x.to_le_bytes()));
}

/// Appends whole numbers, little-endian.
pub fn write_words(bytes: &mut Vec<u8>, words: impl IntoIterator<Item = u32>) {
    words.into_iter().for_each(|x| bytes.extend(x.to_le_bytes()));
}
