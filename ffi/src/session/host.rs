//! Hosts that keep their own geometry: rays are cast by their functions.

use super::description::covbeam_description;
use super::identity::Contents;
use super::scene::{covbeam_scene, scene_of};
use crate::memory::{Slot, read_options};
use crate::status::{covbeam_status, covbeam_status::*, fail, run};
use ::covbeam_geometry::hit::Hit;
use ::covbeam_session::describe::Description;
use ::covbeam_session::object::geometry::HostGeometry;
use core::ffi::c_void;
use covbeam_core::Curvature;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// A ray.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_ray {
    /// Where it starts [m].
    pub origin: [f64; 3],
    /// Unit.
    pub direction: [f64; 3],
    /// What is farther away does not count [m]; infinity: everything does.
    pub reach: f64,
}

/// Where a ray meets a surface of the host. All numbers are checked: a hit that is none counts as nothing hit.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_hit {
    /// In (0, reach); 0: nothing is hit, and the rest is not read.
    pub distance: f32,
    /// The point, moved onto the surface [m].
    pub position: [f32; 3],
    /// Unit, outward on closed surfaces, not turned towards the ray.
    pub geometric_normal: [f32; 3],
    /// Unit shading normal, on the same side.
    pub normal: [f32; 3],
    /// More than rounding can have moved the point [m], such as 4 ulps of the largest coordinate.
    pub offset: f32,
    /// Direction in the surface of the curvature below, unit; not read where that is 0.
    pub tangent: [f32; 3],
    /// Curvature of the shading normals along the tangent [1/m], positive = convex towards the normal; 0: light sees it as flat, and caustics of it
    /// are blurred.
    pub along: f32,
    /// And across it.
    pub across: f32,
    /// And the twist.
    pub twist: f32,
    /// Number of the object in the description.
    pub object: u32,
    /// Number of the material in the description.
    pub material: u32,
}

/// Finds the nearest surfaces that rays meet, from either side, and fills a hit for each. Called from many threads at once; the same rays
/// must get the same hits. `count` is 1 today.
pub type covbeam_host_cast = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        count: usize,
        rays: *const covbeam_host_ray,
        hits: *mut covbeam_host_hit,
    ),
>;

/// Tells of rays whether they meet anything: not 0 in `blocked`. As covbeam_host_cast.
pub type covbeam_host_blocked = Option<
    unsafe extern "C" fn(user: *mut c_void, count: usize, rays: *const covbeam_host_ray, blocked: *mut u8),
>;

/// A host's geometry. It must outlive the scenes and sessions that are made of it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host {
    /// sizeof(covbeam_host).
    pub struct_size: u32,
    /// Another number for another geometry: sums of sessions are told apart by it.
    pub version: u32,
    /// What the functions are called with.
    pub user: *mut c_void,
    /// The nearest surface of rays.
    pub cast: covbeam_host_cast,
    /// Whether rays meet anything; NULL: `cast` is asked.
    pub blocked: covbeam_host_blocked,
    /// Lower corner of a box around all of it [m].
    pub min: [f32; 3],
    /// Upper corner.
    pub max: [f32; 3],
}

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
        let given = unsafe { read_options(host, size_of::<covbeam_host>(), "host") }?;
        let Some(cast) = given.cast else {
            return Err(fail(COVBEAM_NULL_POINTER, format_args!("host.cast: NULL; give a function")));
        };
        let mut contents = Contents::default();
        contents.note(&(given.version, given.min, given.max));
        let host = Host { user: given.user, cast, blocked: given.blocked, min: given.min, max: given.max };
        let make = |description: Description| description.scene_of_host(Arc::new(host));
        // SAFETY: by the caller's promise.
        out.set(unsafe { scene_of(description, contents, make) }?);
        Ok(())
    })
}

type Cast = unsafe extern "C" fn(*mut c_void, usize, *const covbeam_host_ray, *mut covbeam_host_hit);
type Blocked = unsafe extern "C" fn(*mut c_void, usize, *const covbeam_host_ray, *mut u8);

#[derive(Debug)]
struct Host {
    user: *mut c_void,
    cast: Cast,
    blocked: Option<Blocked>,
    min: [f32; 3],
    max: [f32; 3],
}

// SAFETY: the host promises that its functions may be called from any thread.
unsafe impl Send for Host {}
// SAFETY: and from several at once.
unsafe impl Sync for Host {}

/// No hit, which a function that writes nothing leaves as it is.
const MISS: covbeam_host_hit = covbeam_host_hit {
    distance: 0.0,
    position: [0.0; 3],
    geometric_normal: [0.0; 3],
    normal: [0.0; 3],
    offset: 0.0,
    tangent: [0.0; 3],
    along: 0.0,
    across: 0.0,
    twist: 0.0,
    object: 0,
    material: 0,
};

impl HostGeometry for Host {
    fn bounds(&self) -> (Vec3, Vec3) {
        (self.min.into(), self.max.into())
    }

    fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
        let ray = covbeam_host_ray { origin: origin.to_array(), direction: direction.to_array(), reach };
        let mut hit = MISS;
        // SAFETY: the host's function, with what the host gave for it; both arrays have one element.
        unsafe { (self.cast)(self.user, 1, &ray, &mut hit) };
        // False for NaN.
        (hit.distance > 0.0).then(|| Hit {
            distance: hit.distance,
            position: hit.position.into(),
            geometric_normal: hit.geometric_normal.into(),
            normal: hit.normal.into(),
            curvature: curvature(&hit),
            object: hit.object,
            material: hit.material,
            offset: hit.offset,
        })
    }

    fn is_blocked(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<bool> {
        let blocked = self.blocked?;
        let ray = covbeam_host_ray { origin: origin.to_array(), direction: direction.to_array(), reach };
        let mut is_blocked = 0;
        // SAFETY: as above.
        unsafe { blocked(self.user, 1, &ray, &mut is_blocked) };
        Some(is_blocked != 0)
    }
}

/// Of a hit; along any direction where it is flat.
fn curvature(hit: &covbeam_host_hit) -> Curvature {
    let covbeam_host_hit { tangent, along, across, twist, .. } = *hit;
    let tangent = match [along, across, twist] == [0.0; 3] {
        true => Vec3::from(hit.normal).try_normalize().unwrap_or(Vec3::Z).any_orthonormal_vector(),
        false => tangent.into(),
    };
    Curvature { tangent, along, across, twist }
}
