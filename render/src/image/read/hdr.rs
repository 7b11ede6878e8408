//! Radiance HDR (Ward 1991; the manual's "filefmts"): a header of text, the resolution with one of eight orientations,
//! and scanlines of four bytes a pixel: flat, or in the old or the new run-length encoding.

use super::compact::compact;
use super::primaries::{self, Primaries};
use super::{Pixels, check_plausible, check_size, filled};
use glam::DMat3;

/// How a file begins; which word follows is the writer's affair (`RADIANCE`, `RGBE`, …).
pub(super) const MAGIC: &[u8] = b"#?";

/// Longest line of a header.
const MAX_LINE: usize = 1 << 16;

/// Pixels that a byte can stand for: runs of 127 bytes of each of four components; the old runs are no better where
/// they are used.
const PIXELS_PER_BYTE: usize = 1 << 13;

/// What the header says of the pixels.
struct Header {
    /// What the pixels have to be divided by.
    factor: [f32; 3],
    /// To Rec. 709.
    matrix: Option<DMat3>,
}

/// The way through the picture: from the first pixel, to the next of a scanline, and to the next scanline.
struct Order {
    width: u32,
    height: u32,
    /// Pixels of a scanline, and scanlines.
    length: usize,
    count: usize,
    start: isize,
    step: isize,
    line: isize,
}

pub(super) fn decode(bytes: &[u8]) -> Result<Pixels, String> {
    let mut rest = bytes;
    let header = header(&mut rest)?;
    let order = resolution(line(&mut rest)?)?;
    let pixels = check_size(order.width.into(), order.height.into())?;
    check_plausible(pixels, bytes.len(), PIXELS_PER_BYTE)?;
    let mut rgba = filled(pixels, [0.0, 0.0, 0.0, 1.0])?;
    let mut scanline = vec![[0; 4]; order.length];
    for y in 0..order.count {
        read_scanline(&mut rest, &mut scanline).ok_or_else(|| format!("scanline {y} is broken"))?;
        for (x, &[r, g, b, exponent]) in scanline.iter().enumerate() {
            let scale = if exponent == 0 { 0.0 } else { f32::exp2(f32::from(exponent) - 136.0) };
            let at = order.start + x as isize * order.step + y as isize * order.line;
            let rgb = [r, g, b].map(|mantissa| f32::from(mantissa) * scale);
            for ((value, stored), factor) in rgba[at as usize].iter_mut().zip(rgb).zip(header.factor) {
                *value = stored / factor;
            }
        }
    }
    if let Some(matrix) = header.matrix {
        primaries::transform(&mut rgba, matrix);
    }
    let raster = compact(order.width, order.height, rgba);
    Ok(Pixels { raster, ..Pixels::default() })
}

/// The next line, without its end.
fn line<'a>(rest: &mut &'a [u8]) -> Result<&'a str, String> {
    let end = rest.iter().take(MAX_LINE).position(|b| *b == b'\n').ok_or("its header does not end")?;
    let line = &rest[..end];
    *rest = &rest[end + 1..];
    // Names of files and comments may be in any encoding; they are not used.
    Ok(str::from_utf8(line.strip_suffix(b"\r").unwrap_or(line)).unwrap_or("?"))
}

/// Reads up to the empty line. Lines of the pictures that this one was made from are indented: they no longer hold.
fn header(rest: &mut &[u8]) -> Result<Header, String> {
    let (mut factor, mut primaries, mut xyz) = ([1f32; 3], None, false);
    loop {
        let line = line(rest)?;
        if line.is_empty() {
            break;
        }
        let Some((name, value)) = line.split_once('=') else { continue };
        let wrong = || format!("{name}={value}: not understood");
        match name {
            "FORMAT" => match value.trim() {
                "32-bit_rle_rgbe" => xyz = false,
                "32-bit_rle_xyze" => xyz = true,
                other => return Err(format!("the format `{other}` is neither 32-bit_rle_rgbe nor 32-bit_rle_xyze")),
            },
            "EXPOSURE" => {
                let [exposure] = numbers(value).ok_or_else(wrong)?;
                factor = factor.map(|f| f * exposure as f32);
            }
            "COLORCORR" => {
                let correction: [f64; 3] = numbers(value).ok_or_else(wrong)?;
                factor = [0, 1, 2].map(|i| factor[i] * correction[i] as f32);
            }
            "PRIMARIES" => {
                let [rx, ry, gx, gy, bx, by, wx, wy] = numbers(value).ok_or_else(wrong)?;
                primaries = Some(Primaries { red: [rx, ry], green: [gx, gy], blue: [bx, by], white: [wx, wy] });
            }
            _ => {}
        }
    }
    if !factor.iter().all(|f| f.is_normal() && *f > 0.0) {
        return Err(format!("an exposure of {factor:?}"));
    }
    let matrix = match primaries {
        // The primaries of XYZ are known.
        _ if xyz => Some(primaries::xyz_to_rec_709()),
        Some(primaries) => primaries.to_rec_709()?,
        None => None,
    };
    Ok(Header { factor, matrix })
}

/// Exactly `N` numbers between white space.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let all: Vec<f64> = text.split_whitespace().map(|t| t.parse().ok()).collect::<Option<_>>()?;
    all.try_into().ok().filter(|n: &[f64; N]| n.iter().all(|x| x.is_finite()))
}

/// `-Y 16 +X 32`: scanlines from the top, each from the left. The axis named first is that of the scanlines.
fn resolution(text: &str) -> Result<Order, String> {
    let wrong = || format!("the resolution `{}` is not understood", text.chars().take(40).collect::<String>());
    let words: Vec<_> = text.split_whitespace().collect();
    let &[slow, count, fast, length] = &words[..] else { return Err(wrong()) };
    let number = |word: &str| word.parse::<u32>().ok().filter(|n| *n > 0).ok_or_else(wrong);
    let (count, length) = (number(count)?, number(length)?);
    let (width, height) = match (slow, fast) {
        ("-Y" | "+Y", "+X" | "-X") => (length, count),
        ("+X" | "-X", "-Y" | "+Y") => (count, length),
        _ => return Err(wrong()),
    };
    check_size(width.into(), height.into())?;
    let (columns, rows) = (width as isize, height as isize);
    // Where a way along one axis begins, and its step.
    let axis = |name| match name {
        "+X" => (0, 1),
        "-X" => (columns - 1, -1),
        "-Y" => (0, columns),
        _ => ((rows - 1) * columns, -columns),
    };
    let ((slow_start, line), (fast_start, step)) = (axis(slow), axis(fast));
    let (count, length) = (count as usize, length as usize);
    Ok(Order { width, height, length, count, start: slow_start + fast_start, step, line })
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, after) = rest.split_at_checked(count)?;
    *rest = after;
    Some(taken)
}

/// Reads a scanline in whichever encoding it is.
fn read_scanline(rest: &mut &[u8], pixels: &mut [[u8; 4]]) -> Option<()> {
    let new = |b: &[u8]| b[..2] == [2, 2] && usize::from(b[2]) << 8 | usize::from(b[3]) == pixels.len();
    if (8..1 << 15).contains(&pixels.len()) && rest.get(..4).is_some_and(new) {
        *rest = &rest[4..];
        return (0..4).try_for_each(|component| read_runs(rest, pixels, component));
    }
    // Flat pixels; (1, 1, 1, n) repeats the last one n times, and 256, 256², … times n after other repeats.
    let (mut at, mut shift) = (0, 0);
    while at < pixels.len() {
        let pixel: [u8; 4] = take(rest, 4)?.try_into().ok()?;
        if pixel[..3] == [1, 1, 1] {
            let count = usize::from(pixel[3]).checked_shl(shift).filter(|_| shift < 32)?;
            let last = *pixels.get(at.checked_sub(1)?)?;
            pixels.get_mut(at..at.checked_add(count)?)?.fill(last);
            (at, shift) = (at + count, shift + 8);
        } else {
            pixels[at] = pixel;
            (at, shift) = (at + 1, 0);
        }
    }
    Some(())
}

/// One component of a scanline: (128 + n, byte) repeats a byte n times, (n, bytes) are n of them.
fn read_runs(rest: &mut &[u8], pixels: &mut [[u8; 4]], component: usize) -> Option<()> {
    let mut at = 0;
    while at < pixels.len() {
        let code = usize::from(take(rest, 1)?[0]);
        let count = if code > 128 { code - 128 } else { code };
        let run = pixels.get_mut(at..at + count).filter(|run| !run.is_empty())?;
        let bytes = take(rest, if code > 128 { 1 } else { count })?;
        for (i, pixel) in run.iter_mut().enumerate() {
            pixel[component] = bytes[i.min(bytes.len() - 1)];
        }
        at += count;
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of flat pixels: their red mantissas, exponent 136.
    fn file(header: &str, resolution: &str, red: &[u8]) -> Vec<u8> {
        let mut bytes = format!("#?RADIANCE\n{header}\n{resolution}\n").into_bytes();
        bytes.extend(red.iter().flat_map(|r| [*r, 0, 0, 136]));
        bytes
    }

    fn reds(bytes: &[u8]) -> Vec<f32> {
        decode(bytes).unwrap().raster.pixels().map(|p| p[0]).collect()
    }

    #[test]
    fn eight_orientations() {
        // In the order of the file; the picture is 2 wide and 3 high.
        let right = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0];
        for (resolution, red) in [
            ("-Y 3 +X 2", [10, 20, 30, 40, 50, 60]),
            ("-Y 3 -X 2", [20, 10, 40, 30, 60, 50]),
            ("+Y 3 +X 2", [50, 60, 30, 40, 10, 20]),
            ("+Y 3 -X 2", [60, 50, 40, 30, 20, 10]),
            ("+X 2 -Y 3", [10, 30, 50, 20, 40, 60]),
            ("+X 2 +Y 3", [50, 30, 10, 60, 40, 20]),
            ("-X 2 -Y 3", [20, 40, 60, 10, 30, 50]),
            ("-X 2 +Y 3", [60, 40, 20, 50, 30, 10]),
        ] {
            assert_eq!(reds(&file("", resolution, &red)), right, "{resolution}");
        }
        for wrong in ["-Y 3 +Y 2", "3 2", "-Y 0 +X 2", "-Y 3 +X", "-Y 3 +X 2 7", "-Y 4294967295 +X 2"] {
            assert!(decode(&file("", wrong, &[0; 6])).is_err(), "{wrong}");
        }
    }

    #[test]
    fn exposures_are_divided_out() {
        let header = "EXPOSURE= 4\nPIXASPECT=2\n\tEXPOSURE=3\nEXPOSURE=2.5e-1\nCOLORCORR=2 1 1\nEXPOSURE=5\n";
        assert_eq!(reds(&file(header, "-Y 1 +X 1", &[20])), [2.0]);
        for wrong in ["EXPOSURE=0\n", "EXPOSURE=-1\n", "EXPOSURE=nan\n", "EXPOSURE=1 2\n", "COLORCORR=1\n"] {
            assert!(decode(&file(wrong, "-Y 1 +X 1", &[20])).is_err(), "{wrong}");
        }
    }

    #[test]
    fn runs_of_both_kinds() {
        // Old: a pixel, 2 repeats, and 256 · 1 more after them.
        let mut old = file("", "-Y 1 +X 260", &[7]);
        old.extend([1, 1, 1, 2, 1, 1, 1, 1, 9, 0, 0, 136]);
        let mut right = vec![7.0; 259];
        right.push(9.0);
        assert_eq!(reds(&old), right);
        // New: a run of 6 and 2 single bytes of red; the other components are runs.
        let mut new = file("", "-Y 1 +X 8", &[]);
        new.extend([2, 2, 0, 8, 134, 7, 2, 8, 9, 136, 0, 136, 0, 136, 136]);
        assert_eq!(reds(&new), [7.0, 7.0, 7.0, 7.0, 7.0, 7.0, 8.0, 9.0]);
        for length in 0..new.len() {
            assert!(decode(&new[..length]).is_err());
        }
        // A repeat with nothing before it, a run past the end, and a run of none.
        for pixels in [&[1, 1, 1, 8][..], &[9, 9, 9, 9, 1, 1, 1, 8], &[2, 2, 0, 8, 137, 0], &[2, 2, 0, 8, 0, 0]] {
            let mut bytes = file("", "-Y 1 +X 8", &[]);
            bytes.extend(pixels);
            assert!(decode(&bytes).is_err(), "{pixels:?}");
        }
    }

    #[test]
    fn xyz_becomes_rgb() {
        let mut bytes = b"#?AUTOPANO\r\nFORMAT=32-bit_rle_xyze\r\n\r\n-Y 1 +X 1\r\n".to_vec();
        // White of Rec. 709: X = 0.9505, Y = 1, Z = 1.089.
        bytes.extend([122, 128, 139, 129]);
        let pixel = decode(&bytes).unwrap().raster.pixel(0);
        assert!(pixel[..3].iter().all(|c| (c - 1.0).abs() < 0.02), "{pixel:?}");
    }
}
