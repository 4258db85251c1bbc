//! Key presses as symbols, by the X server's keyboard mapping.

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{ConnectionExt as _, KeyButMask, KeyPressEvent, KeyReleaseEvent};
use xkeysym::{KeyCode, Keysym};

use super::session::X11Session;

/// Position of the layout's number in a key event's state (X Keyboard Extension, section 2.2.2).
const GROUP_SHIFT: u16 = 13;

/// The symbols of the keys.
#[derive(Default)]
pub(super) struct Keyboard {
    first: u8,
    per_key: u8,
    keysyms: Vec<u32>,
    /// The last key that was released, and when by the server's clock.
    released: Option<(u8, u32)>,
}

impl Keyboard {
    /// The current mapping; without keys if the server does not report it.
    pub(super) fn read(session: &X11Session) -> Self {
        let setup = session.connection.setup();
        let (first, count) = (setup.min_keycode, setup.max_keycode - setup.min_keycode + 1);
        let mapping = session.connection.get_keyboard_mapping(first, count).ok().and_then(|cookie| cookie.reply().ok());
        mapping.map_or_else(Self::default, |mapping| Self {
            first,
            per_key: mapping.keysyms_per_keycode,
            keysyms: mapping.keysyms,
            released: None,
        })
    }

    /// Takes a key that was released.
    pub(super) fn release(&mut self, event: &KeyReleaseEvent) {
        self.released = Some((event.detail, event.time));
    }

    /// `true` if the key is held down: it is released and pressed again at one time.
    pub(super) fn is_repeat(&self, event: &KeyPressEvent) -> bool {
        self.released == Some((event.detail, event.time))
    }

    /// The symbol of a key press.
    pub(super) fn keysym(&self, event: &KeyPressEvent) -> Option<Keysym> {
        let state = u16::from(event.state);
        let is_shifted = state & u16::from(KeyButMask::SHIFT) != 0;
        let is_second_layout = (state >> GROUP_SHIFT) & 1 != 0;
        let column = u8::from(is_shifted) + 2 * u8::from(is_second_layout);
        // xkeysym does not check the range.
        let index = usize::from(event.detail.checked_sub(self.first)?) * usize::from(self.per_key);
        self.keysyms.get(index..index + usize::from(self.per_key))?;
        xkeysym::keysym(
            KeyCode::new(event.detail.into()),
            column,
            KeyCode::new(self.first.into()),
            self.per_key,
            &self.keysyms,
        )
    }
}
