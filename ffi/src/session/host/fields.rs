//! What a host's functions are asked, and what they answer, in plain structs.

use crate::session::fields::covbeam_material;
use core::ffi::c_void;

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
    /// Whatever the host wants to find the place by when it is asked about it: a triangle and where in it.
    pub mark: [u32; 3],
}

/// Light, or an eye path, that meets a surface.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_meeting {
    /// Where, as the host gave it.
    pub hit: covbeam_host_hit,
    /// Along which it comes, unit.
    pub direction: [f32; 3],
    /// Uniform in [0, 1): to draw the directions of rough ways with.
    pub xi: [f32; 2],
}

/// A way on from a surface that goes one direction, or a rough one of which one direction has been drawn.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_way {
    /// What goes on like this of light that arrives, over the probability density of the direction, 0 to 1; 0: nothing does, and the rest is not
    /// read.
    pub factor: [f32; 3],
    /// Unit.
    pub direction: [f32; 3],
    /// Standard deviation of its directions [rad]; 0: it is sharp.
    pub deviation: f32,
}

/// All ways on from a surface, each a part of the light that arrives; what they leave is absorbed, and what is more than all, together with
/// what the material lets straight through, is scaled down.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_ways {
    /// Of Lambert reflection.
    pub diffuse: [f32; 3],
    /// Of Lambert transmission.
    pub translucent: [f32; 3],
    /// Back to the side that it comes from. Of lamps that are points, rough ones show nothing.
    pub reflected: [covbeam_host_way; 3],
    /// Into glass or out of it, by the material's index of refraction.
    pub refracted: covbeam_host_way,
}

/// A photon that is wanted of a lamp.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_draw {
    /// Number of the light in the description.
    pub light: u32,
    /// In the unit square: says where it goes. Neighbouring places should go neighbouring ways, for the library learns which it needs.
    pub place: [f32; 2],
    /// Uniform in [0, 1): from which point of a lamp that has a size.
    pub xi: [f32; 2],
}

/// A photon of a lamp.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_photon {
    /// Where it starts [m].
    pub origin: [f32; 3],
    /// Unit.
    pub direction: [f32; 3],
    /// Flux of the lamp if all of its light left like this photon [W]: emission over the probability density of the place's photon. Its mean over
    /// the unit square is the lamp's flux; no more than 1e4 times what is described as that is taken. 0: none.
    pub power: [f32; 3],
    /// Normal of the surface that it leaves; 0 of a lamp without one.
    pub normal: [f32; 3],
    /// Radius of a disk that looks as large as the lamp from along its way [m]; 0: a point.
    pub radius: f32,
    /// How the lamp's light varies with direction [cycles2/rad2]: 1/(4 pi2 w2) where it falls off within an angle of w; 0: it is even.
    pub angular_variance: f32,
}

/// What a shadow ray asks of a lamp.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_question {
    /// Number of the light in the description.
    pub light: u32,
    /// Where light is to arrive [m].
    pub place: [f32; 3],
    /// Uniform in [0, 1): the point that stands for all of a lamp that has a size; (0, 0): the middle of it, about.
    pub xi: [f32; 2],
}

/// What it is told, if nothing is in the way: the library finds that out.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_arrival {
    /// What arrives on a small ball, over its cross section [W/m2].
    pub density: [f32; 3],
    /// From where [m].
    pub from: [f32; 3],
}

/// A ray that is wanted of the camera.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_pixel {
    /// Place in the picture, from its upper left corner [pixels].
    pub place: [f32; 2],
    /// Uniform in [0, 1): where in the lens, by even parts of it; (0, 0): in its middle.
    pub lens: [f32; 2],
}

/// A ray of the camera.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host_eye_ray {
    /// Where it starts [m].
    pub origin: [f32; 3],
    /// Unit; 0: there is none, and the place is dark.
    pub direction: [f32; 3],
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

/// Says what surfaces are at hits: `lobes` holds their materials as described, to be changed. As covbeam_host_cast.
pub type covbeam_host_lobes = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        count: usize,
        hits: *const covbeam_host_hit,
        lobes: *mut covbeam_material,
    ),
>;

/// Draws the ways on from surfaces. As covbeam_host_cast.
pub type covbeam_host_scatter = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        count: usize,
        meetings: *const covbeam_host_meeting,
        ways: *mut covbeam_host_ways,
    ),
>;

/// Draws photons of lamps. As covbeam_host_cast.
pub type covbeam_host_emit = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        count: usize,
        draws: *const covbeam_host_draw,
        photons: *mut covbeam_host_photon,
    ),
>;

/// Says what arrives straight from lamps. As covbeam_host_cast.
pub type covbeam_host_illuminate = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        count: usize,
        questions: *const covbeam_host_question,
        arrivals: *mut covbeam_host_arrival,
    ),
>;

/// Says where rays of the camera go. As covbeam_host_cast.
pub type covbeam_host_eye = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        count: usize,
        pixels: *const covbeam_host_pixel,
        rays: *mut covbeam_host_eye_ray,
    ),
>;

/// A host's geometry, and functions for what its description says is its own. It must outlive the scenes and sessions that are made of it: what was
/// stopped may ask it for a moment longer, until its session is freed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_host {
    /// sizeof(covbeam_host).
    pub struct_size: u32,
    /// Another number for another geometry, or other functions: sums of sessions are told apart by it.
    pub version: u32,
    /// What the functions are called with.
    pub user: *mut c_void,
    /// The nearest surface of rays.
    pub cast: covbeam_host_cast,
    /// Whether rays meet anything; NULL: `cast` is asked.
    pub blocked: covbeam_host_blocked,
    /// What surfaces are at hits: textures, masks; for materials that ask for lobes or ways.
    pub lobes: covbeam_host_lobes,
    /// Where surfaces send light; for materials that ask for ways.
    pub scatter: covbeam_host_scatter,
    /// Photons; for lights that are the host's own.
    pub emit: covbeam_host_emit,
    /// And what they send straight to a place.
    pub illuminate: covbeam_host_illuminate,
    /// Eye rays; for a camera that is the host's own.
    pub eye: covbeam_host_eye,
    /// Lower corner of a box around all surfaces [m].
    pub min: [f32; 3],
    /// Upper corner.
    pub max: [f32; 3],
}
