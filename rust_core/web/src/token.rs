//! The token that gives access to the API: random, kept in a file that belongs to the node's user, who alone reads it.

use std::fmt;
use std::fs::{self, OpenOptions};
use std::hint::black_box;
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

/// Random bytes of a token, two digits each.
const BYTES: usize = 16;
/// Permissions of the file.
const MODE: u32 = 0o600;

/// A token. Its `Debug` text does not tell it.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

/// Why there is no token.
#[derive(Debug, thiserror::Error)]
pub enum TokenError {
    /// The file, or its folder, cannot be read or written.
    #[error("{}: {error}", file.display())]
    File {
        /// The token's file.
        file: PathBuf,
        /// What went wrong.
        error: io::Error,
    },
    /// The file is another user's, who knows the token; root could read it all the same.
    #[error("{}: this token belongs to user {owner}, not to user {user} who runs the node; remove the file to get another token, or start the node as its owner", file.display())]
    Owner {
        /// The token's file.
        file: PathBuf,
        /// Its owner's number.
        owner: u32,
        /// The number of the node's user.
        user: u32,
    },
    /// Others may read the file.
    #[error("{}: others may read this token (mode {mode:04o}); remove the file to get another token, or chmod 600", file.display())]
    Readable {
        /// The token's file.
        file: PathBuf,
        /// Its permissions.
        mode: u32,
    },
    /// The file has something else in it.
    #[error("{}: no token of {} hexadecimal digits; remove the file to get another one", file.display(), 2 * BYTES)]
    Invalid {
        /// The token's file.
        file: PathBuf,
    },
}

impl Token {
    /// The token in a file; one that is missing is written, with a new token, in one step.
    ///
    /// # Errors
    /// [`TokenError`].
    pub fn load_or_create(file: &Path) -> Result<Self, TokenError> {
        let failed = |error| TokenError::File { file: file.to_owned(), error };
        let user = rustix::process::geteuid().as_raw();
        match Self::load(file, user) {
            Err(TokenError::File { error, .. }) if error.kind() == io::ErrorKind::NotFound => {}
            loaded => return loaded,
        }
        let folder = file.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(folder).map_err(failed)?;
        let token = Self::random().map_err(failed)?;
        let mut name = file.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{}", std::process::id()));
        let new = folder.join(name);
        let written = write(&new, &token.0).and_then(|()| fs::hard_link(&new, file));
        let removed = fs::remove_file(&new);
        match written {
            Ok(()) => removed.map(|()| token).map_err(failed),
            // Another node was faster: both use its token.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Self::load(file, user),
            Err(error) => Err(failed(error)),
        }
    }

    /// The token in a file that belongs to this user.
    fn load(file: &Path, user: u32) -> Result<Self, TokenError> {
        let failed = |error| TokenError::File { file: file.to_owned(), error };
        // Without blocking on a FIFO.
        let opened = OpenOptions::new()
            .read(true)
            .custom_flags(rustix::fs::OFlags::NONBLOCK.bits().cast_signed())
            .open(file)
            .map_err(failed)?;
        let metadata = opened.metadata().map_err(failed)?;
        let (owner, mode) = (metadata.uid(), metadata.permissions().mode() & 0o777);
        if owner != user {
            return Err(TokenError::Owner { file: file.to_owned(), owner, user });
        }
        if mode & 0o077 != 0 {
            return Err(TokenError::Readable { file: file.to_owned(), mode });
        }
        let mut text = String::new();
        opened.take(4 * BYTES as u64).read_to_string(&mut text).map_err(failed)?;
        let text = text.trim_end();
        let is_valid = text.len() == 2 * BYTES && text.bytes().all(|digit| digit.is_ascii_hexdigit());
        is_valid.then(|| Self(text.to_owned())).ok_or_else(|| TokenError::Invalid { file: file.to_owned() })
    }

    fn random() -> io::Result<Self> {
        let mut bytes = [0; BYTES];
        fs::File::open("/dev/urandom")?.read_exact(&mut bytes)?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// Returns `true` for the same token, in a time that does not tell how much of it is right.
    pub fn is(&self, given: &str) -> bool {
        let differences = self.0.bytes().zip(given.bytes()).fold(0, |all, (own, other)| black_box(all | (own ^ other)));
        self.0.len() == given.len() && differences == 0
    }

    /// The token, for the operator's URL.
    pub fn text(&self) -> &str {
        &self.0
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token")
    }
}

/// Writes a new file that only its owner reads.
fn write(file: &Path, token: &str) -> io::Result<()> {
    let mut new = OpenOptions::new().write(true).create(true).truncate(true).mode(MODE).open(file)?;
    new.set_permissions(fs::Permissions::from_mode(MODE))?;
    writeln!(new, "{token}")?;
    new.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_kept_and_only_its_owner_reads_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/token");
        let token = Token::load_or_create(&file).unwrap();
        assert_eq!((token.text().len(), fs::metadata(&file).unwrap().permissions().mode() & 0o777), (32, 0o600));
        assert_eq!(Token::load_or_create(&file).unwrap(), token);
        assert_eq!(fs::read_dir(folder.path().join("new")).unwrap().count(), 1);
        assert!(!format!("{token:?}").contains(token.text()));
        assert_ne!(Token::random().unwrap(), token);
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        let error = Token::load_or_create(&file).unwrap_err().to_string();
        assert!(error.contains("others may read this token (mode 0640)"), "{error}");
        fs::write(&file, "short\n").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
        assert!(matches!(Token::load_or_create(&file), Err(TokenError::Invalid { .. })));
    }

    #[test]
    fn the_file_of_another_user_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("token");
        Token::load_or_create(&file).unwrap();
        let owner = fs::metadata(&file).unwrap().uid();
        assert!(Token::load(&file, owner).is_ok());
        let error = Token::load(&file, owner + 1).unwrap_err().to_string();
        let expected = format!("{}: this token belongs to user {owner}, not to user {}", file.display(), owner + 1);
        assert!(error.starts_with(&expected) && error.contains("remove the file"), "{error}");
    }

    #[test]
    fn only_the_whole_token_is_right() {
        let token = Token("0123456789abcdef0123456789abcdef".to_owned());
        assert!(token.is("0123456789abcdef0123456789abcdef"));
        for wrong in ["", "0", "0123456789abcdef0123456789abcdee", "0123456789abcdef0123456789abcdef0"] {
            assert!(!token.is(wrong), "{wrong}");
        }
    }
}
