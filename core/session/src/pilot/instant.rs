//! Instants while a shutter is open, which a pilot is made for.

use crate::scene::Scene;
use covbeam::Medium;

/// Whether what is found will not be used any more.
pub(crate) type Poll<'a> = &'a (dyn Fn() -> bool + Sync);

/// A scene as it is at an instant while a shutter is open, and its media.
#[derive(Clone, Copy)]
pub(crate) struct Instant<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) fogs: &'a [Medium<'a>],
}
