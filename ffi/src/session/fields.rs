//! Plain structs that a scene is described with.

/// How a surface treats light: weights per channel, 0 to 1, of the lobes that it is the sum of; what they leave is absorbed. All 0: black.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_material {
    /// Of Lambert reflection.
    pub diffuse: [f32; 3],
    /// Of Lambert transmission: paper, leaves.
    pub translucent: [f32; 3],
    /// Reflectance of a metal at normal incidence.
    pub metal: [f32; 3],
    /// And at grazing incidence; Schlick's curve lies between them.
    pub edge: [f32; 3],
    /// Factor on what Fresnel's equations reflect at a boundary of glass or water.
    pub glass_reflection: [f32; 3],
    /// And on what they refract. With either of the two the object is a dielectric, and may hold a volume.
    pub glass_transmission: [f32; 3],
    /// Factor on what a clear coat over the diffuse part reflects; the diffuse part gets what is left of it.
    pub coat: [f32; 3],
    /// Of light that goes straight on, as if nothing were there.
    pub transparent: [f32; 3],
    /// Index of refraction of glass and coat, over that of the side that the normal points to, 1e-3 to 1e3; 0 = 1.5. Glass of index 1 bounds a
    /// volume and bends nothing.
    pub ior: f32,
    /// GGX's alpha of metal, glass and coat, 0 to 1; below 1e-3 they are perfectly smooth.
    pub alpha: f32,
    /// A value of covbeam_asks.
    pub asks: u32,
    /// Not 0: of light on its way from a lamp another share goes straight on, which is the next.
    pub has_shadow: u32,
    /// Of that light; the other lobes lose nothing for it, but glass does not act on light that it lets by more freely than `transparent` says.
    pub shadow: [f32; 3],
}

/// What a host that keeps its own geometry (covbeam_host) is asked for where a material is met.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_asks {
    /// Nothing: the material is the same everywhere.
    COVBEAM_ASKS_NOTHING = 0,
    /// Which lobes there are at the hit. The material is the most that any place has: larger weights are cut to its own, and its index of
    /// refraction and whether it is of glass hold everywhere.
    COVBEAM_ASKS_LOBES = 1,
    /// That, if the host has a function for it, and the ways on, which a scattering function of the host's draws. The material is an estimate,
    /// by which the library decides what is worth following; what it lets straight through, its index and whether it is of glass hold.
    COVBEAM_ASKS_WAYS = 2,
}

/// What instances of one object have in common.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_object {
    /// Number of the volume that fills it, or -1: what is around it goes on inside. Glass that no fog goes on in wants a volume without coefficients.
    pub volume: i32,
    /// Not 0: it has an inside. Fog inside of what is of glass is kept apart from that outside.
    pub is_closed: u32,
    /// Sum of values of covbeam_rays that do not see it: to them it is not there.
    pub hidden_from: u32,
    /// Which set it is in, below 64, for lamps that light some only.
    pub light_set: u32,
    /// And for those of which some only cast shadows.
    pub shadow_set: u32,
}

/// Kinds of rays, which go from the eye to the light: light that a diffuse surface sends to the camera is seen by a diffuse ray.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_rays {
    /// From the camera.
    COVBEAM_RAYS_CAMERA = 1,
    /// From a diffuse surface.
    COVBEAM_RAYS_DIFFUSE = 2,
    /// From what reflects as metal, coats and glass do.
    COVBEAM_RAYS_GLOSSY = 4,
    /// From what lets light through, refracted or diffusely.
    COVBEAM_RAYS_TRANSMISSION = 8,
    /// From a place in a volume.
    COVBEAM_RAYS_VOLUME = 16,
    /// From anywhere to a lamp.
    COVBEAM_RAYS_SHADOW = 32,
}

/// Kinds of shapes.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_shape_kind {
    /// Around `a`, of `radius`.
    COVBEAM_SHAPE_SPHERE = 0,
    /// From the lower corner `a` to the upper one `b`.
    COVBEAM_SHAPE_BOX = 1,
    /// The parallelogram at the corner `a` with the edges `b` and `c`; its normal is along b x c.
    COVBEAM_SHAPE_RECTANGLE = 2,
}

/// A shape, exact where a mesh would have corners. Of closed ones of glass that overlap, that of higher priority counts; of equal priority what
/// lies inside of another one counts before that, else the later one.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_shape {
    /// A value of covbeam_shape_kind.
    pub kind: u32,
    /// Number of its material.
    pub material: u32,
    /// Number of the volume that fills it, or -1; one without voxels, in what is of glass.
    pub volume: i32,
    /// From -1000 to 1000.
    pub priority: i32,
    /// Centre, or lower corner, or corner [m].
    pub a: [f32; 3],
    /// Upper corner, or first edge [m].
    pub b: [f32; 3],
    /// Second edge [m].
    pub c: [f32; 3],
    /// Of a sphere [m] > 0.
    pub radius: f32,
}

/// A medium and where it is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_volume {
    /// Scattering coefficient where the relative density is 1 [1/m], 0 to 1e9.
    pub scattering: [f64; 3],
    /// Absorption coefficient [1/m].
    pub absorption: [f64; 3],
    /// A value of covbeam_phase_kind.
    pub phase: u32,
    /// How many volumes this is the sum of; 0: it is none.
    pub part_count: u32,
    /// Mean cosine of Henyey-Greenstein, in (-1, 1).
    pub asymmetry: f64,
    /// Lower corner of what it fills [m]; of the world's, of what fills shapes, and of sums it is not read.
    pub min: [f64; 3],
    /// Upper corner.
    pub max: [f64; 3],
    /// Lower corner of the voxels of the density [m].
    pub density_min: [f64; 3],
    /// Upper corner.
    pub density_max: [f64; 3],
    /// Lower corner of the voxels of what it sends out [m].
    pub glow_min: [f64; 3],
    /// Upper corner.
    pub glow_max: [f64; 3],
    /// Voxels of the density along x, y and z.
    pub density_cells: [u32; 3],
    /// Voxels of what it sends out.
    pub glow_cells: [u32; 3],
    /// Relative density at the middles of voxels, x first, then y, then z; NULL = 1 everywhere.
    pub density: *const f32,
    /// Emission coefficient in the same order, three floats each [W/(m3 sr)]; NULL = it is dark.
    pub glow: *const f32,
    /// The numbers of the volumes of which this is the sum, where all of them and no others are.
    pub parts: *const i32,
    /// Of the world's volume: height in which its density falls to 1/e [m]; 0: it does not, and the next two are not read.
    pub scale_height: f64,
    /// Where it is 1 [m].
    pub origin: [f64; 3],
    /// Where it falls to, unit.
    pub up: [f64; 3],
    /// Sum of values of covbeam_rays that do not see it: of the camera, and to lamps, whose straight light is not dimmed in it then, and scattered all
    /// the same. What has no end dims all light.
    pub hidden_from: u32,
    /// Which set it is in, below 64, for lamps that light some only.
    pub light_set: u32,
    /// And for those of which some only cast shadows: of others' straight light it takes from what it scatters as much as if it reached to the lamp, and
    /// nothing from all else.
    pub shadow_set: u32,
    /// How many phase functions there are beside its own, of which it is a mixture.
    pub lobe_count: u32,
    /// These.
    pub lobes: *const covbeam_phase_lobe,
}

/// A phase function of a mixture.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_phase_lobe {
    /// A value of covbeam_phase_kind.
    pub phase: u32,
    /// Not read.
    pub unused: u32,
    /// Mean cosine of Henyey-Greenstein, in (-1, 1).
    pub asymmetry: f64,
    /// How much of what is scattered it spreads, per channel, 0 to 1; all of a volume sum to no more than 1.
    pub share: [f64; 3],
}

/// Kinds of lights.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_light_kind {
    /// A point or ball that shines all around, or by a pattern: position, intensity, radius, soft.
    COVBEAM_LIGHT_POINT = 0,
    /// The same into a cone: axis, cosine, blend, too.
    COVBEAM_LIGHT_SPOT = 1,
    /// A parallelogram or ellipse around its position that shines towards u x v: u, v, radiance, spread, is_round.
    COVBEAM_LIGHT_AREA = 2,
    /// A disk infinitely far away: axis, irradiance, angle.
    COVBEAM_LIGHT_SUN = 3,
    /// Triangles that shine on both sides: triangles, radiance.
    COVBEAM_LIGHT_MESH = 4,
    /// What is around the scene, infinitely far away: cells, rows, columns, axes.
    COVBEAM_LIGHT_SKY = 5,
}

/// A light. Fields that its kind does not name are not read.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_light {
    /// A value of covbeam_light_kind.
    pub kind: u32,
    /// Not 0: the camera sees it, and mirrors and glass show it, if it has a surface, or is a sky or a sun with an angle.
    pub is_visible: u32,
    /// Not 0: all points see a disk of the lamp's radius that faces them, and no ball.
    pub is_soft: u32,
    /// Not 0: an area is the ellipse in its edges.
    pub is_round: u32,
    /// [m]
    pub position: [f64; 3],
    /// Direction in which a spot shines, or a sun's light travels; unit.
    pub axis: [f64; 3],
    /// First whole edge of an area [m].
    pub u: [f64; 3],
    /// Second one.
    pub v: [f64; 3],
    /// Of points and spots [W/sr].
    pub intensity: [f64; 3],
    /// Of areas and meshes [W/(m2 sr)].
    pub radiance: [f64; 3],
    /// Of suns, across their axis [W/m2].
    pub irradiance: [f64; 3],
    /// Of a pattern, by rows: to the right of the lamp, up, along its axis. Of a sky: the rotation into its picture.
    pub axes: [[f64; 3]; 3],
    /// Of points and spots [m]; 0 = a point.
    pub radius: f64,
    /// Of the half angle of a spot's cone.
    pub cosine: f64,
    /// How far the cosine rises inside of that until the light is full.
    pub blend: f64,
    /// Half angle of an area's honeycomb [rad]; 0 = it has none.
    pub spread: f64,
    /// Half angle that a sun is seen under [rad].
    pub angle: f64,
    /// Angle from the axis that a pattern's rows end at [rad].
    pub reach: f64,
    /// Rows of a pattern or a sky. Of a pattern from the axis outwards; of a sky from +Z of its picture down to -Z.
    pub rows: u32,
    /// Columns: azimuth. Of a sky from pi, by way of +X in the middle, down to -pi.
    pub columns: u32,
    /// Triangles of a mesh.
    pub triangle_count: usize,
    /// Their corners, nine floats each [m].
    pub triangles: *const f32,
    /// Cells of a pattern or a sky, row by row, three floats each; NULL = a lamp without a pattern.
    pub cells: *const f32,
    /// Not 0: a host (covbeam_host) says what it sends. What is described is an estimate then, by which the library chooses among lamps and which
    /// is what the camera sees of it; it shines wherever the host's lamp does.
    pub is_own: u32,
    /// Sum of values of covbeam_rays that do not see it: it does not fall on what they leave. Of the camera's and those to lamps none is read.
    pub hidden_from: u32,
    /// Sets of objects and volumes that it does not fall on straight, a bit each.
    pub unlit: u64,
    /// Sets of objects that cast no shadow of it: it passes them as if they were not there, and falls on them all the same.
    pub unshadowed: u64,
    /// Its straight light is times d^a d^2/(s + d^2) at a distance d; this is a, 0 to 4: 1 makes light of a point fall with the distance, 2 lets it
    /// be as strong everywhere. Of suns and skies it is not read.
    pub falloff: f64,
    /// That is s [m2].
    pub smooth: f64,
    /// Largest number of events of its light on the way to the camera, plus 1, where settings.limits hold: 1 lights what it shines on straight, and no
    /// caustics of it are let off; 0: as many as these say.
    pub most_events: u32,
    /// Not read.
    pub unused: u32,
}

/// How places in the picture become rays.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_projection {
    /// Through a point, or a lens around it. The unit of its plane: the tangent of the angle from the axis.
    COVBEAM_PROJECTION_PERSPECTIVE = 0,
    /// Parallel rays; the unit is that of length.
    COVBEAM_PROJECTION_ORTHOGRAPHIC = 1,
    /// All around a point: longitude and latitude [rad].
    COVBEAM_PROJECTION_EQUIRECTANGULAR = 2,
    /// The distance from the middle is the angle from the axis [rad].
    COVBEAM_PROJECTION_FISHEYE = 3,
}

/// A camera, and the part of its picture that is rendered.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_camera {
    /// The pinhole, the middle of the lens, or of the plane that parallel rays start from [m].
    pub position: [f64; 3],
    /// Viewing direction, any length but 0.
    pub forward: [f64; 3],
    /// Any direction but the viewing one; the picture's upper edge is towards it. Its right is forward x up.
    pub up: [f64; 3],
    /// Half of the picture's height around the middle of the view, in the projection's unit: tan(vertical field of view / 2) in perspective.
    /// 0: the part is given by the next three.
    pub half_height: f64,
    /// Place of the upper left corner in the picture's plane, to the right.
    pub left: f64,
    /// And up.
    pub top: f64,
    /// A pixel's width and height in it.
    pub step: [f64; 2],
    /// Of a fisheye, the largest angle that it shows [rad], up to pi.
    pub widest: f64,
    /// What is nearer is not there [m].
    pub near: f64,
    /// Radius of the lens' opening [m]; 0 = a pinhole, and the next four are not read.
    pub aperture: f64,
    /// Distance of what is sharp [m].
    pub focus: f64,
    /// Angle of the middle of an edge of the opening [rad].
    pub rotation: f64,
    /// Height over width of the opening.
    pub ratio: f64,
    /// Corners of the opening; 0 = a disk.
    pub blades: u32,
    /// A value of covbeam_projection.
    pub projection: u32,
    /// Pixels across, 1 to 16384.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Not 0: a host (covbeam_host) says where its rays go. What is described is an estimate then, by which the library plans.
    pub is_own: u32,
    /// Not read.
    pub unused: u32,
}

/// Where a ray meets a surface.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_surface_hit {
    /// Along the unit direction [m]; infinity: nothing is hit, then all else is 0 but material and object, which are -1.
    pub distance: f32,
    /// The point, moved onto the surface [m].
    pub position: [f32; 3],
    /// Unit, of the triangle: counter-clockwise from its front.
    pub geometric_normal: [f32; 3],
    /// Unit shading normal, on the same side.
    pub normal: [f32; 3],
    /// Given with the instance, or if that is -1 with the triangle.
    pub material: i32,
    /// Given with the instance.
    pub object: i32,
}
