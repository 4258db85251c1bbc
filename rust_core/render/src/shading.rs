//! How things are coloured: every constant and formula of shading, for both renderers.
//!
//! What [`shading!`] is given is written once and compiled twice. In Rust it becomes a constant or a function over
//! [`Number`]s, so that the CPU renderer takes the same formula for one value and for several side by side. As text it
//! becomes the head of every WGSL shader ([`with_shading`]): constants by their values, functions token by token. So a
//! formula keeps to what both languages share: `let`, `return`, arithmetic, and the functions of [`builtin`], which are
//! WGSL's own.
//!
//! Source: rviz's GLSL shaders and OpenGL's fixed-function lighting as rviz sets it up, both as seen in its images.
//!
//! Places on a face are given from its middle, in whole sides: from −0.5 to 0.5. Colours are 0 to 1 and not
//! gamma-corrected; formulas that are linear in them take 0 to 255 as well.

use std::fmt::Write;
use std::ops::{Add, Div, Mul, Sub};

use nalgebra::{Matrix3, Matrix4, Vector3};
use rcs_scene::{Camera, DirectionalLight, MAX_POINT_SIZE_PX};

use self::builtin::{abs, clamp, max, sign, sqrt};

/// A number, or several side by side.
pub(crate) trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    /// Without its sign.
    fn magnitude(self) -> Self;
    /// At least this; of NaN the limit.
    fn at_least(self, low: f32) -> Self;
    /// At most this.
    fn at_most(self, high: f32) -> Self;
    /// The square root.
    fn root(self) -> Self;
    /// −1, 0 or 1.
    fn sign(self) -> Self;
}

impl Number for f32 {
    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn at_least(self, low: f32) -> Self {
        self.max(low)
    }

    #[inline(always)]
    fn at_most(self, high: f32) -> Self {
        self.min(high)
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn sign(self) -> Self {
        f32::from(i8::from(self > 0.0) - i8::from(self < 0.0))
    }
}

/// The functions of WGSL that the formulas call.
mod builtin {
    use super::Number;

    #[inline(always)]
    pub(super) fn abs<T: Number>(value: T) -> T {
        value.magnitude()
    }

    #[inline(always)]
    pub(super) fn max<T: Number>(value: T, low: f32) -> T {
        value.at_least(low)
    }

    #[inline(always)]
    pub(super) fn clamp<T: Number>(value: T, low: f32, high: f32) -> T {
        value.at_least(low).at_most(high)
    }

    #[inline(always)]
    pub(super) fn sqrt<T: Number>(value: T) -> T {
        value.root()
    }

    #[inline(always)]
    pub(super) fn sign<T: Number>(value: T) -> T {
        value.sign()
    }
}

/// Constants and formulas in Rust, and `wgsl()` with the same in WGSL.
macro_rules! shading {
    (
        constants { $($(#[$const_doc:meta])* const $const:ident = $value:expr;)* }
        formulas { $($(#[$fn_doc:meta])* fn $fn:ident($($arg:ident),*) { $($body:tt)* })* }
    ) => {
        $($(#[$const_doc])* pub(crate) const $const: f32 = $value;)*

        $(
            $(#[$fn_doc])*
            #[inline(always)]
            #[allow(clippy::needless_return, reason = "WGSL has no other way to return a value")]
            pub(crate) fn $fn<T: Number>($($arg: T),*) -> T
            where
                f32: Add<T, Output = T> + Sub<T, Output = T>,
            {
                $($body)*
            }
        )*

        /// The constants and formulas in WGSL.
        fn wgsl() -> String {
            let mut wgsl = String::new();
            $(push_constant(&mut wgsl, stringify!($const), &format!("{:?}", $const));)*
            $(
                let arguments: &[&str] = &[$(stringify!($arg)),*];
                push_function(&mut wgsl, stringify!($fn), arguments, stringify!($($body)*));
            )*
            wgsl
        }
    };
}

shading! {
    constants {
        /// Fragments that are not more opaque than this are not drawn, boxes excepted: rviz rejects alphas that round
        /// to less than a 255th.
        const MAX_REJECTED_ALPHA = 0.5 / 255.0;

        /// A point or disc fills its square's inscribed circle: the square of that one's radius.
        const DISC_RADIUS_SQUARED = 0.25;

        /// The brightness that a disc (`Style: Spheres`) would lose at a whole side from its middle; at its rim it has
        /// lost a fifth.
        const DISC_FALLOFF = 0.8;

        /// A square's edge is there in full from this place on …
        const EDGE_FROM = 0.48;

        /// … and begins this much nearer to the middle.
        const EDGE_SOFTNESS = 0.03;

        /// The edge of a square or tile is lighter or darker than its inside by this.
        const EDGE_CONTRAST = 0.2;

        /// A colour is dark, and has a lighter edge, where red, green and blue as a vector are shorter than this.
        const DARK_LENGTH = 0.5;

        /// The edge of a box's side is this bright …
        const BOX_EDGE_BRIGHTNESS = 0.5;

        /// … and its inside brighter by this.
        const BOX_INSIDE_ADDS = 1.0 - BOX_EDGE_BRIGHTNESS;
    }

    formulas {
        /// The share of a place on a square that is in its inside along one axis: 1 inside, 0 on the edge, smooth
        /// between.
        fn inside_along(from_middle) {
            let t = clamp((EDGE_FROM - abs(from_middle)) * (1.0 / EDGE_SOFTNESS), 0.0, 1.0);
            return t * t * (3.0 - t * 2.0);
        }

        /// As [`inside_along`] for both axes.
        fn inside(u, v) {
            return inside_along(u) * inside_along(v);
        }

        /// By how much the edge of a square of this colour (0 to 1) differs from its inside.
        fn edge_contrast(r, g, b) {
            return sign(DARK_LENGTH - sqrt(r * r + g * g + b * b)) * EDGE_CONTRAST;
        }

        /// A channel of a square or tile, given its own value, the [`edge_contrast`] and [`inside`].
        fn with_edge(channel, contrast, is_inside) {
            return channel + (1.0 - is_inside) * contrast;
        }

        /// The brightness of a box's side at a place, given [`inside`].
        fn box_brightness(is_inside) {
            return BOX_EDGE_BRIGHTNESS + is_inside * BOX_INSIDE_ADDS;
        }

        /// The brightness of a disc (`Style: Spheres`), given the squared distance from its middle.
        fn disc_brightness(distance_squared) {
            return 1.0 - distance_squared * DISC_FALLOFF;
        }

        /// The light that falls on a surface, given the scalar product of its normal and the unit vector to the light,
        /// and the normal's length. None on the side turned away.
        fn light_on_surface(normal_dot_light, normal_length) {
            return max(normal_dot_light / normal_length, 0.0);
        }

        /// A channel of a lit surface. rviz's light is white and diffuse: there is no ambient and no specular part.
        fn lit_channel(emissive, diffuse, light) {
            return clamp(emissive + diffuse * light, 0.0, 1.0);
        }
    }
}

/// Brightness of a box's sides that face along +x, +y, +z.
pub(crate) const BOX_SIDES_ALONG: [f32; 3] = [0.6, 0.4, 0.9];

/// Brightness of a box's sides that face along −x, −y, −z.
pub(crate) const BOX_SIDES_AGAINST: [f32; 3] = [0.6, 1.0, 0.5];

/// OpenGL draws no smaller point than this, in pixels.
pub(crate) const MIN_POINT_SIZE_PX: f32 = 1.0;

/// The diameter in pixels with which a point of `Style: Points` is drawn.
///
/// rviz hands its size to `gl_PointSize`, which OpenGL brings into the range that the driver has: a point below one
/// pixel is drawn as one of one pixel, and so is a size of zero, a negative one, and NaN.
#[expect(clippy::manual_clamp, reason = "clamp keeps NaN, which is no size")]
pub(crate) fn drawn_point_size_px(size_px: f32) -> f32 {
    size_px.max(MIN_POINT_SIZE_PX).min(MAX_POINT_SIZE_PX)
}

/// How far the squared length of an axis of an object may be off 1 before Ogre takes the object for scaled.
const SCALE_TOLERANCE: f64 = 1e-4;

/// True if OpenGL brings an object's normals to unit length. Ogre asks for that where the object is scaled.
pub(crate) fn normalizes_normals(fixed_from_object: &Matrix3<f64>) -> bool {
    fixed_from_object.column_iter().any(|axis| (axis.norm_squared() - 1.0).abs() > SCALE_TOLERANCE)
}

/// The matrix that takes an object's normals to the view frame: the inverse transpose of that for its places. An object
/// that is flattened has no inverse; OpenGL (Mesa) then leaves its normals as they are.
pub(crate) fn view_from_normal(view_from_object: &Matrix4<f64>) -> Matrix3<f32> {
    let linear: Matrix3<f64> = view_from_object.fixed_view::<3, 3>(0, 0).into_owned();
    linear.try_inverse().map_or_else(Matrix3::identity, |inverse| inverse.transpose()).cast()
}

/// The unit vector to the light in a camera's view frame; `None` without a light.
pub(crate) fn to_light(camera: &Camera, light: Option<&DirectionalLight>) -> Option<Vector3<f32>> {
    let direction = camera.fixed_from_view().rotation.inverse() * -light?.direction;
    direction.try_normalize(0.0).map(|unit| unit.cast())
}

/// A shader with the constants and formulas in front of it.
pub(crate) fn with_shading(shader: &str) -> String {
    let mut wgsl = wgsl();
    for (name, [x, y, z]) in [("BOX_SIDES_ALONG", BOX_SIDES_ALONG), ("BOX_SIDES_AGAINST", BOX_SIDES_AGAINST)] {
        // Writing to a string does not fail.
        let _ = writeln!(wgsl, "const {name}: vec3f = vec3f({x:?}, {y:?}, {z:?});");
    }
    wgsl + shader
}

fn push_constant(wgsl: &mut String, name: &str, value: &str) {
    let _ = writeln!(wgsl, "const {name}: f32 = {value};");
}

fn push_function(wgsl: &mut String, name: &str, arguments: &[&str], body: &str) {
    let arguments: Vec<String> = arguments.iter().map(|argument| format!("{argument}: f32")).collect();
    let _ = writeln!(wgsl, "fn {name}({}) -> f32 {{ {body} }}", arguments.join(", "));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_begins_at_its_place_and_is_half_there_in_its_middle() {
        assert_eq!([0.0, 0.4499, -0.4499].map(inside_along), [1.0; 3]);
        assert_eq!([0.48, -0.49, 0.5].map(inside_along), [0.0; 3]);
        assert!((inside(0.465, 0.0) - 0.5).abs() < 1e-4 && (inside(0.465, -0.465) - 0.25).abs() < 1e-4);
    }

    #[test]
    fn dark_colours_have_lighter_edges_and_light_ones_darker_edges() {
        assert_eq!((edge_contrast(0.1, 0.2, 0.3), edge_contrast(0.5, 0.5, 0.5)), (0.2, -0.2));
        assert_eq!(edge_contrast(0.5, 0.0, 0.0), 0.0);
        assert_eq!((with_edge(0.1, 0.2, 0.0), with_edge(0.1, 0.2, 1.0)), (0.3, 0.1));
    }

    #[test]
    fn a_disc_has_lost_a_fifth_of_its_brightness_at_its_rim() {
        assert_eq!(disc_brightness(0.0), 1.0);
        assert!((disc_brightness(DISC_RADIUS_SQUARED) - 0.8).abs() < 1e-6);
    }

    #[test]
    fn the_edge_of_a_boxs_side_is_half_as_bright() {
        assert_eq!((box_brightness(1.0), box_brightness(0.0)), (1.0, 0.5));
    }

    #[test]
    fn light_falls_on_the_side_that_is_turned_to_it() {
        assert_eq!((light_on_surface(1.2, 2.0), light_on_surface(-1.2, 2.0)), (0.6, 0.0));
        assert_eq!((lit_channel(0.25, 0.5, 0.5), lit_channel(0.75, 1.0, 0.5)), (0.5, 1.0));
    }

    #[test]
    fn points_are_drawn_within_the_sizes_that_opengl_has() {
        let drawn = [-2.0, 0.0, 0.3, 1.0, 1.5, 254.0, 300.0, f32::INFINITY, f32::NAN].map(drawn_point_size_px);
        assert_eq!(drawn, [1.0, 1.0, 1.0, 1.0, 1.5, 254.0, 255.0, 255.0, 1.0]);
    }

    #[test]
    fn the_shaders_are_given_the_constants_and_formulas() {
        let wgsl = with_shading("// the shader");
        for line in [
            "const DISC_FALLOFF: f32 = 0.8;",
            "const BOX_SIDES_ALONG: vec3f = vec3f(0.6, 0.4, 0.9);",
            "fn disc_brightness(distance_squared: f32) -> f32 { return 1.0 - distance_squared * DISC_FALLOFF; }",
            "// the shader",
        ] {
            assert!(wgsl.contains(line), "{line} is not in\n{wgsl}");
        }
    }
}
