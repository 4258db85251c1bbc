//! Keys that a window reports, by the symbols of the keyboard's layout. Escape and q are not among them: they end the
//! window.

use xkeysym::{key, Keysym};

/// A key that was pressed, or is held down and repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowKey {
    /// The space bar.
    Space,
    /// Return or Enter.
    Enter,
    /// Backspace.
    Backspace,
    /// Tab.
    Tab,
    /// Arrow left.
    Left,
    /// Arrow right.
    Right,
    /// Arrow up.
    Up,
    /// Arrow down.
    Down,
    /// Page up.
    PageUp,
    /// Page down.
    PageDown,
    /// Home.
    Home,
    /// End.
    End,
    /// A key with a character; a capital letter if shift is held.
    Character(char),
}

impl WindowKey {
    /// The key of a symbol; `None` for other symbols.
    pub(crate) fn from_keysym(keysym: Keysym) -> Option<Self> {
        Some(match keysym.raw() {
            key::space | key::KP_Space => Self::Space,
            key::Return | key::KP_Enter => Self::Enter,
            key::BackSpace => Self::Backspace,
            key::Tab => Self::Tab,
            key::Left | key::KP_Left => Self::Left,
            key::Right | key::KP_Right => Self::Right,
            key::Up | key::KP_Up => Self::Up,
            key::Down | key::KP_Down => Self::Down,
            key::Prior | key::KP_Prior => Self::PageUp,
            key::Next | key::KP_Next => Self::PageDown,
            key::Home | key::KP_Home => Self::Home,
            key::End | key::KP_End => Self::End,
            _ => Self::Character(keysym.key_char().filter(|character| !character.is_control())?),
        })
    }
}

/// `true` for a key that ends the window.
pub(crate) fn is_quit_key(keysym: Keysym) -> bool {
    matches!(keysym.raw(), key::Escape | key::q | key::Q)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escape_and_q_quit_and_nothing_else() {
        for symbol in [key::Escape, key::q, key::Q] {
            assert!(is_quit_key(Keysym::new(symbol)));
        }
        for symbol in [key::w, key::Return, key::space] {
            assert!(!is_quit_key(Keysym::new(symbol)));
        }
    }

    #[test]
    fn keys_with_a_character_and_some_others_are_reported() {
        let named = |symbol| WindowKey::from_keysym(Keysym::new(symbol));
        assert_eq!(named(key::n), Some(WindowKey::Character('n')));
        assert_eq!(named(key::N), Some(WindowKey::Character('N')));
        assert_eq!(named(key::udiaeresis), Some(WindowKey::Character('ü')));
        assert_eq!(named(key::space), Some(WindowKey::Space));
        assert_eq!(named(key::KP_Enter), Some(WindowKey::Enter));
        assert_eq!(named(key::Left), Some(WindowKey::Left));
        assert_eq!(named(key::F1), None);
        assert_eq!(named(key::Shift_L), None);
    }
}
