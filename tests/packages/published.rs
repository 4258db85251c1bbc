//! The apt repository that `scripts/packages/make_repository` makes, of packages with nothing in them, and the
//! workflows that publish it. `tests/packages/repository` installs from a repository in a root of Debian.

use std::fs;
use std::path::Path;

use rcs_tests::programs::repository;

use crate::{bash, printed_by, succeed};

/// Makes a key and, in each of `folders`, a repository of a package for each architecture.
fn make_repositories(work: &Path, folders: [&str; 2]) {
    let [first, second] = folders;
    succeed(&format!(
        "cd {0}; mkdir -m 700 gnupg; mkdir -p packages tree/DEBIAN
         for architecture in amd64 arm64; do
           printf '%s\\n' 'Package: empty' 'Version: 1' \"Architecture: $architecture\" 'Maintainer: A <a@localhost>' \
             'Description: nothing' >tree/DEBIAN/control
           dpkg-deb --root-owner-group --build tree packages/empty_1_$architecture.deb >/dev/null
         done
         export GNUPGHOME=$PWD/gnupg SOURCE_DATE_EPOCH=1763900000
         gpg --batch --quiet --passphrase '' --quick-generate-key owner@localhost ed25519 sign 1d
         for folder in {first} {second}; do
           {1}/scripts/packages/make_repository packages owner@localhost $folder
         done
         gpgconf --kill all",
        work.display(),
        repository().display()
    ));
}

#[test]
fn a_repository_is_signed_and_the_same_packages_give_the_same() {
    let work = tempfile::tempdir().unwrap();
    make_repositories(work.path(), ["first", "second"]);
    let differences = bash(&format!("cd {}; diff -rq first second", work.path().display()));
    let differences = printed_by(&differences);
    let is_signature = |line: &str| line.contains("/InRelease ") || line.contains("/Release.gpg ");
    assert!(differences.lines().all(is_signature), "{differences}");
    let printed = succeed(&format!(
        "cd {}/first; gpg --dearmor <rviz_camera_stream.asc >../key.gpg
         gpgv -q --keyring ../key.gpg dists/stable/Release.gpg dists/stable/Release
         gpgv -q --keyring ../key.gpg --output - dists/stable/InRelease | diff - dists/stable/Release
         cat dists/stable/Release dists/stable/main/binary-arm64/Packages",
        work.path().display()
    ));
    for line in
        ["Date: Sun, 23 Nov 2025 12:13:20 +0000", "Architectures: amd64 arm64", "Filename: pool/empty_1_arm64.deb"]
    {
        assert!(printed.lines().any(|found| found == line), "no '{line}' in\n{printed}");
    }
    assert!(!printed.contains("empty_1_amd64.deb"), "{printed}");
}

#[test]
fn workflows_name_actions_by_commit_and_jobs_have_few_permissions() {
    for name in ["ci.yml", "release.yml"] {
        let text = fs::read_to_string(repository().join(".github/workflows").join(name)).unwrap();
        let mut uses =
            text.lines().filter_map(|line| line.trim().trim_start_matches("- ").strip_prefix("uses: ")).peekable();
        assert!(uses.peek().is_some(), "{name}");
        for action in uses {
            let (_, commit) = action.split_once('@').unwrap();
            let (commit, version) = commit.split_once(" # v").unwrap_or((commit, ""));
            let is_commit = commit.len() == 40 && commit.bytes().all(|letter| letter.is_ascii_hexdigit());
            assert!(is_commit && !version.is_empty(), "{name}: {action}");
        }
        // All jobs have these.
        let (_, permissions) = text.split_once("\npermissions:").unwrap();
        let permissions = permissions.split("\n\n").next().unwrap().trim();
        assert!(["{}", "contents: read"].contains(&permissions), "{name}: {permissions}");
    }
}
