//! The keyboard's layout from a compositor's text (XKB text format, version 1, as libxkbcommon writes it): the symbols
//! of each key, without and with shift, of the first layout.
//!
//! There is no binding to libxkbcommon without `unsafe`, and a program linked with it would not start without it.

use std::collections::HashMap;

use xkeysym::Keysym;

/// The symbols of the keys.
#[derive(Debug, Default)]
pub(super) struct Keymap(HashMap<u32, [Option<Keysym>; 2]>);

/// Difference of XKB's key codes from the kernel's.
const KERNEL_OFFSET: u32 = 8;

impl Keymap {
    /// Reads a keymap; keys with unknown syntax have no symbols.
    pub(super) fn parse(text: &str) -> Self {
        let mut codes = HashMap::new();
        let mut symbols = HashMap::new();
        // Statements end with semicolons.
        for statement in text.split(';') {
            if let Some((name, code)) = key_code(statement) {
                codes.insert(name.to_owned(), code);
            } else if let Some((name, found)) = key_symbols(statement) {
                symbols.insert(name.to_owned(), found);
            }
        }
        Self(symbols.into_iter().filter_map(|(name, found)| Some((*codes.get(&name)?, found))).collect())
    }

    /// The symbol of a key by the kernel's code.
    pub(super) fn keysym(&self, kernel_code: u32, is_shifted: bool) -> Option<Keysym> {
        let [plain, shifted] = self.0.get(&(kernel_code + KERNEL_OFFSET))?;
        if is_shifted {
            shifted.or(*plain)
        } else {
            *plain
        }
    }
}

/// `<NAME> = 24`.
fn key_code(statement: &str) -> Option<(&str, u32)> {
    let (name, code) = statement.split_once('=')?;
    let name = name.trim().strip_prefix('<')?.strip_suffix('>')?;
    Some((name, code.trim().parse().ok()?))
}

/// `key <NAME> { [ q, Q ] }`, or with `symbols[1]= [ q, Q ]` among other things.
fn key_symbols(statement: &str) -> Option<(&str, [Option<Keysym>; 2])> {
    let (_, rest) = statement.split_once("key <")?;
    let (name, body) = rest.split_once('>')?;
    let body = body.split_once("symbols[").map_or(body, |(_, symbols)| symbols.split_once(']').map_or("", |(_, s)| s));
    let (_, list) = body.split_once('[')?;
    let (list, _) = list.split_once(']')?;
    let mut found = list.split(',').map(|symbol| keysym(symbol.trim()));
    Some((name, [found.next().flatten(), found.next().flatten()]))
}

/// The symbol of a name: a character, or a name of Latin 1 or of a function key. A test pins the form of the names.
fn keysym(name: &str) -> Option<Keysym> {
    let mut characters = name.chars();
    if let (Some(character), None) = (characters.next(), characters.next()) {
        return Some(Keysym::from_char(character));
    }
    let named = (0x20..=0xff).chain(0xff00..=0xffff).map(Keysym::new);
    named.into_iter().find(|symbol| symbol.name().and_then(|known| known.strip_prefix("XK_")) == Some(name))
}

#[cfg(test)]
mod tests {
    use xkeysym::key;

    use super::*;

    const KEYMAP: &str = r#"xkb_keymap {
xkb_keycodes "(unnamed)" {
	minimum = 8;
	maximum = 708;
	<ESC>                = 9;
	<AD01>               = 24;
	<AC01>               = 38;
	<SPCE>               = 65;
	indicator 1 = "Caps Lock";
	alias <AC12>         = <BKSL>;
};
xkb_symbols "(unnamed)" {
	name[Group1]="French";

	key <ESC>                {	[          Escape ] };
	key <AD01>               {	[               a,               A ] };
	key <AC01>               {
		type= "ALPHABETIC",
		symbols[1]= [               q,               Q ]
	};
	key <SPCE>               {	[           space ] };
	modifier_map Control { <LCTL> };
};
};
"#;

    #[test]
    fn keys_have_the_symbols_of_the_layout() {
        let keymap = Keymap::parse(KEYMAP);
        let symbol = |code: u32, is_shifted| keymap.keysym(code - KERNEL_OFFSET, is_shifted).map(Keysym::raw);
        assert_eq!(symbol(9, false), Some(key::Escape));
        assert_eq!(symbol(9, true), Some(key::Escape));
        assert_eq!((symbol(24, false), symbol(24, true)), (Some(key::a), Some(key::A)));
        assert_eq!((symbol(38, false), symbol(38, true)), (Some(key::q), Some(key::Q)));
        assert_eq!(symbol(65, false), Some(key::space));
        assert_eq!(symbol(66, false), None);
    }

    #[test]
    fn what_is_no_keymap_has_no_keys() {
        for text in ["", "{", ";;;", "key <", "key <A> [ a ]", "<A> = ; key <A> { [ a"] {
            assert!(Keymap::parse(text).0.is_empty(), "{text}");
        }
    }
}
