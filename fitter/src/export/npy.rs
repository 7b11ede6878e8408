//! The array format of numpy, version 1.0: an array in single precision, little-endian, C order.

/// The bytes of a file.
pub fn npy(shape: &[usize], values: &[f32]) -> Vec<u8> {
    let sides: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}), }}", sides.trim_end());
    // Magic, version and the length take ten bytes; numbers begin at a multiple of 64.
    let padding = 63 - (10 + header.len()) % 64;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(values.iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_is_aligned() {
        for shape in [vec![3], vec![2, 5], vec![10, 1, 12, 24, 9]] {
            let count: usize = shape.iter().product();
            let bytes = npy(&shape, &vec![0.5; count]);
            let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            assert_eq!((10 + length) % 64, 0);
            assert_eq!(bytes.len(), 10 + length + 4 * count);
            assert!(String::from_utf8_lossy(&bytes[10..10 + length]).ends_with(" \n"));
        }
    }
}
