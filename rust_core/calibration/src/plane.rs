//! Planes through the values of a window of pixels, by weighted least squares.

/// A plane a = at + by_x · x + by_y · y.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// The height in the middle.
    pub(crate) at: f32,
    pub(crate) by_x: f32,
    pub(crate) by_y: f32,
    /// Mean squared distance from the plane.
    pub(crate) variance: f32,
    /// The weight that it rests on.
    pub(crate) support: f32,
}

impl Plane {
    /// No plane.
    pub(crate) const NONE: Self = Self { at: 0.0, by_x: 0.0, by_y: 0.0, variance: f32::INFINITY, support: 0.0 };
}

/// Weighted sums over a window; coordinates are relative to its middle.
#[derive(Default, Clone, Copy)]
pub(crate) struct Sums {
    one: f32,
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
    yy: f32,
    a: f32,
    ax: f32,
    ay: f32,
    aa: f32,
}

impl Sums {
    /// Adds a pixel of height `a`.
    pub(crate) fn add(&mut self, weight: f32, x: f32, y: f32, a: f32) {
        let (wx, wy, wa) = (weight * x, weight * y, weight * a);
        self.one += weight;
        self.x += wx;
        self.y += wy;
        self.xx += wx * x;
        self.xy += wx * y;
        self.yy += wy * y;
        self.a += wa;
        self.ax += wa * x;
        self.ay += wa * y;
        self.aa += wa * a;
    }

    /// The plane of least squares through the window; none if it weighs less than this, or lies on a line.
    pub(crate) fn plane(&self, least_weight: f32) -> Option<Plane> {
        if self.one < least_weight {
            return None;
        }
        let (mx, my, ma) = (self.x / self.one, self.y / self.one, self.a / self.one);
        let (xx, xy) = (self.xx / self.one - mx * mx, self.xy / self.one - mx * my);
        let yy = self.yy / self.one - my * my;
        let (ax, ay) = (self.ax / self.one - ma * mx, self.ay / self.one - ma * my);
        let determinant = xx * yy - xy * xy;
        if determinant < 0.05 {
            return None;
        }
        let (by_x, by_y) = ((ax * yy - ay * xy) / determinant, (ay * xx - ax * xy) / determinant);
        let variance = (self.aa / self.one - ma * ma - by_x * ax - by_y * ay).max(0.0);
        Some(Plane { at: ma - by_x * mx - by_y * my, by_x, by_y, variance, support: self.one })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_found_again() {
        let mut sums = Sums::default();
        for y in -2_i16..=2 {
            for x in -2_i16..=1 {
                let (x, y) = (f32::from(x), f32::from(y));
                sums.add(1.0 + 0.2 * x, x, y, 7.0 + 0.5 * x - 0.25 * y);
            }
        }
        let plane = sums.plane(5.0).unwrap();
        assert!((plane.at - 7.0).abs() < 1e-4 && (plane.by_x - 0.5).abs() < 1e-4 && (plane.by_y + 0.25).abs() < 1e-4);
        assert!(plane.variance < 1e-4 && plane.support > 10.0);
        assert!(sums.plane(1000.0).is_none());
    }

    #[test]
    fn a_line_is_no_plane() {
        let mut sums = Sums::default();
        (-3_i16..=3).for_each(|x| sums.add(1.0, f32::from(x), f32::from(2 * x), 1.0));
        assert!(sums.plane(1.0).is_none());
    }
}
