//! The order in which opaque faces are drawn by their ranks: from near to far.
//!
//! The order of opaque faces that follow each other matters only for equal depths, so that they may come in any
//! order if each pixel knows the *rank* of the face that it shows: its place in the order of drawing. Of faces that lie
//! over each other a thousandfold the near ones come first, and of equally near ones the last: after a few of them each
//! part of the image is covered, and [hierarchical z](super::hiz) hides the others.

use super::screen::Screen;

/// Neighbouring faces of a list that are drawn one after the other: their memory comes together.
const CHUNK: usize = 8;

/// Faces in the order of drawing, by chunks.
#[derive(Debug, Default)]
pub(in crate::cpu) struct NearToFar {
    chunks: Vec<Chunk>,
}

#[derive(Clone, Copy, Debug)]
struct Chunk {
    /// How near its nearest face is.
    nearness: f32,
    /// The rank of its first face, from 0 on.
    rank: u32,
    job: u32,
    /// The place of its first face in the job's list.
    begin: u32,
}

/// A face in a list of its job.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct RankedFace {
    /// The job.
    pub job: usize,
    /// The list's entry.
    pub number: u32,
    /// The rank, from 0 on.
    pub rank: u32,
}

impl NearToFar {
    /// Sorts the faces that each job lists, by numbers that are smaller for what is nearer. Returns the number of
    /// ranks.
    pub(in crate::cpu) fn sort(&mut self, lists: &[&[u32]], nearness: impl Fn(usize, u32) -> f32) -> usize {
        self.chunks.clear();
        let mut rank = 0;
        for (job, list) in lists.iter().enumerate() {
            for (chunk, begin) in list.chunks(CHUNK).zip((0..).step_by(CHUNK)) {
                let nearest = chunk.iter().fold(f32::INFINITY, |least, &number| least.min(nearness(job, number)));
                self.chunks.push(Chunk { nearness: nearest, rank, job: job as u32, begin });
                rank += chunk.len() as u32;
            }
        }
        self.chunks.sort_unstable_by(|a, b| a.nearness.total_cmp(&b.nearness).then(b.rank.cmp(&a.rank)));
        rank as usize
    }

    /// The sorted faces. Of neighbours, too, the last comes first.
    pub(in crate::cpu) fn faces<'s>(&'s self, lists: &'s [&[u32]]) -> impl Iterator<Item = RankedFace> + 's {
        self.chunks.iter().flat_map(|&Chunk { rank, job, begin, .. }| {
            let list = lists.get(job as usize).and_then(|list| list.get(begin as usize..)).unwrap_or(&[]);
            let numbers = list.iter().take(CHUNK).enumerate().rev();
            numbers.map(move |(i, &number)| RankedFace { job: job as usize, number, rank: rank + i as u32 })
        })
    }
}

/// The amount that a job has to draw.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cpu) struct Load {
    /// Pixels, counted as often as they are covered; about.
    pub pixels: u64,
    /// Faces.
    pub faces: u64,
    /// Some have to be drawn in their order.
    pub in_order: bool,
}

impl Load {
    /// True if faces of some size lie over each other many times.
    pub(in crate::cpu) fn is_heavy(&self, screen: &Screen) -> bool {
        const MANY_TIMES: u64 = 16;
        const FACE_PX: u64 = 256;
        let image_px = u64::from(screen.width_px) * u64::from(screen.height_px);
        self.pixels > MANY_TIMES * image_px && self.pixels > FACE_PX * self.faces
    }

    /// Both.
    pub(in crate::cpu) fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            faces: self.faces + other.faces,
            in_order: self.in_order || other.in_order,
        }
    }
}
