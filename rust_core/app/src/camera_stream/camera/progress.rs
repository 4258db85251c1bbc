//! How far a camera's image got.

/// How far a camera's image got, where nothing failed. `T` is what is needed to go on with one that is begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress<T = ()> {
    /// None is due, so whatever failed last is still all that is known.
    NotDue,
    /// One is to be drawn, or being drawn.
    Begun(T),
    /// One was published: it is drawn, or is black or the last one and so needs no drawing.
    Published,
}
