//! Albedo of a solid's surface, with a mild texture.
//!
//! Textures are volumetric in the solid's frame, so they need no unwrapping.

use nalgebra::Point3;
use rcs_calibration::board::Chessboard;

use crate::random::{mixed, unit};
use crate::Random;

/// Minimum albedo.
const DARKEST: f64 = 0.15;
/// Maximum albedo.
const BRIGHTEST: f64 = 0.95;
/// Albedo of paper and ink.
const PAPER: f64 = 0.85;
const INK: f64 = 0.06;
/// Half the width of the edge of printed ink, metres.
const EDGE_M: f64 = 0.0004;

/// Texture of the albedo.
#[derive(Debug, Clone, Copy)]
enum Texture {
    Plain,
    Checker,
    Noise,
    /// Chessboard around the origin of the plane z = 0.
    Board(Chessboard),
}

/// Diffuse surface of a solid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surface {
    /// Mean albedo.
    albedo: f64,
    texture: Texture,
    /// Maximum relative deviation of the albedo.
    contrast: f64,
    /// Feature size of the texture, metres.
    size_m: f64,
    seed: u64,
}

impl Surface {
    /// Uniform surface.
    pub(crate) fn plain(albedo: f64) -> Self {
        Self { albedo, texture: Texture::Plain, contrast: 0.0, size_m: 1.0, seed: 0 }
    }

    /// Printed chessboard, with a white margin.
    pub(crate) fn board(board: Chessboard) -> Self {
        let texture = Texture::Board(board);
        Self { albedo: PAPER, texture, contrast: 0.0, size_m: 1.0, seed: 0 }
    }

    /// Random surface with a mean albedo of at least `darkest`.
    pub(crate) fn random(random: &mut Random, darkest: f64) -> Self {
        let texture = match random.integer(0, 3) {
            0 => Texture::Plain,
            1 => Texture::Checker,
            _ => Texture::Noise,
        };
        Self {
            albedo: random.uniform(darkest.max(DARKEST), BRIGHTEST),
            texture,
            contrast: random.uniform(0.05, 0.35),
            size_m: random.uniform(0.015, 0.12),
            seed: random.bits(),
        }
    }

    /// The surface with another texture in place of checkers.
    pub(crate) fn without_checkers(self) -> Self {
        let texture = if matches!(self.texture, Texture::Checker) { Texture::Noise } else { self.texture };
        Self { texture, ..self }
    }

    /// Albedo at a point of the solid's frame.
    pub(crate) fn albedo(&self, local: &Point3<f64>) -> f64 {
        let place = local / self.size_m;
        let deviation = match self.texture {
            Texture::Plain => return self.albedo,
            Texture::Checker => {
                // Offset from the planes through the origin, on which faces lie.
                let odd = place.iter().map(|x| (x + 0.31).floor() as i64).sum::<i64>() & 1;
                2.0 * odd as f64 - 1.0
            }
            Texture::Board(board) => return board_albedo(&board, local),
            Texture::Noise => 2.0 * self.noise(&place) - 1.0,
        };
        (self.albedo * (1.0 + self.contrast * deviation)).clamp(DARKEST, BRIGHTEST)
    }

    /// Value noise, 0 to 1: random values on a lattice, interpolated.
    fn noise(&self, place: &Point3<f64>) -> f64 {
        let cell = place.map(f64::floor);
        let weight = (place - cell).map(|x| x * x * (3.0 - 2.0 * x));
        let mut sum = 0.0;
        for corner in 0..8_u8 {
            let mut share = 1.0;
            let mut key = self.seed;
            for axis in 0..3 {
                let is_upper = corner >> axis & 1 == 1;
                share *= if is_upper { weight[axis] } else { 1.0 - weight[axis] };
                key = mixed(key ^ (cell[axis] as i64 + i64::from(is_upper)) as u64).wrapping_add(axis as u64);
            }
            sum += share * unit(mixed(key));
        }
        sum
    }
}

/// Albedo of a chessboard at a point; its squares are one more than its inner corners along both sides.
fn board_albedo(board: &Chessboard, local: &Point3<f64>) -> f64 {
    let mut sign = 1.0;
    for axis in 0..2 {
        let squares = f64::from(board.corners[axis]) + 1.0;
        let place = local[axis] / board.square_m + 0.5 * squares;
        if !(0.0..squares).contains(&place) {
            return PAPER;
        }
        let off_edge_m = (place - place.round()) * board.square_m;
        let is_odd = place.round() as i64 & 1 == 1;
        sign *= (off_edge_m / EDGE_M).clamp(-1.0, 1.0) * if is_odd { -1.0 } else { 1.0 };
    }
    0.5 * (PAPER + INK) - 0.5 * (PAPER - INK) * sign
}
