//! The bytes of a message's points, with parallel access to those that are shown.

/// Points of a share of the parallel work, so that small clouds are not spread over cores.
pub const POINTS_PER_SHARE: usize = 8192;

/// Offsets of a point's position in its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionLayout {
    offsets: [usize; 3],
    /// x, y and z are consecutive.
    is_plain: bool,
}

impl PositionLayout {
    /// Layout of little-endian 32-bit floats at the offsets of x, y and z.
    pub fn new(offsets: [usize; 3]) -> Self {
        let [x, y, z] = offsets;
        Self { offsets, is_plain: Some(y) == x.checked_add(4) && Some(z) == x.checked_add(8) }
    }

    /// Offset of x if y and z follow it.
    pub fn plain_offset(&self) -> Option<usize> {
        self.is_plain.then_some(self.offsets[0])
    }

    /// Position of a point in metres, from the point's bytes.
    #[inline(always)]
    pub fn in_point(&self, point: &[u8]) -> [f32; 3] {
        let [x, y, z] = self.offsets;
        if self.is_plain {
            let [x, y, z] = bytemuck::cast::<[u8; 12], [u32; 3]>(bytes_at(point, x));
            [little_endian(x), little_endian(y), little_endian(z)]
        } else {
            [x, y, z].map(|offset| f32::from_le_bytes(bytes_at(point, offset)))
        }
    }
}

#[inline(always)]
fn little_endian(bits: u32) -> f32 {
    f32::from_bits(u32::from_le(bits))
}

/// `N` bytes at an offset; zeros past the end.
#[inline(always)]
pub fn bytes_at<const N: usize>(point: &[u8], offset: usize) -> [u8; N] {
    point.get(offset..offset + N).and_then(|bytes| bytes.try_into().ok()).unwrap_or([0; N])
}

/// `true` if all coordinates are finite.
#[inline(always)]
pub fn has_finite_position([x, y, z]: &[f32; 3]) -> bool {
    x.is_finite() & y.is_finite() & z.is_finite()
}

/// Bytes of a cloud's visible points.
#[derive(Clone, Copy, Debug)]
pub struct PointBytes<'a> {
    /// All points, one after the other.
    pub data: &'a [u8],
    /// Bytes of a point; not 0.
    pub point_step: usize,
    /// Layout of a point's position.
    pub positions: PositionLayout,
    /// Number of visible points of each share of [`POINTS_PER_SHARE`]: those with a finite position.
    pub shown: &'a [usize],
    /// `true` if all points are visible.
    pub is_all_shown: bool,
}

impl PointBytes<'_> {
    /// Number of visible points.
    pub fn count(&self) -> usize {
        self.shown.iter().sum()
    }

    /// Maps each visible point, in order and on all cores.
    pub fn map<T: Clone + Default + Send>(&self, compute: impl Fn(&[u8]) -> T + Sync) -> Vec<T> {
        let mut mapped = vec![T::default(); self.count()];
        let compute_share = |points: &[u8], out: &mut [T]| {
            let points = points.chunks_exact(self.point_step);
            if self.is_all_shown {
                out.iter_mut().zip(points).for_each(|(out, point)| *out = compute(point));
            } else {
                let shown = points.filter(|point| has_finite_position(&self.positions.in_point(point)));
                out.iter_mut().zip(shown).for_each(|(out, point)| *out = compute(point));
            }
        };
        in_shares(self.shown, self.data, POINTS_PER_SHARE * self.point_step, &mut mapped, &compute_share);
        mapped
    }
}

/// Runs `work` on shares of `data`, each `share_len` bytes long but the last, and on their parts of `out`, whose
/// lengths are `lens`.
fn in_shares<T: Send>(
    lens: &[usize],
    data: &[u8],
    share_len: usize,
    out: &mut [T],
    work: &(impl Fn(&[u8], &mut [T]) + Sync),
) {
    if lens.len() <= 1 {
        work(data, out);
        return;
    }
    let (lens_a, lens_b) = lens.split_at(lens.len() / 2);
    let (data_a, data_b) = data.split_at((lens_a.len() * share_len).min(data.len()));
    let (out_a, out_b) = out.split_at_mut(lens_a.iter().sum::<usize>().min(out.len()));
    rayon::join(
        || in_shares(lens_a, data_a, share_len, out_a, work),
        || in_shares(lens_b, data_b, share_len, out_b, work),
    );
}
