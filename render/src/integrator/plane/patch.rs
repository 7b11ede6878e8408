//! A primitive in pieces: a triangle in triangles of equal area, as many as the square of a whole number; a sphere in rectangles of its angles.

use crate::world::Outline;
use core::f32::consts::{PI, TAU};
use glam::{Vec2, Vec3A};

/// Azimuths and zenith angles of a sphere.
pub(super) const SPHERE: [u32; 2] = [32, 16];

/// A primitive and its pieces: those of the front (from where the corners of a triangle turn to the left; outside of a sphere), then as
/// many of the back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    pub outline: Outline,
    /// Number of the first piece.
    pub first: u32,
    /// Pieces along an edge of a triangle.
    pub edge: u32,
}

/// A point of a piece: barycentric coordinates of a triangle, world position, and a unit direction away from the front.
pub(super) struct Place {
    pub barycentric: Vec2,
    pub position: Vec3A,
    pub outward: Vec3A,
}

impl Patch {
    /// Pieces of one of its two sides.
    pub fn pieces(&self) -> u32 {
        match self.outline {
            Outline::Triangle(_) => self.edge * self.edge,
            Outline::Ellipsoid { .. } => SPHERE[0] * SPHERE[1],
        }
    }

    /// The piece where a ray meets the primitive: `uv` are the barycentric coordinates of a triangle, those of the texture of a sphere,
    /// `toward` leads to where the ray came from.
    pub fn piece(&self, uv: Vec2, position: Vec3A, toward: Vec3A) -> u32 {
        let (number, outward) = match self.outline {
            Outline::Triangle([a, b, c]) => (piece_of_triangle(uv, self.edge), (b - a).cross(c - a)),
            Outline::Ellipsoid { center, .. } => {
                let [column, row] =
                    [(uv.x, SPHERE[0]), (uv.y, SPHERE[1])].map(|(x, n)| ((x * n as f32) as u32).min(n - 1));
                (row * SPHERE[0] + column, position - center)
            }
        };
        let is_back = outward.dot(toward) < 0.0;
        self.first + number + if is_back { self.pieces() } else { 0 }
    }

    /// A point of piece `number` of a side, uniform over it.
    pub fn place(&self, number: u32, u: Vec2) -> Place {
        match self.outline {
            Outline::Triangle([a, b, c]) => {
                let barycentric = point_of_triangle(number, self.edge, u);
                let (e1, e2) = (b - a, c - a);
                let position = a + e1 * barycentric.x + e2 * barycentric.y;
                Place { barycentric, position, outward: e1.cross(e2).normalize_or(Vec3A::Z) }
            }
            Outline::Ellipsoid { center, axes } => {
                let [column, row] = [number % SPHERE[0], number / SPHERE[0]];
                let phi = TAU * (column as f32 + u.x) / SPHERE[0] as f32;
                let height = |row: u32| (PI * row as f32 / SPHERE[1] as f32).cos();
                let z = height(row) + u.y * (height(row + 1) - height(row));
                let radius = (1.0 - z * z).max(0.0).sqrt();
                let from_center = axes * Vec3A::new(radius * phi.cos(), radius * phi.sin(), z);
                Place {
                    barycentric: Vec2::ZERO,
                    position: center + from_center,
                    outward: from_center.normalize_or(Vec3A::Z),
                }
            }
        }
    }

    /// Triangles that a rasteriser draws, each with its first piece and pieces along an edge: of a sphere, two for each piece.
    #[cfg(feature = "gpu")]
    pub fn triangles(&self) -> Vec<([Vec3A; 3], u32, u32)> {
        match self.outline {
            Outline::Triangle(corners) => vec![(corners, self.first, self.edge)],
            Outline::Ellipsoid { center, axes } => {
                let corner = |column: u32, row: u32| {
                    let (phi, theta) = (TAU * column as f32 / SPHERE[0] as f32, PI * row as f32 / SPHERE[1] as f32);
                    center + axes * Vec3A::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
                };
                let mirrored = axes.determinant() < 0.0;
                let rectangle = |number: u32| {
                    let [column, row] = [number % SPHERE[0], number / SPHERE[0]];
                    let [a, b, c, d] = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(x, y)| corner(column + x, row + y));
                    let turned = |[a, b, c]: [Vec3A; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
                    [[a, b, c], [a, c, d]].map(|corners| (turned(corners), self.first + number, 1))
                };
                (0..self.pieces()).flat_map(rectangle).collect()
            }
        }
    }
}

/// Pieces lie in strips along the first edge, from the first corner on: in strip j, n − j that are placed as the whole triangle, and turned ones
/// between them.
fn piece_of_triangle(barycentric: Vec2, n: u32) -> u32 {
    let at = (barycentric * n as f32).max(Vec2::ZERO);
    let j = (at.y as u32).min(n - 1);
    let i = (at.x as u32).min(n - 1 - j);
    let beyond = at.x - i as f32 + at.y - j as f32 > 1.0;
    j * (2 * n - j) + 2 * i + u32::from(beyond && i + j + 1 < n)
}

/// Barycentric coordinates of a point, uniform over a piece.
fn point_of_triangle(piece: u32, n: u32, u: Vec2) -> Vec2 {
    // Before strip j lie j (2n − j) pieces, so that n² − `piece` of them, (n − j)² at most, are left.
    let left = f64::from(n * n - piece).sqrt().ceil() as u32;
    let j = n - left;
    let within = piece - j * (2 * n - j);
    let (i, turned) = (within / 2, within % 2);
    let inner = if u.x + u.y > 1.0 { 1.0 - u } else { u };
    let inner = if turned == 1 { 1.0 - inner } else { inner };
    (Vec2::new(i as f32, j as f32) + inner) / n as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;
    use glam::Mat3A;

    /// Points of a piece are found in it again, whatever the primitive, and only from their own side.
    #[test]
    fn places_are_found_in_their_piece() {
        let corners = [Vec3A::new(1.0, 0.0, 2.0), Vec3A::new(4.0, 1.0, 2.0), Vec3A::new(0.0, 5.0, 3.0)];
        let sphere = Outline::Ellipsoid { center: Vec3A::ONE, axes: Mat3A::from_diagonal(glam::Vec3::splat(2.0)) };
        for (outline, edge) in [(Outline::Triangle(corners), 1), (Outline::Triangle(corners), 7), (sphere, 1)] {
            let patch = Patch { outline, first: 11, edge };
            for number in 0..patch.pieces() {
                for k in 0..16 {
                    let u = 0.02 + 0.96 * Sampler::new(5, (number, 0), k).next_2d();
                    let place = patch.place(number, u);
                    let uv = match outline {
                        Outline::Triangle(_) => place.barycentric,
                        Outline::Ellipsoid { .. } => {
                            let d = (place.position - Vec3A::ONE) / 2.0;
                            Vec2::new(d.y.atan2(d.x).rem_euclid(TAU) / TAU, d.z.acos() / PI)
                        }
                    };
                    let (front, back) = (11 + number, 11 + number + patch.pieces());
                    assert_eq!(patch.piece(uv, place.position, place.outward), front, "{outline:?} {u}");
                    assert_eq!(patch.piece(uv, place.position, -place.outward), back, "{outline:?} {u}");
                }
            }
        }
    }

    /// Every piece of a triangle has the same share of its points.
    #[test]
    fn pieces_have_the_same_area() {
        let n = 5;
        let mut counts = vec![0; 25];
        let total = 100_000;
        for k in 0..total {
            let u = Sampler::new(9, (0, 0), k).next_2d();
            let inner = if u.x + u.y > 1.0 { 1.0 - u } else { u };
            counts[piece_of_triangle(inner, n) as usize] += 1;
        }
        assert!(counts.iter().all(|count| (3800..4200).contains(count)), "{counts:?}");
    }
}
