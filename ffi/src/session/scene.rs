//! Scenes, from a description in plain structs.

use super::description::{covbeam_description, described};
use super::geometry::{Kept, covbeam_geometry};
use super::identity::Contents;
use super::refused;
use crate::handle::{Opaque, free, handle_to, optional};
use crate::memory::{Slot, read_options};
use crate::status::{Failure, covbeam_status, run};
use ::covbeam_session::describe::Description;
use ::covbeam_session::scene::Scene;
use std::sync::Arc;

/// What is rendered: a description and a geometry. It does not change, and any number of sessions may use it.
pub struct covbeam_scene(());

impl Opaque for covbeam_scene {
    type Object = Described;
    const TAG: u64 = u64::from_le_bytes(*b"cb-scene");
    const NAME: &'static str = "covbeam_scene";
}

/// What a `covbeam_scene` is.
pub(crate) struct Described {
    pub(super) scene: Arc<Scene>,
    pub(super) contents: Contents,
}

/// Makes a scene.
///
/// @param geometry one that has been built; NULL: there are shapes only.
/// @param description all else, copied.
/// @param out the handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_scene_new(
    geometry: *const covbeam_geometry,
    description: *const covbeam_description,
    out: *mut *mut covbeam_scene,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        // SAFETY: by the caller's promise.
        let kept = unsafe { optional(geometry, "geometry") }?;
        let built = kept.as_ref().map(|kept| kept.geometry.built()).transpose().map_err(refused)?;
        let built = built.unwrap_or_default();
        let contents = kept.as_deref().map_or_else(Contents::default, |kept: &Kept| kept.contents.clone());
        // SAFETY: by the caller's promise.
        out.set(unsafe {
            scene_of(description, contents, |description| description.scene(built).map_err(refused))
        }?);
        Ok(())
    })
}

/// A scene of a description, on the geometry that `contents` are of.
///
/// # Safety
/// The description and all that it names are readable.
pub(super) unsafe fn scene_of(
    description: *const covbeam_description,
    mut contents: Contents,
    make: impl FnOnce(Description) -> Result<Scene, Failure>,
) -> Result<*mut covbeam_scene, Failure> {
    // SAFETY: by this function's contract.
    let given = unsafe { read_options(description, size_of::<covbeam_description>(), "description") }?;
    // SAFETY: by this function's contract.
    let description = unsafe { described(&given, &mut contents) }?;
    let scene = Arc::new(make(description)?);
    handle_to(Described { scene, contents })
}

/// Frees a scene; sessions of it go on.
///
/// @param scene NULL is fine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_scene_free(scene: *mut covbeam_scene) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(scene, "scene") }
}
