//! Hosts that keep their own geometry, and if they like materials, lamps and camera of their own: what their functions are asked.

mod calls;
pub mod fields;

use super::description::covbeam_description;
use super::identity::Contents;
use super::scene::{covbeam_scene, scene_of};
use crate::memory::{Slot, read_options};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use ::covbeam_session::describe::Description;
use ::covbeam_session::material::Asks;
use calls::Host;
use fields::covbeam_host;
use std::sync::Arc;

/// Makes a scene of a host's geometry.
///
/// @param host the geometry; objects and materials of its hits are numbers of the description's.
/// @param description all else, copied.
/// @param out the handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_scene_new_of_host(
    host: *const covbeam_host,
    description: *const covbeam_description,
    out: *mut *mut covbeam_scene,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        // SAFETY: by the caller's promise.
        let host = unsafe { read_options(host, size_of::<covbeam_host>(), "host") }?;
        if host.cast.is_none() {
            return Err(fail(COVBEAM_NULL_POINTER, format_args!("host.cast: NULL; give a function")));
        }
        let mut contents = Contents::default();
        contents.note(&(host.version, host.min, host.max));
        // SAFETY: by the caller's promise.
        let given = unsafe {
            scene_of(description, contents, |description| {
                answers(&host, &description)?;
                description.scene_of_host(Arc::new(Host(host))).map_err(super::refused)
            })
        };
        out.set(given?);
        Ok(())
    })
}

/// Refuses a host without a function that its description asks for.
fn answers(host: &covbeam_host, description: &Description) -> Result<(), Failure> {
    let asks = |what: Asks| description.materials.iter().any(|material| material.asks == what);
    let own = description.lights.iter().any(|light| light.fields.is_own);
    let needed = [
        ("lobes", host.lobes.is_some() || !asks(Asks::Lobes), "a material asks for it"),
        ("scatter", host.scatter.is_some() || !asks(Asks::Ways), "a material asks for it"),
        ("emit", host.emit.is_some() || !own, "a light is the host's own"),
        ("illuminate", host.illuminate.is_some() || !own, "a light is the host's own"),
        ("eye", host.eye.is_some() || !description.camera.is_own, "the camera is the host's own"),
    ];
    match needed.into_iter().find(|(_, is_there, _)| !is_there) {
        Some((name, _, why)) => {
            Err(fail(COVBEAM_NULL_POINTER, format_args!("host.{name}: NULL, and {why}; give a function")))
        }
        None => Ok(()),
    }
}
