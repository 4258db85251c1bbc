//! The tutorials: every command does what its page says, in an empty folder.

use rcs_tests::programs::repository;

use crate::launch::devel_space;
use crate::succeed;

/// Every command of each page, literally, with the last line that it prints.
#[test]
fn the_tutorials_commands_print_what_the_pages_say() {
    let space = tempfile::tempdir().unwrap();
    let pages = repository().join("docs/tutorials");
    let script = format!(
        "{}
         tests/programs/tutorials/run {}/*.md",
        devel_space(space.path()),
        pages.display()
    );
    let printed = succeed(&script);
    assert_eq!(printed.matches(" commands did as ").count(), 3, "{printed}");
}
