//! Advice for the next pose of a board, by its poses so far.

use std::fmt;

use nalgebra::{Isometry3, Vector3};

/// Minimum tilt of a board to each side, radians.
const TILT_RAD: f64 = 0.25;
/// Minimum ratio of the farthest and the nearest pose.
const DEPTH_RATIO: f64 = 1.2;

/// Advice for the next pose. Directions are those of the camera's image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoardAdvice {
    /// The first pose.
    Face,
    /// The board's left side away from the camera.
    TiltLeft,
    /// The board's right side away from the camera.
    TiltRight,
    /// The board's upper side away from the camera.
    TiltBack,
    /// The board's lower side away from the camera.
    TiltForward,
    /// Nearer to the projector.
    Nearer,
    /// Farther from the projector.
    Farther,
    /// Where the projector's image has no points yet.
    Elsewhere,
}

impl fmt::Display for BoardAdvice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

impl BoardAdvice {
    /// The advice in words.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Face => "hold the board so that camera and projector see all of it",
            Self::TiltLeft => "tilt the board to the left: its left side away from the camera",
            Self::TiltRight => "tilt the board to the right: its right side away from the camera",
            Self::TiltBack => "tilt the board back: its upper side away from the camera",
            Self::TiltForward => "tilt the board forward: its lower side away from the camera",
            Self::Nearer => "bring the board nearer",
            Self::Farther => "take the board farther away",
            Self::Elsewhere => "move the board to a part of the projector's image where it was not yet",
        }
    }
}

/// Advice by the board's poses `camera_from_board` so far.
pub fn advice(poses: &[Isometry3<f64>]) -> BoardAdvice {
    if poses.is_empty() {
        return BoardAdvice::Face;
    }
    // The normal, away from the camera, leans to where the board recedes less; sides recede by the opposite sign.
    let normals: Vec<Vector3<f64>> = poses
        .iter()
        .map(|pose| {
            let normal = pose.rotation * Vector3::z();
            let view = pose.translation.vector.normalize();
            normal - view
        })
        .collect();
    let least = TILT_RAD.sin();
    let tilts = [
        (BoardAdvice::TiltLeft, normals.iter().any(|normal| normal.x > least)),
        (BoardAdvice::TiltRight, normals.iter().any(|normal| normal.x < -least)),
        (BoardAdvice::TiltBack, normals.iter().any(|normal| normal.y > least)),
        (BoardAdvice::TiltForward, normals.iter().any(|normal| normal.y < -least)),
    ];
    if let Some((advice, _)) = tilts.into_iter().find(|(_, is_done)| !is_done) {
        return advice;
    }
    let depths = || poses.iter().map(|pose| pose.translation.z);
    let (nearest, farthest) = (depths().fold(f64::INFINITY, f64::min), depths().fold(0.0, f64::max));
    let last = poses.last().map_or(nearest, |pose| pose.translation.z);
    if farthest > DEPTH_RATIO * nearest {
        BoardAdvice::Elsewhere
    } else if last > (nearest * farthest).sqrt() {
        BoardAdvice::Nearer
    } else {
        BoardAdvice::Farther
    }
}
