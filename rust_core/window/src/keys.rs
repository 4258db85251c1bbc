//! The keys that a window reports, whatever the keyboard's layout: what the program does on one is its own affair.
//! Escape and q are not among them, they end the window.

use winit::keyboard::{Key, NamedKey};

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
    /// An arrow.
    Left,
    /// An arrow.
    Right,
    /// An arrow.
    Up,
    /// An arrow.
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
    /// The key as winit names it; none for others.
    pub(crate) fn from_winit(key: &Key) -> Option<Self> {
        Some(match key {
            Key::Named(NamedKey::Space) => Self::Space,
            Key::Named(NamedKey::Enter) => Self::Enter,
            Key::Named(NamedKey::Backspace) => Self::Backspace,
            Key::Named(NamedKey::Tab) => Self::Tab,
            Key::Named(NamedKey::ArrowLeft) => Self::Left,
            Key::Named(NamedKey::ArrowRight) => Self::Right,
            Key::Named(NamedKey::ArrowUp) => Self::Up,
            Key::Named(NamedKey::ArrowDown) => Self::Down,
            Key::Named(NamedKey::PageUp) => Self::PageUp,
            Key::Named(NamedKey::PageDown) => Self::PageDown,
            Key::Named(NamedKey::Home) => Self::Home,
            Key::Named(NamedKey::End) => Self::End,
            Key::Character(text) => {
                let mut characters = text.chars();
                match (characters.next(), characters.next()) {
                    (Some(' '), None) => Self::Space,
                    (Some(character), None) => Self::Character(character),
                    _ => return None,
                }
            }
            _ => return None,
        })
    }
}

/// Whether a key ends the window.
pub(crate) fn is_quit_key(key: &Key) -> bool {
    match key {
        Key::Named(NamedKey::Escape) => true,
        Key::Character(text) => text.eq_ignore_ascii_case("q"),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escape_and_q_quit_and_nothing_else() {
        assert!(is_quit_key(&Key::Named(NamedKey::Escape)));
        assert!(is_quit_key(&Key::Character("q".into())));
        assert!(is_quit_key(&Key::Character("Q".into())));
        assert!(!is_quit_key(&Key::Character("w".into())));
        assert!(!is_quit_key(&Key::Named(NamedKey::Enter)));
    }

    #[test]
    fn keys_with_one_character_are_reported_and_composed_texts_are_not() {
        assert_eq!(WindowKey::from_winit(&Key::Character("n".into())), Some(WindowKey::Character('n')));
        assert_eq!(WindowKey::from_winit(&Key::Character(" ".into())), Some(WindowKey::Space));
        assert_eq!(WindowKey::from_winit(&Key::Named(NamedKey::ArrowLeft)), Some(WindowKey::Left));
        assert_eq!(WindowKey::from_winit(&Key::Character("ab".into())), None);
        assert_eq!(WindowKey::from_winit(&Key::Named(NamedKey::F1)), None);
    }
}
