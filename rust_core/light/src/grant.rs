//! Grants of light, and content with its grant.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_render::{LightMask, PostProcess};
use rcs_scene::{Encoding, Image};

/// Duration of the grant of a tool that a person runs at the projector.
const TOOL_LIMIT: Duration = Duration::from_secs(86_400);

/// The generation of the operator's words and the config. Clones are of the moment; each is void after the next
/// [`advance`](Self::advance) of any of them.
#[derive(Clone, Debug, Default)]
pub struct Generation {
    counter: Arc<AtomicU64>,
    number: u64,
}

impl Generation {
    /// Voids all grants so far.
    pub fn advance(&mut self) {
        self.number = self.counter.fetch_add(1, Ordering::AcqRel) + 1;
    }

    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.counter, &other.counter) && self.number == other.number
    }

    fn is_current(&self) -> bool {
        self.counter.load(Ordering::Acquire) == self.number
    }
}

/// The allowed light at each pixel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GrantedLight {
    /// Width and height of the images before they are turned.
    pub(crate) size_px: [u32; 2],
    /// Post-processing: masks, keep-out frames, orientation.
    pub(crate) post: Arc<PostProcess>,
    /// `true`: nothing is lit before [`Grant::confirm`].
    pub(crate) must_confirm: bool,
}

/// Permission to light content of one size: until when, of which generation, and how much at each pixel.
#[derive(Clone, Debug)]
pub struct Grant {
    until: Instant,
    generation: Generation,
    light: GrantedLight,
}

impl Grant {
    pub(crate) fn new(until: Instant, generation: Generation, light: GrantedLight) -> Self {
        Self { until, generation, light }
    }

    /// The grant of a tool that shows its own images, such as a crosshair: a person runs it at the projector.
    pub fn of_tool() -> Self {
        let light = GrantedLight { size_px: [0, 0], post: Arc::default(), must_confirm: false };
        Self::new(Instant::now() + TOOL_LIMIT, Generation::default(), light)
    }

    /// `true` while content may be shown.
    pub fn is_valid(&self, now: Instant) -> bool {
        now < self.until && self.generation.is_current()
    }

    /// End of the grant, if it does not become void before.
    pub fn until(&self) -> Instant {
        self.until
    }

    /// The grant with an earlier end.
    #[must_use]
    pub fn until_at_most(self, until: Instant) -> Self {
        Self { until: self.until.min(until), ..self }
    }

    /// Post-processing of images.
    pub fn post(&self) -> &Arc<PostProcess> {
        &self.light.post
    }

    /// `true` if both are of one generation and allow the same light at each pixel.
    pub fn allows_the_same(&self, other: &Self) -> bool {
        self.generation.is_same(&other.generation) && self.light == other.light
    }

    /// Allows only light that is confirmed: 255 in this mask. `None`, or a mask of another size, confirms nothing.
    #[must_use]
    pub fn confirm(mut self, mask: Option<Arc<LightMask>>) -> Self {
        let mask = mask.filter(|mask| mask.size_px() == self.light.size_px);
        if self.light.must_confirm {
            self.light.post = Arc::new(PostProcess { confirmed: mask, ..PostProcess::clone(&self.light.post) });
        }
        self
    }

    /// `true` if a surface must confirm the light and nothing did so far.
    pub fn is_unconfirmed(&self) -> bool {
        self.light.must_confirm && self.light.post.confirmed.is_none()
    }

    /// Post-processes an image: what is not allowed becomes dark, and it is turned. `None` for one of another size or
    /// without confirmation: it is not to be shown.
    pub fn light(self, mut image: Image, scratch: &mut Image) -> Option<Lit<Arc<Image>>> {
        if self.is_unconfirmed() || [image.width_px, image.height_px] != self.light.size_px {
            return None;
        }
        self.light.post.apply(&mut image, scratch);
        Some(Lit { content: Arc::new(image), grant: self })
    }

    /// Darkens what is not allowed in an image that stands on the projector as it is, and so is not turned. `None` as
    /// for [`light`](Self::light).
    pub fn light_turned(self, mut image: Image) -> Option<Lit<Arc<Image>>> {
        let shown_px = [image.width_px, image.height_px];
        if self.is_unconfirmed() || shown_px != self.light.post.orientation.size_px(self.light.size_px) {
            return None;
        }
        let allowed = LightMask::new(shown_px, self.allowed().data)?;
        let dim = PostProcess { masks: vec![Arc::new(allowed)], ..PostProcess::default() };
        dim.apply(&mut image, &mut Image::default());
        Some(Lit { content: Arc::new(image), grant: self })
    }

    /// Content of any kind, where the grant allows all light at each pixel; `None` where it does not.
    pub fn show<T>(self, content: T) -> Option<Lit<T>> {
        let has_no_limit = *self.light.post == PostProcess::default() && !self.light.must_confirm;
        has_no_limit.then_some(Lit { content, grant: self })
    }

    /// The share of light that is allowed at each pixel of the turned image: mono8, 255 for all.
    pub fn allowed(&self) -> Image {
        let mut allowed = Image::default();
        allowed.reset(self.light.size_px[0], self.light.size_px[1], Encoding::Mono8);
        allowed.data.fill(if self.is_unconfirmed() { 0 } else { u8::MAX });
        // Blending is no mask.
        let post = PostProcess { blend: None, ..PostProcess::clone(&self.light.post) };
        post.apply(&mut allowed, &mut Image::default());
        allowed
    }
}

impl<T> Lit<Arc<T>> {
    /// `true` if both are one content, not only an equal one.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.content, &other.content)
    }
}

impl Lit<Arc<Image>> {
    /// Width and height.
    pub fn size_px(&self) -> [u32; 2] {
        [self.content.width_px, self.content.height_px]
    }

    /// Encoding of the image.
    pub fn encoding(&self) -> Encoding {
        self.content.encoding
    }
}

/// Content with the grant under which it may be shown.
#[derive(Clone, Debug)]
pub struct Lit<T> {
    content: T,
    grant: Grant,
}

impl<T> Lit<T> {
    /// The content while it may be shown.
    pub fn content(&self, now: Instant) -> Option<&T> {
        self.grant.is_valid(now).then_some(&self.content)
    }

    /// The grant.
    pub fn grant(&self) -> &Grant {
        &self.grant
    }

    /// Takes a later grant, if it allows the same light at each pixel. Returns `true` if so.
    pub fn renew(&mut self, grant: &Grant) -> bool {
        let is_same = self.grant.allows_the_same(grant);
        if is_same {
            self.grant = grant.clone();
        }
        is_same
    }

    /// Converts the content, which keeps its grant.
    ///
    /// # Errors
    /// Those of `convert`.
    pub fn convert<U, E>(&self, convert: impl FnOnce(&T) -> Result<U, E>) -> Result<Lit<U>, E> {
        Ok(Lit { content: convert(&self.content)?, grant: self.grant.clone() })
    }

    /// The content for its memory: to be drawn over, not to be shown.
    pub fn into_memory(self) -> T {
        self.content
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(size_px: [u32; 2], levels: &[u8]) -> Option<Arc<LightMask>> {
        LightMask::new(size_px, levels.to_vec()).map(Arc::new)
    }

    /// A grant for a second, of images of 2 × 1 pixels.
    fn grant(now: Instant, post: PostProcess, must_confirm: bool) -> Grant {
        let light = GrantedLight { size_px: [2, 1], post: Arc::new(post), must_confirm };
        Grant::new(now + Duration::from_secs(1), Generation::default(), light)
    }

    fn white([width_px, height_px]: [u32; 2]) -> Image {
        let mut image = Image::default();
        image.reset(width_px, height_px, Encoding::Mono8);
        image.data.fill(200);
        image
    }

    fn levels(lit: Option<Lit<Arc<Image>>>, now: Instant) -> Option<Vec<u8>> {
        lit.map(|lit| lit.content(now).unwrap().data.clone())
    }

    #[test]
    fn content_is_shown_until_the_end_and_not_after_another_word() {
        let (now, mut generation) = (Instant::now(), Generation::default());
        let grant = Grant { generation: generation.clone(), ..grant(now, PostProcess::default(), false) };
        let end = now + Duration::from_secs(1);
        assert!(grant.is_valid(now) && !grant.is_valid(end));
        let lit = grant.clone().show(7).unwrap();
        assert_eq!([lit.content(now), lit.content(end)], [Some(&7), None]);
        let early = grant.clone().until_at_most(now + Duration::from_millis(10));
        assert_eq!(early.until(), now + Duration::from_millis(10));
        assert_eq!(early.until_at_most(end).until(), now + Duration::from_millis(10), "never a later one");
        generation.advance();
        assert!(!grant.is_valid(now) && lit.content(now).is_none());
    }

    #[test]
    fn a_later_grant_counts_if_it_is_of_the_same_light_and_generation() {
        let (now, mut generation) = (Instant::now(), Generation::default());
        let of = |generation: &Generation, post, secs| {
            let grant = grant(now, post, false);
            Grant { generation: generation.clone(), until: now + Duration::from_secs(secs), ..grant }
        };
        let mut lit = of(&generation, PostProcess::default(), 1).show(()).unwrap();
        assert!(lit.renew(&of(&generation, PostProcess::default(), 3)));
        assert!(lit.content(now + Duration::from_secs(2)).is_some());
        let masked = PostProcess { masks: mask([2, 1], &[255, 0]).into_iter().collect(), ..PostProcess::default() };
        assert!(
            !lit.renew(&of(&generation, masked, 9))
                && !lit.renew(&of(&Generation::default(), PostProcess::default(), 9))
        );
        generation.advance();
        assert!(!lit.renew(&of(&generation, PostProcess::default(), 9)));
        assert!(lit.content(now + Duration::from_secs(4)).is_none());
    }

    #[test]
    fn light_that_must_be_confirmed_is_dark_without_a_mask_of_its_size() {
        let now = Instant::now();
        let light = |grant: Grant| levels(grant.light(white([2, 1]), &mut Image::default()), now);
        let unconfirmed = grant(now, PostProcess::default(), true);
        assert!(unconfirmed.is_unconfirmed() && unconfirmed.allowed().data == [0, 0]);
        assert!(light(unconfirmed.clone()).is_none() && unconfirmed.clone().light_turned(white([2, 1])).is_none());
        assert!(unconfirmed.clone().show(()).is_none());
        for wrong in [None, mask([1, 1], &[255]), mask([4, 2], &[255; 8])] {
            assert!(light(unconfirmed.clone().confirm(wrong)).is_none());
        }
        let confirmed = unconfirmed.confirm(mask([2, 1], &[0, 255]));
        assert!(!confirmed.is_unconfirmed() && confirmed.allowed().data == [0, 255]);
        assert_eq!(light(confirmed.clone()), Some(vec![0, 200]));
        assert!(light(confirmed.confirm(None)).is_none(), "the last check counts");
        let free = grant(now, PostProcess::default(), false).confirm(mask([2, 1], &[0, 0]));
        assert_eq!(light(free), Some(vec![200, 200]), "nothing has to be confirmed");
    }

    #[test]
    fn a_image_of_another_size_is_not_lit() {
        let now = Instant::now();
        for wrong in [[1, 1], [2, 2], [1, 2]] {
            let grant = || grant(now, PostProcess::default(), false);
            assert!(grant().light(white(wrong), &mut Image::default()).is_none(), "{wrong:?}");
            assert!(grant().light_turned(white(wrong)).is_none(), "{wrong:?}");
        }
    }

    #[test]
    fn masks_darken_scenes_before_they_are_turned_and_test_images_after() {
        let now = Instant::now();
        let masks = mask([2, 1], &[255, 0]).into_iter().collect();
        let post = PostProcess { masks, orientation: "90".parse().unwrap(), ..PostProcess::default() };
        let grant = grant(now, post, false);
        let lit = grant.clone().light(white([2, 1]), &mut Image::default()).unwrap();
        assert_eq!((lit.size_px(), lit.encoding()), ([1, 2], Encoding::Mono8));
        assert_eq!(levels(Some(lit), now), Some(vec![200, 0]));
        assert_eq!(grant.allowed().data, [255, 0]);
        assert!(grant.clone().light_turned(white([2, 1])).is_none(), "it stands on the projector as it is");
        assert_eq!(levels(grant.clone().light_turned(white([1, 2])), now), Some(vec![200, 0]));
        assert!(grant.show(()).is_none(), "its pixels are not known");
    }

    #[test]
    fn a_tool_may_show_what_it_likes() {
        let lit = Grant::of_tool().show(1).unwrap();
        assert!(lit.content(Instant::now() + Duration::from_secs(3600)).is_some());
        assert_eq!(lit.convert(|one| Ok::<_, ()>(one + 1)).unwrap().into_memory(), 2);
    }
}
