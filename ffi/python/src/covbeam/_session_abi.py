"""The C ABI of sessions as ctypes sees it. Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit."""

import ctypes

from ._abi import GridLayout


class Material(ctypes.Structure):
    _fields_ = [
        ("diffuse", ctypes.c_float * 3),
        ("translucent", ctypes.c_float * 3),
        ("metal", ctypes.c_float * 3),
        ("edge", ctypes.c_float * 3),
        ("glass_reflection", ctypes.c_float * 3),
        ("glass_transmission", ctypes.c_float * 3),
        ("coat", ctypes.c_float * 3),
        ("transparent", ctypes.c_float * 3),
        ("ior", ctypes.c_float),
        ("alpha", ctypes.c_float),
        ("asks", ctypes.c_uint32),
        ("has_shadow", ctypes.c_uint32),
        ("shadow", ctypes.c_float * 3),
    ]


class Object(ctypes.Structure):
    _fields_ = [
        ("volume", ctypes.c_int32),
        ("is_closed", ctypes.c_uint32),
        ("hidden_from", ctypes.c_uint32),
        ("light_set", ctypes.c_uint32),
        ("shadow_set", ctypes.c_uint32),
    ]


class Shape(ctypes.Structure):
    _fields_ = [
        ("kind", ctypes.c_uint32),
        ("material", ctypes.c_uint32),
        ("volume", ctypes.c_int32),
        ("priority", ctypes.c_int32),
        ("a", ctypes.c_float * 3),
        ("b", ctypes.c_float * 3),
        ("c", ctypes.c_float * 3),
        ("radius", ctypes.c_float),
    ]


class PhaseLobe(ctypes.Structure):
    _fields_ = [
        ("phase", ctypes.c_uint32),
        ("unused", ctypes.c_uint32),
        ("asymmetry", ctypes.c_double),
        ("share", ctypes.c_double * 3),
    ]


class Volume(ctypes.Structure):
    _fields_ = [
        ("scattering", ctypes.c_double * 3),
        ("absorption", ctypes.c_double * 3),
        ("phase", ctypes.c_uint32),
        ("part_count", ctypes.c_uint32),
        ("asymmetry", ctypes.c_double),
        ("min", ctypes.c_double * 3),
        ("max", ctypes.c_double * 3),
        ("density_min", ctypes.c_double * 3),
        ("density_max", ctypes.c_double * 3),
        ("glow_min", ctypes.c_double * 3),
        ("glow_max", ctypes.c_double * 3),
        ("density_cells", ctypes.c_uint32 * 3),
        ("glow_cells", ctypes.c_uint32 * 3),
        ("density", ctypes.c_void_p),
        ("glow", ctypes.c_void_p),
        ("parts", ctypes.c_void_p),
        ("scale_height", ctypes.c_double),
        ("origin", ctypes.c_double * 3),
        ("up", ctypes.c_double * 3),
        ("hidden_from", ctypes.c_uint32),
        ("light_set", ctypes.c_uint32),
        ("shadow_set", ctypes.c_uint32),
        ("lobe_count", ctypes.c_uint32),
        ("lobes", ctypes.c_void_p),
    ]


class Light(ctypes.Structure):
    _fields_ = [
        ("kind", ctypes.c_uint32),
        ("is_visible", ctypes.c_uint32),
        ("is_soft", ctypes.c_uint32),
        ("is_round", ctypes.c_uint32),
        ("position", ctypes.c_double * 3),
        ("axis", ctypes.c_double * 3),
        ("u", ctypes.c_double * 3),
        ("v", ctypes.c_double * 3),
        ("intensity", ctypes.c_double * 3),
        ("radiance", ctypes.c_double * 3),
        ("irradiance", ctypes.c_double * 3),
        ("axes", ctypes.c_double * 3 * 3),
        ("radius", ctypes.c_double),
        ("cosine", ctypes.c_double),
        ("blend", ctypes.c_double),
        ("spread", ctypes.c_double),
        ("angle", ctypes.c_double),
        ("reach", ctypes.c_double),
        ("rows", ctypes.c_uint32),
        ("columns", ctypes.c_uint32),
        ("triangle_count", ctypes.c_size_t),
        ("triangles", ctypes.c_void_p),
        ("cells", ctypes.c_void_p),
        ("is_own", ctypes.c_uint32),
        ("hidden_from", ctypes.c_uint32),
        ("unlit", ctypes.c_uint64),
        ("unshadowed", ctypes.c_uint64),
        ("falloff", ctypes.c_double),
        ("smooth", ctypes.c_double),
        ("most_events", ctypes.c_uint32),
        ("unused", ctypes.c_uint32),
    ]


class Camera(ctypes.Structure):
    _fields_ = [
        ("position", ctypes.c_double * 3),
        ("forward", ctypes.c_double * 3),
        ("up", ctypes.c_double * 3),
        ("half_height", ctypes.c_double),
        ("left", ctypes.c_double),
        ("top", ctypes.c_double),
        ("step", ctypes.c_double * 2),
        ("widest", ctypes.c_double),
        ("near", ctypes.c_double),
        ("aperture", ctypes.c_double),
        ("focus", ctypes.c_double),
        ("rotation", ctypes.c_double),
        ("ratio", ctypes.c_double),
        ("blades", ctypes.c_uint32),
        ("projection", ctypes.c_uint32),
        ("width", ctypes.c_uint32),
        ("height", ctypes.c_uint32),
        ("is_own", ctypes.c_uint32),
        ("unused", ctypes.c_uint32),
    ]


class Description(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("world_volume", ctypes.c_int32),
        ("fog_alone", ctypes.c_uint32),
        ("material_count", ctypes.c_uint32),
        ("materials", ctypes.c_void_p),
        ("object_count", ctypes.c_size_t),
        ("objects", ctypes.c_void_p),
        ("shape_count", ctypes.c_size_t),
        ("shapes", ctypes.c_void_p),
        ("volume_count", ctypes.c_size_t),
        ("volumes", ctypes.c_void_p),
        ("light_count", ctypes.c_size_t),
        ("lights", ctypes.c_void_p),
        ("camera", Camera),
    ]


class Mesh(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("material_count", ctypes.c_uint32),
        ("materials", ctypes.c_void_p),
        ("position_count", ctypes.c_size_t),
        ("positions", ctypes.c_void_p),
        ("triangle_count", ctypes.c_size_t),
        ("triangles", ctypes.c_void_p),
        ("normals", ctypes.c_void_p),
    ]


class Instance(ctypes.Structure):
    _fields_ = [
        ("matrix", ctypes.c_double * 16),
        ("mesh", ctypes.c_uint32),
        ("object", ctypes.c_int32),
        ("material", ctypes.c_int32),
    ]


class GeometryInfo(ctypes.Structure):
    _fields_ = [
        ("triangle_count", ctypes.c_uint64),
        ("memory", ctypes.c_uint64),
        ("min", ctypes.c_float * 3),
        ("max", ctypes.c_float * 3),
    ]


class SurfaceHit(ctypes.Structure):
    _fields_ = [
        ("distance", ctypes.c_float),
        ("position", ctypes.c_float * 3),
        ("geometric_normal", ctypes.c_float * 3),
        ("normal", ctypes.c_float * 3),
        ("material", ctypes.c_int32),
        ("object", ctypes.c_int32),
    ]


class HostRay(ctypes.Structure):
    _fields_ = [
        ("origin", ctypes.c_double * 3),
        ("direction", ctypes.c_double * 3),
        ("reach", ctypes.c_double),
    ]


class HostHit(ctypes.Structure):
    _fields_ = [
        ("distance", ctypes.c_float),
        ("position", ctypes.c_float * 3),
        ("geometric_normal", ctypes.c_float * 3),
        ("normal", ctypes.c_float * 3),
        ("offset", ctypes.c_float),
        ("tangent", ctypes.c_float * 3),
        ("along", ctypes.c_float),
        ("across", ctypes.c_float),
        ("twist", ctypes.c_float),
        ("object", ctypes.c_uint32),
        ("material", ctypes.c_uint32),
        ("mark", ctypes.c_uint32 * 3),
    ]


class HostMeeting(ctypes.Structure):
    _fields_ = [
        ("hit", HostHit),
        ("direction", ctypes.c_float * 3),
        ("xi", ctypes.c_float * 2),
    ]


class HostWay(ctypes.Structure):
    _fields_ = [
        ("factor", ctypes.c_float * 3),
        ("direction", ctypes.c_float * 3),
        ("deviation", ctypes.c_float),
    ]


class HostWays(ctypes.Structure):
    _fields_ = [
        ("diffuse", ctypes.c_float * 3),
        ("translucent", ctypes.c_float * 3),
        ("reflected", HostWay * 3),
        ("refracted", HostWay),
    ]


class HostDraw(ctypes.Structure):
    _fields_ = [
        ("light", ctypes.c_uint32),
        ("place", ctypes.c_float * 2),
        ("xi", ctypes.c_float * 2),
    ]


class HostPhoton(ctypes.Structure):
    _fields_ = [
        ("origin", ctypes.c_float * 3),
        ("direction", ctypes.c_float * 3),
        ("power", ctypes.c_float * 3),
        ("normal", ctypes.c_float * 3),
        ("radius", ctypes.c_float),
        ("angular_variance", ctypes.c_float),
    ]


class HostQuestion(ctypes.Structure):
    _fields_ = [
        ("light", ctypes.c_uint32),
        ("place", ctypes.c_float * 3),
        ("xi", ctypes.c_float * 2),
    ]


class HostArrival(ctypes.Structure):
    _fields_ = [
        ("density", ctypes.c_float * 3),
        ("from", ctypes.c_float * 3),
    ]


class HostPixel(ctypes.Structure):
    _fields_ = [
        ("place", ctypes.c_float * 2),
        ("lens", ctypes.c_float * 2),
    ]


class HostEyeRay(ctypes.Structure):
    _fields_ = [
        ("origin", ctypes.c_float * 3),
        ("direction", ctypes.c_float * 3),
    ]


class Host(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("version", ctypes.c_uint32),
        ("user", ctypes.c_void_p),
        ("cast", ctypes.c_void_p),
        ("blocked", ctypes.c_void_p),
        ("lobes", ctypes.c_void_p),
        ("scatter", ctypes.c_void_p),
        ("emit", ctypes.c_void_p),
        ("illuminate", ctypes.c_void_p),
        ("eye", ctypes.c_void_p),
        ("min", ctypes.c_float * 3),
        ("max", ctypes.c_float * 3),
    ]


class BounceLimits(ctypes.Structure):
    _fields_ = [
        ("limited", ctypes.c_uint32),
        ("total", ctypes.c_uint32),
        ("diffuse", ctypes.c_uint32),
        ("glossy", ctypes.c_uint32),
        ("transmission", ctypes.c_uint32),
        ("volume", ctypes.c_uint32),
        ("free_reflections", ctypes.c_uint32),
        ("free_transmissions", ctypes.c_uint32),
    ]


class SessionSettings(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("method", ctypes.c_uint32),
        ("seed", ctypes.c_uint32),
        ("photons", ctypes.c_uint32),
        ("grid", ctypes.c_uint32),
        ("most_events", ctypes.c_uint32),
        ("first_pass", ctypes.c_uint32),
        ("threads", ctypes.c_uint32),
        ("kinds_apart", ctypes.c_uint32),
        ("first_apart", ctypes.c_uint32),
        ("first_alone", ctypes.c_uint32),
        ("every_pixel", ctypes.c_uint32),
        ("radius", ctypes.c_double),
        ("error", ctypes.c_double),
        ("spawn", ctypes.c_void_p),
        ("spawn_user", ctypes.c_void_p),
        ("limits", BounceLimits),
    ]


class Goal(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("passes", ctypes.c_uint32),
        ("seconds", ctypes.c_double),
        ("error", ctypes.c_double),
    ]


class SessionInfo(ctypes.Structure):
    _fields_ = [
        ("seconds", ctypes.c_double * 6),
        ("picture_seconds", ctypes.c_double),
        ("pairs", ctypes.c_uint64),
        ("memory", ctypes.c_uint64),
        ("passes", ctypes.c_uint32),
        ("photons", ctypes.c_uint32),
        ("most_photons", ctypes.c_uint32),
        ("width", ctypes.c_uint32),
        ("height", ctypes.c_uint32),
        ("grid", GridLayout),
        ("radius", ctypes.c_float),
        ("max_radius", ctypes.c_float),
        ("plain_photons", ctypes.c_uint32),
        ("guided_photons", ctypes.c_uint32),
    ]


#: A letter for each parameter: see TYPES of _abi.
PROTOTYPES = {
    "covbeam_geometry_new": "p",
    "covbeam_geometry_free": "p",
    "covbeam_geometry_add_mesh": "ppp",
    "covbeam_geometry_add_instances": "pzpz",
    "covbeam_geometry_build": "ppp",
    "covbeam_geometry_get_info": "pp",
    "covbeam_geometry_cast": "pzpzpzpz",
    "covbeam_scene_new": "ppp",
    "covbeam_scene_free": "p",
    "covbeam_scene_new_of_host": "ppp",
    "covbeam_session_new": "zpzpppp",
    "covbeam_session_free": "p",
    "covbeam_session_pass": "ppp",
    "covbeam_session_until": "ppppp",
    "covbeam_session_restart": "puu",
    "covbeam_session_get_info": "pp",
    "covbeam_session_picture": "puzpzpp",
    "covbeam_session_save": "ppzp",
    "covbeam_session_merge": "ppzpp",
}
