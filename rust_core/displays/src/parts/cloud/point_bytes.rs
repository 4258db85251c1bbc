//! The bytes of a cloud's points, with parallel access to those that are shown.

use rcs_messages::PointCloud2;

use super::fields::{bytes_at, CloudLayout};

/// Points of a share of the parallel work, so that small clouds are not spread over cores.
pub(super) const SHARE: usize = 8192;

/// Offsets of a point's position in its bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct PositionLayout {
    offsets: [usize; 3],
    /// x, y and z are consecutive and little endian.
    is_plain: bool,
    is_big_endian: bool,
}

impl PositionLayout {
    pub(super) fn of(cloud: &PointCloud2, layout: &CloudLayout) -> Self {
        let offsets = layout.position.each_ref().map(|channel| channel.offset);
        let is_triple = layout.position_triple().is_some();
        Self { offsets, is_plain: is_triple && !cloud.is_bigendian, is_big_endian: cloud.is_bigendian }
    }

    #[inline(always)]
    pub(super) fn in_point(&self, point: &[u8]) -> [f32; 3] {
        let [x, y, z] = self.offsets;
        if self.is_plain {
            let [x, y, z] = bytemuck::cast::<[u8; 12], [u32; 3]>(bytes_at(point, x));
            [little_endian(x), little_endian(y), little_endian(z)]
        } else {
            let read = |offset| {
                let bytes = bytes_at(point, offset);
                if self.is_big_endian {
                    f32::from_be_bytes(bytes)
                } else {
                    f32::from_le_bytes(bytes)
                }
            };
            [read(x), read(y), read(z)]
        }
    }
}

#[inline(always)]
fn little_endian(bits: u32) -> f32 {
    f32::from_bits(u32::from_le(bits))
}

/// Bytes of a cloud's visible points.
#[derive(Debug)]
pub(super) struct PointBytes<'a> {
    pub(super) data: &'a [u8],
    pub(super) point_step: usize,
    pub(super) positions: PositionLayout,
    /// Number of visible points of each share: those with a finite position.
    pub(super) shown: &'a [usize],
    pub(super) is_all_shown: bool,
}

impl PointBytes<'_> {
    pub(super) fn len(&self) -> usize {
        self.shown.iter().sum()
    }

    /// Maps each point, in order and on all cores. `out` has as many elements as there are points.
    pub(super) fn map<T: Send>(&self, out: &mut [T], compute: impl Fn(&[u8]) -> T + Sync) {
        let compute_share = |points: &[u8], out: &mut [T]| {
            let points = points.chunks_exact(self.point_step);
            if self.is_all_shown {
                out.iter_mut().zip(points).for_each(|(out, point)| *out = compute(point));
            } else {
                let shown = points.filter(|point| has_finite_position(&self.positions.in_point(point)));
                out.iter_mut().zip(shown).for_each(|(out, point)| *out = compute(point));
            }
        };
        in_shares(self.shown, self.data, SHARE * self.point_step, out, &compute_share);
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

#[inline(always)]
pub(super) fn has_finite_position([x, y, z]: &[f32; 3]) -> bool {
    x.is_finite() & y.is_finite() & z.is_finite()
}
