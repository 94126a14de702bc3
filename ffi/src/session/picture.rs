//! Pictures of sessions, and their sums as bytes.

use super::polled;
use super::render::covbeam_session;
use crate::handle::shared;
use crate::memory::{Slot, aligned, array, outputs};
use crate::status::{Failure, covbeam_poll, covbeam_status, covbeam_status::*, fail, run};
use ::covbeam_session::film::{Layers, Picture};
use ::covbeam_session::kind::Kind;
use ::covbeam_session::settings::{Layers as KindsOfLight, Settings};
use core::ffi::c_void;
use glam::Vec3;

/// What of a picture is asked for: three floats a pixel, linear Rec. 709 [W/(m2 sr)], unless it says one.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_layer {
    /// All light.
    COVBEAM_LAYER_ALL = 0,
    /// Light that nothing has scattered, reflected or bent before what sends it to the camera. It and the next two add up to all light, and need
    /// kinds_apart.
    COVBEAM_LAYER_STRAIGHT = 1,
    /// Light that has met mirrors and glass alone: caustics.
    COVBEAM_LAYER_FOCUSED = 2,
    /// Light that was scattered before.
    COVBEAM_LAYER_SCATTERED = 3,
    /// What fog scatters before the first surface; needs first_apart.
    COVBEAM_LAYER_FIRST = 4,
    /// Standard error of the luminance of all light, one float; 0 after a single pass.
    COVBEAM_LAYER_ERROR = 5,
    /// Mean kernel radius [m], weighted by light, one float; 0 where nothing was gathered.
    COVBEAM_LAYER_RADIUS = 6,
    /// Mean bandwidth of the fluence across the kernel [cycles/m], the same.
    COVBEAM_LAYER_BANDWIDTH = 7,
}

/// A layer of the picture of the passes done, at least one. The picture is made with the first layer, and kept until there is another pass.
///
/// @param session the session.
/// @param layer a value of covbeam_layer.
/// @param count pixels: width x height, rows from the top.
/// @param out, out_stride receive three floats each, or one; a stride of 0: side by side.
/// @param poll, user asked at least every 50 ms whether to go on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_session_picture(
    session: *const covbeam_session,
    layer: u32,
    count: usize,
    out: *mut f32,
    out_stride: usize,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let session = unsafe { shared(session, "session") }?;
        let [width, height] = session.size();
        let pixels = width as usize * height as usize;
        if count != pixels {
            let message = format_args!("count: {count}; the camera has {pixels} pixels");
            return Err(fail(COVBEAM_SHORT_BUFFER, message));
        }
        let is_color = layer < covbeam_layer::COVBEAM_LAYER_ERROR as u32;
        let size = if is_color { size_of::<[f32; 3]>() } else { size_of::<f32>() };
        let stride = if out_stride == 0 { size } else { out_stride };
        if is_color {
            outputs!(count, out: [f32; 3], stride);
            let picture = polled(poll, user, |go_on| session.picture(go_on))?;
            let found = colors(&picture, session.settings(), layer)?;
            (0..count).for_each(|index| out.set(index, found.get(index).map_or([0.0; 3], Vec3::to_array)));
        } else {
            outputs!(count, out, stride);
            if layer > covbeam_layer::COVBEAM_LAYER_BANDWIDTH as u32 {
                return Err(fail(COVBEAM_INVALID_VALUE, format_args!("layer: {layer} is no covbeam_layer")));
            }
            let picture = polled(poll, user, |go_on| session.picture(go_on))?;
            let found = numbers(&picture, layer);
            (0..count).for_each(|index| out.set(index, found.get(index).copied().unwrap_or(0.0)));
        }
        Ok(())
    })
}

/// Colours of a layer; none: it is dark.
fn colors<'p>(picture: &'p Picture, settings: &Settings, layer: u32) -> Result<&'p [Vec3], Failure> {
    let kind = match layer {
        l if l == covbeam_layer::COVBEAM_LAYER_STRAIGHT as u32 => Kind::Straight,
        l if l == covbeam_layer::COVBEAM_LAYER_FOCUSED as u32 => Kind::Focused,
        l if l == covbeam_layer::COVBEAM_LAYER_SCATTERED as u32 => Kind::Scattered,
        l if l == covbeam_layer::COVBEAM_LAYER_FIRST as u32 => {
            if !settings.first_apart {
                return Err(lacks("first_apart", "the fog before the first surface is"));
            }
            return Ok(picture.maps.as_ref().map_or(&[], |maps| &maps.volume));
        }
        _ => {
            debug_assert_eq!(layer, covbeam_layer::COVBEAM_LAYER_ALL as u32, "others are refused before");
            return Ok(&picture.radiance);
        }
    };
    if settings.layers != KindsOfLight::EachKind {
        return Err(lacks("kinds_apart", "kinds of light are"));
    }
    // A scene without mirrors and glass has no focused light.
    Ok(picture.kinds.iter().find(|(found, _)| *found == kind).map_or(&[], |(_, light)| light))
}

fn lacks(setting: &str, what: &str) -> Failure {
    fail(COVBEAM_WRONG_ORDER, format_args!("layer: {what} not kept apart; make the session with {setting}"))
}

fn numbers(picture: &Picture, layer: u32) -> &[f32] {
    let of =
        |values: fn(&Layers) -> &Vec<f32>| picture.layers.as_ref().map_or(&[][..], |layers| values(layers));
    match layer {
        l if l == covbeam_layer::COVBEAM_LAYER_RADIUS as u32 => of(|layers| &layers.radius),
        l if l == covbeam_layer::COVBEAM_LAYER_BANDWIDTH as u32 => of(|layers| &layers.sigma),
        _ => picture.error.as_deref().unwrap_or(&[]),
    }
}

/// The exact sums of the passes that a session holds, as bytes: the same on every machine, and for the same passes, in whatever order they came.
///
/// @param session one that holds a pass.
/// @param bytes memory for them; NULL: none, and only the size is said.
/// @param size bytes there.
/// @param needed receives how many there are.
/// @note COVBEAM_SHORT_BUFFER if there are more than `size`; `needed` is written then, too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_session_save(
    session: *const covbeam_session,
    bytes: *mut c_void,
    size: usize,
    needed: *mut usize,
) -> covbeam_status {
    run(|| {
        let needed = Slot::new(needed, "needed")?;
        // SAFETY: by the caller's promise.
        let session = unsafe { shared(session, "session") }?;
        let saved = polled(None, core::ptr::null_mut(), |go_on| session.save(go_on))?;
        needed.set(saved.len());
        if bytes.is_null() {
            return Ok(());
        }
        aligned(bytes.cast::<u8>(), "bytes")?;
        if size < saved.len() {
            let message = format_args!("size: {size}, but there are {} bytes", saved.len());
            return Err(fail(COVBEAM_SHORT_BUFFER, message));
        }
        // SAFETY: not NULL; writable by the caller's promise, and long enough.
        unsafe { bytes.cast::<u8>().copy_from_nonoverlapping(saved.as_ptr(), saved.len()) };
        Ok(())
    })
}

/// Adds sums of other passes of the same picture, which covbeam_session_save gave here or elsewhere. Pictures have the same bits as if all of
/// them had been rendered here, and the next passes are those that are missing.
///
/// @param session the session.
/// @param bytes, size the sums. COVBEAM_BAD_DATA if they are none, damaged, of another scene or other settings, or of passes that are there.
/// @param poll, user asked at least every 50 ms whether to go on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_session_merge(
    session: *const covbeam_session,
    bytes: *const c_void,
    size: usize,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let session = unsafe { shared(session, "session") }?;
        // SAFETY: by the caller's promise.
        let bytes = unsafe { array(bytes.cast::<u8>(), size, "bytes") }?;
        polled(poll, user, |go_on| session.merge(bytes, go_on))
    })
}
