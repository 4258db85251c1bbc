//! Drawables of a display's last messages ("Buffer Length" or "History Length").

use std::collections::VecDeque;

use rcs_scene::Drawable;

#[derive(Debug)]
pub(crate) struct MessageHistory {
    length: usize,
    counts: VecDeque<usize>,
    /// Always contiguous.
    drawables: VecDeque<Drawable>,
}

impl MessageHistory {
    /// Keeps `length` messages, at least one; `None` keeps all.
    pub(crate) fn new(length: Option<u32>) -> Self {
        let length = length.map_or(usize::MAX, |length| length.max(1) as usize);
        Self { length, counts: VecDeque::new(), drawables: VecDeque::new() }
    }

    /// Adds the drawables of a message, and drops the oldest message where there are too many.
    pub(crate) fn push(&mut self, drawables: impl IntoIterator<Item = Drawable>) {
        if self.counts.len() >= self.length {
            let oldest = self.counts.pop_front().unwrap_or_default();
            self.drawables.drain(..oldest);
        }
        let before = self.drawables.len();
        self.drawables.extend(drawables);
        self.counts.push_back(self.drawables.len() - before);
        self.drawables.make_contiguous();
    }

    /// Drawables of all messages, oldest first.
    pub(crate) fn drawables(&self) -> &[Drawable] {
        self.drawables.as_slices().0
    }

    /// Drawables that the next message will replace: those of the oldest one once the history is full.
    pub(crate) fn next_to_go(&self) -> &[Drawable] {
        let count = self.counts.front().filter(|_| self.counts.len() >= self.length).copied().unwrap_or_default();
        &self.drawables()[..count]
    }

    pub(crate) fn clear(&mut self) {
        self.counts.clear();
        self.drawables.clear();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::Matrix4;
    use rcs_scene::{Material, Rgba};

    use super::*;
    use crate::parts::solids::solid;
    use crate::SolidShape;

    /// Adds messages of so many drawables, each of which has the message's number, and returns the numbers that are
    /// left.
    fn shown(length: Option<u32>, counts: &[u32]) -> Vec<u32> {
        let material = Arc::new(Material::lit(Rgba::from_rgb8([255; 3], 1.0)));
        let mut history = MessageHistory::new(length);
        for (number, &count) in (0..).zip(counts) {
            history.push((0..count).map(|_| solid(number, SolidShape::Cube, Matrix4::identity(), &material)));
        }
        history.drawables().iter().map(|drawable| drawable.display).collect()
    }

    #[test]
    fn the_last_messages_stay_whatever_each_is_drawn_with() {
        let counts = [1, 2, 0, 3, 1];
        assert_eq!(shown(Some(1), &counts), [4]);
        assert_eq!(shown(Some(0), &counts), [4], "at least one stays");
        assert_eq!(shown(Some(3), &counts), [3, 3, 3, 4]);
        assert_eq!(shown(Some(4), &counts), [1, 1, 3, 3, 3, 4]);
        assert_eq!(shown(None, &counts), [0, 1, 1, 3, 3, 3, 4]);
        assert_eq!(shown(Some(1), &[2, 0]), [0_u32; 0]);
    }

    #[test]
    fn the_next_to_go_is_the_oldest_message_once_there_are_as_many_as_are_kept() {
        let material = Arc::new(Material::lit(Rgba::from_rgb8([255; 3], 1.0)));
        let mut history = MessageHistory::new(Some(2));
        let mut next = Vec::new();
        for (number, count) in [(0, 2), (1, 1), (2, 0), (3, 1)] {
            next.push(history.next_to_go().iter().map(|drawable| drawable.display).collect::<Vec<_>>());
            history.push((0..count).map(|_| solid(number, SolidShape::Cube, Matrix4::identity(), &material)));
        }
        assert_eq!(next, [vec![], vec![], vec![0, 0], vec![1]]);
    }
}
