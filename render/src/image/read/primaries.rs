//! Primaries of RGB: where they lie, what they weigh, and how colours of one set become those of another.

use glam::{DMat3, DVec3};

/// Primaries and white of an RGB space, CIE (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Primaries {
    pub red: [f64; 2],
    pub green: [f64; 2],
    pub blue: [f64; 2],
    pub white: [f64; 2],
}

/// ITU-R BT.709: what the renderer's colours are, and those of files that do not say.
pub(super) const REC_709: Primaries =
    Primaries { red: [0.64, 0.33], green: [0.3, 0.6], blue: [0.15, 0.06], white: [0.3127, 0.329] };

/// CIE XYZ itself, as OpenEXR writes it down.
const XYZ: Primaries =
    Primaries { red: [1.0, 0.0], green: [0.0, 1.0], blue: [0.0, 0.0], white: [1.0 / 3.0, 1.0 / 3.0] };

/// Chromaticities closer than this are the same, rounded by those who wrote them.
const SAME: f64 = 1e-3;

/// Cones of Bradford's adaptation (Lam 1985), by columns.
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

/// XYZ of a white, at Y = 1.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x, y, 1.0 - x - y) / y
}

impl Primaries {
    /// RGB to XYZ, white at Y = 1 (SMPTE RP 177); `None` where the primaries span no plane.
    pub(super) fn to_xyz(self) -> Option<DMat3> {
        let direction = |[x, y]: [f64; 2]| DVec3::new(x, y, 1.0 - x - y);
        let columns = DMat3::from_cols(direction(self.red), direction(self.green), direction(self.blue));
        let matrix = columns * DMat3::from_diagonal(columns.inverse() * xyz(self.white));
        let usable = matrix.is_finite() && matrix.inverse().is_finite() && matrix.determinant().abs() > 1e-9;
        usable.then_some(matrix)
    }

    fn near(self, other: Self) -> bool {
        let all = |p: Self| [p.red, p.green, p.blue, p.white];
        all(self).iter().flatten().zip(all(other).iter().flatten()).all(|(a, b)| (a - b).abs() < SAME)
    }

    /// These colours to Rec. 709, white staying white (XYZ as it is); `None` where nothing is to do.
    ///
    /// # Errors
    /// Primaries that span no plane.
    pub(super) fn to_rec_709(self) -> Result<Option<DMat3>, String> {
        if self.near(REC_709) {
            return Ok(None);
        }
        if self.near(XYZ) {
            return Ok(Some(xyz_to_rec_709()));
        }
        let wrong = || "its primaries are no colours".to_owned();
        let to_xyz = self.to_xyz().ok_or_else(wrong)?;
        let (from, to) = (BRADFORD * xyz(self.white), BRADFORD * xyz(REC_709.white));
        let adapt = BRADFORD.inverse() * DMat3::from_diagonal(to / from) * BRADFORD;
        let matrix = xyz_to_rec_709() * adapt * to_xyz;
        if matrix.is_finite() { Ok(Some(matrix)) } else { Err(wrong()) }
    }
}

/// CIE XYZ, Y = 1 for white, to Rec. 709.
pub(super) fn xyz_to_rec_709() -> DMat3 {
    REC_709.to_xyz().unwrap_or(DMat3::IDENTITY).inverse()
}

/// Applies a matrix to the colours of a picture.
pub(super) fn transform(rgba: &mut [[f32; 4]], matrix: DMat3) {
    for pixel in rgba {
        let rgb = matrix * DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into());
        pixel[..3].copy_from_slice(&rgb.as_vec3().to_array());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_matrices() {
        // IEC 61966-2-1, annex: the second row is luminance.
        let y = REC_709.to_xyz().unwrap().row(1);
        assert!((y - DVec3::new(0.2126, 0.7152, 0.0722)).length() < 1e-4, "{y}");
        // ACES AP0 to Rec. 709, with Bradford's adaptation from D60 to D65 (colour-science 0.4).
        let ap0 =
            Primaries { red: [0.7347, 0.2653], green: [0.0, 1.0], blue: [0.0001, -0.077], white: [0.32168, 0.33767] };
        let matrix = ap0.to_rec_709().unwrap().unwrap();
        assert!((matrix.row(0) - DVec3::new(2.5217, -1.1341, -0.3876)).length() < 1e-3, "{matrix}");
        assert!((matrix * DVec3::ONE - DVec3::ONE).length() < 1e-6);
        assert_eq!(REC_709.to_rec_709(), Ok(None));
        let flat = Primaries { green: [0.64, 0.33], ..REC_709 };
        assert!(flat.to_rec_709().is_err());
    }
}
