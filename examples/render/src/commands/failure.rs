//! What the program returns when it fails, so that a farm knows whether to try again.

use covbeam_render::files::output::OutputError;
use covbeam_render::files::stored::StoredError;
use covbeam_render::scene_file::SceneError;
use covbeam_render::study::compare::CompareError;
use covbeam_render::study::report::ReferenceError;
use std::error::Error;

/// Something went wrong that may go right another time.
pub(crate) const FAILED: u8 = 1;
/// The command line is wrong.
const USAGE: u8 = 2;
/// What was given to read is wrong: trying again does not help.
const REFUSED: u8 = 3;

/// Arguments that do not go together.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Usage(pub(crate) String);

/// Input that this cannot be done with.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Refused(pub(crate) String);

/// The exit code of an error.
pub(crate) fn exit_code(error: &(dyn Error + 'static)) -> u8 {
    let refused = error.is::<Refused>()
        || error.is::<SceneError>()
        || error.is::<StoredError>()
        || error.is::<CompareError>()
        || matches!(
            error.downcast_ref(),
            Some(OutputError::Read { .. } | OutputError::NoFolder { .. } | OutputError::NotAFile(_))
        )
        || matches!(
            error.downcast_ref(),
            Some(
                ReferenceError::File(_)
                    | ReferenceError::Width { .. }
                    | ReferenceError::Shape { .. }
                    | ReferenceError::Bad { .. }
            )
        );
    match error {
        _ if refused => REFUSED,
        error if error.is::<Usage>() => USAGE,
        _ => FAILED,
    }
}
