"""Golden cases: README.md."""
