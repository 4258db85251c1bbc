//! Errors of the setup.

use anyhow::Error;
use rcs_node_support::dialog::DialogError;

/// The reason why nothing was written.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// Invalid or missing answers.
    #[error(transparent)]
    Invalid(Error),
    /// The folder has files or cannot be written, or the user ended the questions.
    #[error(transparent)]
    Refused(Error),
}

impl From<DialogError> for SetupError {
    fn from(error: DialogError) -> Self {
        match error {
            DialogError::Unusable(_) | DialogError::Input(_) => Self::Invalid(error.into()),
            DialogError::Ended | DialogError::Output(_) => Self::Refused(error.into()),
        }
    }
}
