//! Sockets of this process that another library owns: how to act on one without touching another by mistake.
//!
//! rosrust hands out none of its sockets, so they are found in `/proc/self/fd`. Between finding a descriptor there and
//! using it, its owner may close it, and the number may come to mean something else. So a descriptor that is not ours
//! is only ever duplicated. The duplicate is ours and stays what it is, and it is used only if it is the socket that
//! was found: its inode number is compared, which no two open sockets share. Options and connections belong to the
//! socket and not to a descriptor, so what is done to the duplicate is done to the owner's socket.
//!
//! Duplicating by number is what Rust's I/O safety rules out in safe code. It is done here, in one place, and nowhere
//! else in the workspace. (`pidfd_getfd` would do the same without `unsafe`, but needs Linux 5.6, and containers forbid
//! it at times.) Where the system has no `/proc`, no socket is found.

#![expect(unsafe_code, reason = "duplicates descriptors that another library owns")]

use rustix::fs::{fstat, FileType};
use std::os::fd::{BorrowedFd, OwnedFd, RawFd};

/// A socket as it was found: the number of a descriptor, and which socket that was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ForeignSocket {
    descriptor: RawFd,
    inode: u64,
}

/// All sockets that the process has open, whoever owns them.
pub(crate) fn open_sockets() -> impl Iterator<Item = ForeignSocket> {
    let entries = std::fs::read_dir("/proc/self/fd").into_iter().flatten().flatten();
    entries.filter_map(|entry| {
        let descriptor = entry.file_name().to_str()?.parse().ok()?;
        // Such as `socket:[123]`. What is no socket is never duplicated: closing a duplicate of a file would release
        // the process's locks on it.
        let link = std::fs::read_link(entry.path()).ok()?;
        let inode = link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.parse().ok()?;
        Some(ForeignSocket { descriptor, inode })
    })
}

impl ForeignSocket {
    /// The kernel's number of the socket, unique among all sockets while it is open.
    pub(crate) fn inode(&self) -> u64 {
        self.inode
    }

    /// A descriptor of our own for the socket. None if its descriptor was closed, or means something else by now.
    pub(crate) fn duplicate(&self) -> Option<OwnedFd> {
        // -1 is not a descriptor, and `BorrowedFd` may not hold it.
        if self.descriptor < 0 {
            return None;
        }
        // SAFETY: The number is not -1. Its owner may close it at any moment, which the contract of `borrow_raw` does
        // not allow for; that is why the borrow ends with this expression and is used for one system call only,
        // F_DUPFD_CLOEXEC. To the kernel the number is an argument like any other: it fails with EBADF, or duplicates
        // whatever has the number now, and neither reads nor changes that. Below, such a duplicate is found out and
        // closed.
        let duplicate = unsafe { BorrowedFd::borrow_raw(self.descriptor) }.try_clone_to_owned().ok()?;
        let status = fstat(&duplicate).ok()?;
        let is_same = FileType::from_raw_mode(status.st_mode) == FileType::Socket && status.st_ino == self.inode;
        is_same.then_some(duplicate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::UdpSocket;
    use std::os::fd::AsRawFd;

    fn socket() -> OwnedFd {
        UdpSocket::bind("127.0.0.1:0").unwrap().into()
    }

    fn found(descriptor: &OwnedFd) -> ForeignSocket {
        open_sockets().find(|socket| socket.descriptor == descriptor.as_raw_fd()).unwrap()
    }

    #[test]
    fn a_duplicate_is_another_descriptor_of_the_same_socket() {
        let socket = socket();
        let duplicate = found(&socket).duplicate().unwrap();
        assert_ne!(duplicate.as_raw_fd(), socket.as_raw_fd());
        assert_eq!(fstat(&duplicate).unwrap().st_ino, fstat(&socket).unwrap().st_ino);
        let flags = rustix::io::fcntl_getfd(&duplicate).unwrap();
        assert!(flags.contains(rustix::io::FdFlags::CLOEXEC), "programs that are started do not inherit it");
    }

    #[test]
    fn a_descriptor_that_became_another_socket_or_a_file_is_not_duplicated() {
        let mut reused = socket();
        let expected = found(&reused);
        assert!(expected.duplicate().is_some());
        // The number now means another socket, as if its owner had closed the first and the system had reused the
        // number.
        rustix::io::dup2(socket(), &mut reused).unwrap();
        assert_eq!(reused.as_raw_fd(), expected.descriptor);
        assert!(expected.duplicate().is_none());
        assert!(found(&reused).duplicate().is_some(), "the new socket is found under the number");
        rustix::io::dup2(std::fs::File::open("/dev/null").unwrap(), &mut reused).unwrap();
        assert!(expected.duplicate().is_none());
    }

    #[test]
    fn a_closed_descriptor_and_no_descriptor_have_no_duplicate() {
        // No process has so many.
        assert!(ForeignSocket { descriptor: RawFd::MAX, inode: 1 }.duplicate().is_none());
        assert!(ForeignSocket { descriptor: -1, inode: 1 }.duplicate().is_none());
    }

    #[test]
    fn files_are_no_sockets() {
        let file = std::fs::File::open("/dev/null").unwrap();
        assert!(open_sockets().all(|socket| socket.descriptor != file.as_raw_fd()));
    }
}
