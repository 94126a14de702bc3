"""The C ABI as ctypes sees it. The tests compare all of it with covbeam.h as a C compiler reads it."""

import ctypes

#: COVBEAM_ABI_VERSION of the header that this module was written for.
ABI_VERSION = 2

_vector = ctypes.c_float * 3


class GridLayout(ctypes.Structure):
    _fields_ = [("min", _vector), ("max", _vector), ("cells", ctypes.c_uint32 * 3)]


class Phase(ctypes.Structure):
    _fields_ = [("kind", ctypes.c_uint32), ("asymmetry", ctypes.c_float)]


class Medium(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("scattering", _vector),
        ("absorption", _vector),
        ("phase", Phase),
        ("density", ctypes.c_uint32),
        ("origin", _vector),
        ("up", _vector),
        ("scale_height", ctypes.c_float),
        ("voxels", ctypes.c_void_p),
    ]


class Column(ctypes.Structure):
    _fields_ = [
        ("kind", ctypes.c_uint32),
        ("density", ctypes.c_float),
        ("rate", ctypes.c_float),
        ("knots", ctypes.c_void_p),
        ("knot_count", ctypes.c_size_t),
    ]


class Kernel(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("shape", ctypes.c_uint32),
        ("min_radius", ctypes.c_float),
        ("max_radius", ctypes.c_float),
        ("error", ctypes.c_float),
    ]


class Schedule(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("shape", ctypes.c_uint32),
        ("radius", ctypes.c_float),
        ("alpha", ctypes.c_float),
        ("max_radius", ctypes.c_float),
        ("error", ctypes.c_float),
    ]


class MarchExpected(ctypes.Structure):
    _fields_ = [("radiance", ctypes.c_float), ("error", ctypes.c_float)]


Poll = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p)
# The user pointer is a number here: see _callbacks.
Shade = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)
Probe = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p)

#: The letters of PROTOTYPES: an address (data, handle or callback), size_t, float, uint32_t.
TYPES = {
    "p": ctypes.c_void_p,
    "z": ctypes.c_size_t,
    "f": ctypes.c_float,
    "u": ctypes.c_uint32,
}

#: Functions that do not return a covbeam_status.
RESULTS = {
    "covbeam_abi_version": ctypes.c_uint32,
    "covbeam_version": ctypes.c_char_p,
    "covbeam_last_error": ctypes.c_char_p,
    "covbeam_beam_map_free": None,
    "covbeam_density_free": None,
    "covbeam_grid_free": None,
    "covbeam_scratch_free": None,
    "covbeam_film_free": None,
    "covbeam_march_free": None,
    "covbeam_importance_free": None,
}

#: Parameters of every function that the module calls. One that has a form for arrays is called in that form only: a single
#: value is an array of one there too. An array is "pz", address and stride.
PROTOTYPES = {
    "covbeam_abi_version": "",
    "covbeam_version": "",
    "covbeam_last_error": "",
    "covbeam_light_fields_point": "z" + "pz" * 3,
    "covbeam_light_fields_disk": "z" + "pz" * 5,
    "covbeam_light_fields_collimated": "z" + "pz" * 3,
    "covbeam_light_fields_gaussian": "z" + "pz" * 5,
    "covbeam_light_fields_travel": "z" + "pz" * 2,
    "covbeam_light_fields_carry": "z" + "pz" + "p" + "pz" * 2,
    "covbeam_light_fields_rotate": "z" + "pz" * 2,
    "covbeam_light_fields_reflect": "z" + "pz" * 3,
    "covbeam_light_fields_refract": "z" + "pz" * 5,
    "covbeam_light_fields_occlude": "z" + "pz" * 3,
    "covbeam_light_fields_attenuate": "z" + "pz" * 3,
    "covbeam_light_fields_narrow": "z" + "pz" * 3,
    "covbeam_light_fields_scatter": "z" + "pz" * 3,
    "covbeam_light_fields_diffuse": "z" + "pz" * 3,
    "covbeam_light_fields_slice": "z" + "pz" * 2,
    "covbeam_light_fields_fluence": "z" + "pz" * 3,
    "covbeam_light_fields_variance_along_ray": "z" + "pz" * 3,
    "covbeam_spectra_variance_along": "z" + "pz" * 3,
    "covbeam_spectra_add_along": "z" + "pz" * 3,
    "covbeam_path_numbers": "uuz" + "pz" + "u" + "pz",
    "covbeam_find_edges": "p" * 6,
    "covbeam_segments_field_at": "z" + "pz" + "p" + "pz" * 2,
    "covbeam_phase_evaluate_many": "pz" + "pz" * 2,
    "covbeam_phase_sample_many": "pz" + "pz" * 3,
    "covbeam_phase_sample_cosine_many": "pz" + "pz" * 2,
    "covbeam_phase_angular_variance": "pp",
    "covbeam_medium_density_at_many": "pz" + "pz" * 2,
    "covbeam_medium_derivatives_at_many": "pz" + "pz" * 2,
    "covbeam_medium_step": "pp",
    "covbeam_medium_column_at_many": "pz" + "pz" * 4,
    "covbeam_medium_distance_at_many": "pz" + "pz" * 5,
    "covbeam_medium_transmittance_many": "pz" + "pz" * 4,
    "covbeam_medium_column_transmittance_many": "pz" + "pz" * 2,
    "covbeam_medium_opaque_column": "pp",
    "covbeam_medium_reach_many": "pz" + "pz" * 3,
    "covbeam_medium_knots": "pppfffpzp",
    "covbeam_medium_tabulate": "pppfpzp",
    "covbeam_medium_column": "ppppzp",
    "covbeam_column_at_many": "pz" + "pz" * 2,
    "covbeam_column_distance_at_many": "pz" + "pz" * 2,
    "covbeam_density_new": "ppzzp",
    "covbeam_density_free": "p",
    "covbeam_schedule_kernel": "pup",
    "covbeam_progressive_radius": "ffup",
    "covbeam_error_bound": "fup",
    "covbeam_kernel_evaluate": "uffp",
    "covbeam_kernel_second_moment": "up",
    "covbeam_kernel_radius_from_error": "uffp",
    "covbeam_kernel_radius_at_many": "ppz" + "pz" * 4,
    "covbeam_grid_new": "pp",
    "covbeam_grid_new_in": "ppzpzp",
    "covbeam_grid_free": "p",
    "covbeam_grid_get_layout": "pp",
    "covbeam_grid_clear": "p",
    "covbeam_grid_deposit": "ppzpz",
    "covbeam_grid_deposit_spectra": "pz" + "pz" * 3,
    "covbeam_grid_merge": "ppz",
    "covbeam_grid_resolve": "p",
    "covbeam_grid_look_up": "pz" + "pz" * 3,
    "covbeam_grid_get_cells": "ppp",
    "covbeam_grid_get_means": "ppp",
    "covbeam_grid_get_saved_size": "pp",
    "covbeam_grid_save": "ppz",
    "covbeam_grid_load": "pzp",
    "covbeam_beam_map_new": "pp",
    "covbeam_beam_map_free": "p",
    "covbeam_beam_map_clear": "p",
    "covbeam_beam_map_add": "pzpz",
    "covbeam_beam_map_commit": "pfpp",
    "covbeam_beam_map_get_count": "pp",
    "covbeam_beam_map_get_memory": "pp",
    "covbeam_beam_map_gather": "pppz" + "pz" * 2 + "ppp",
    "covbeam_beam_map_gather_shaded": "pppz" + "pz" * 2 + "pppp",
    "covbeam_scratch_new": "p",
    "covbeam_scratch_free": "p",
    "covbeam_cross_many": "pz" + "pz" * 3,
    "covbeam_gather_pairs": "pz" + "pz" * 3 + "pp" + "pz" + "ppp" + "pz",
    "covbeam_filter_beams": "pz" + "pz" + "f" + "pz",
    "covbeam_image_spectra_along": "ppz" + "pz" * 3,
    "covbeam_image_spectra_filter": "z" + "pz" * 4,
    "covbeam_image_filters_density": "z" + "pz" * 2,
    "covbeam_pixel_threshold_many": "uuz" + "pz" * 2,
    "covbeam_film_regions": "uuz" + "pz" * 2,
    "covbeam_film_new": "uufz" + "pz" + "p",
    "covbeam_film_free": "p",
    "covbeam_film_get_memory": "pp",
    "covbeam_film_get_node_count": "pp",
    "covbeam_film_nodes": "pz" + "pz",
    "covbeam_film_plan": "pufuz" + "pz" + "pp",
    "covbeam_film_density": "pz" + "pz",
    "covbeam_film_add": "pz" + "pz",
    "covbeam_film_verify": "ppp",
    "covbeam_film_picture": "puz" + "pz",
    "covbeam_film_errors": "uuz" + "pz" * 2,
    "covbeam_march_lay": "ppffp" + "zpz",
    "covbeam_march_new": "p",
    "covbeam_march_free": "p",
    "covbeam_march_update": "pzpz",
    "covbeam_march_get_expected": "pp",
    "covbeam_march_get_first_round": "pzp",
    "covbeam_march_place": "pz" + "pz" * 2,
    "covbeam_march_refine": "pzpz" + "z" + "pz" * 2,
    "covbeam_importance_new": "pp",
    "covbeam_importance_free": "p",
    "covbeam_importance_add_eye_rays": "ppz" + "pz" * 2,
    "covbeam_importance_add_paths": "ppz" + "pz" * 2,
    "covbeam_importance_add_surfaces": "pz" + "pz" * 2,
    "covbeam_importance_merge": "ppz",
    "covbeam_importance_resolve": "p",
    "covbeam_importance_at": "pz" + "pz" * 2,
    "covbeam_importance_of_segments": "ppz" + "pz" * 2,
    "covbeam_weight_window": "z" + "pz" + "f",
    "covbeam_emission_guide_fill": "upzfpz",
    "covbeam_emission_guide_warp": "upz" + "z" + "pz" * 3,
}
