//! The command `./test`, without running a check: its help and its arguments.

use crate::{bash, printed_by, succeed};

#[test]
fn the_help_names_every_check() {
    let help = succeed("./test --help");
    for name in ["lint", "format", "build", "scripts", "licences", "unit", "programs", "rviz", "page"] {
        assert!(help.contains(name), "{name} is not in: {help}");
    }
}

#[test]
fn an_unknown_check_is_refused() {
    let output = bash("./test format nonsense");
    assert_eq!(output.status.code(), Some(2), "{}", printed_by(&output));
    assert!(printed_by(&output).contains("test: there is no check 'nonsense'"), "{}", printed_by(&output));
}
