//! Point clouds: many equal splats, drawn in one of rviz's styles.
//!
//! Reproduces `rviz::PointCloud` and its shaders. All splats of a cloud have one size and one style; the geometry
//! ([`PointBuffer`]) is apart from style, size and opacity, so that changing those does not touch the points.

use std::sync::Arc;

/// The largest point of `Style: Points` that Mesa and Intel's drivers draw, in pixels; rviz's larger ones come out at
/// this size.
pub const MAX_POINT_SIZE_PX: f32 = 255.0;

/// Shape of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointStyle {
    /// A round spot of a fixed size on the image, `Style: Points`. It has the depth of its centre.
    Points {
        /// Diameter in pixels; drawn as at least 1 and at most [`MAX_POINT_SIZE_PX`], as OpenGL does.
        diameter_px: f32,
    },
    /// A square facing the eye with a contrasting edge, `Style: Squares`. It stands upright to the y axis of the
    /// object's frame: its sides run along `right = y × at` and `up = at × right`, `at` being the direction to the eye.
    Squares {
        /// Width and height in metres; clouds have squares, markers may have oblongs.
        size_m: [f32; 2],
    },
    /// A square facing the eye in one colour, `Style: Flat Squares`.
    FlatSquares {
        /// Side length in metres.
        side_m: f32,
    },
    /// A disc in the plane of such a square, darker to its edge, `Style: Spheres`.
    Spheres {
        /// Width and height in metres; an ellipse where they differ.
        size_m: [f32; 2],
    },
    /// A box along the axes of the cloud's own frame, each side with a shade and a darker edge, `Style: Boxes`.
    Boxes {
        /// Edge lengths in metres along the object's x, y and z.
        size_m: [f32; 3],
    },
    /// A square of a fixed orientation in the object's frame with a contrasting edge (`rviz::PointCloud::RM_TILES`,
    /// used by GridCells).
    Tiles {
        /// Side lengths in metres along `up` × `normal` and along `up`.
        size_m: [f32; 2],
        /// Unit normal in the object's frame.
        normal: [f32; 3],
        /// Unit up direction in the object's frame.
        up: [f32; 3],
    },
}

impl PointStyle {
    /// Sets the side, diameter or edge in metres. A size in pixels stays as it is.
    #[must_use]
    pub fn with_side(self, side_m: f32) -> Self {
        match self {
            Self::Points { .. } => self,
            Self::Squares { .. } => Self::Squares { size_m: [side_m; 2] },
            Self::FlatSquares { .. } => Self::FlatSquares { side_m },
            Self::Spheres { .. } => Self::Spheres { size_m: [side_m; 2] },
            Self::Boxes { .. } => Self::Boxes { size_m: [side_m; 3] },
            Self::Tiles { normal, up, .. } => Self::Tiles { size_m: [side_m; 2], normal, up },
        }
    }
}

/// The colours of a cloud's points.
#[derive(Clone, Debug, PartialEq)]
pub enum PointColors {
    /// One colour, red first, for all points.
    Uniform([u8; 4]),
    /// One colour a point, red first, in the order of the positions.
    PerPoint(Vec<[u8; 4]>),
}

impl PointColors {
    /// The colour of the point with this index, red first; white past the end.
    #[inline]
    pub fn get(&self, index: usize) -> [u8; 4] {
        match self {
            Self::Uniform(color) => *color,
            Self::PerPoint(colors) => colors.get(index).copied().unwrap_or([255; 4]),
        }
    }
}

/// The points of a cloud; every position is finite.
#[derive(Clone, Debug, PartialEq)]
pub struct PointBuffer {
    /// Positions in metres in the object's frame.
    pub positions: Vec<[f32; 3]>,
    /// Colours; as many as positions, or one for all.
    pub colors: PointColors,
}

/// The way a cloud is drawn: the fields of [`Points`] without its buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLook {
    /// See [`Points::style`].
    pub style: PointStyle,
    /// See [`Points::alpha`].
    pub alpha: f32,
    /// See [`Points::blended`].
    pub blended: bool,
    /// See [`Points::auto_size`].
    pub auto_size: bool,
}

impl PointLook {
    /// A cloud that is drawn in this way.
    pub fn of(self, buffer: Arc<PointBuffer>) -> Points {
        let Self { style, alpha, blended, auto_size } = self;
        Points { buffer, style, alpha, blended, auto_size }
    }
}

/// A cloud with the way it is drawn.
#[derive(Clone, Debug)]
pub struct Points {
    /// Positions and colours.
    pub buffer: Arc<PointBuffer>,
    /// Shape of each point.
    pub style: PointStyle,
    /// Opacity of 0 to 1, multiplied with each colour's own.
    pub alpha: f32,
    /// `true` if points blend with the pixels behind them and do not write depth. rviz does so below an opacity of
    /// 0.9998 and where each point has an opacity of its own; otherwise points replace the pixels, whatever their
    /// alpha.
    pub blended: bool,
    /// Sizes are multiplied by each point's z in the object's frame (DepthCloud's "Auto Size").
    pub auto_size: bool,
}

impl Points {
    /// The way it is drawn.
    pub fn look(&self) -> PointLook {
        let &Self { style, alpha, blended, auto_size, .. } = self;
        PointLook { style, alpha, blended, auto_size }
    }
}
