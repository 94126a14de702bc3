"""The C ABI as ctypes sees it. Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit."""

import ctypes

#: COVBEAM_ABI_VERSION of the header that this module was written for.
ABI_VERSION = 3


class GridLayout(ctypes.Structure):
    _fields_ = [
        ("min", ctypes.c_float * 3),
        ("max", ctypes.c_float * 3),
        ("cells", ctypes.c_uint32 * 3),
    ]


class Phase(ctypes.Structure):
    _fields_ = [
        ("kind", ctypes.c_uint32),
        ("asymmetry", ctypes.c_float),
    ]


class Medium(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("scattering", ctypes.c_float * 3),
        ("absorption", ctypes.c_float * 3),
        ("phase", Phase),
        ("density", ctypes.c_uint32),
        ("origin", ctypes.c_float * 3),
        ("up", ctypes.c_float * 3),
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
    _fields_ = [
        ("radiance", ctypes.c_float),
        ("error", ctypes.c_float),
    ]


Poll = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p)
# The user pointer is a number here: see _callbacks.
Shade = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)
Probe = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p)

#: The letters of PROTOTYPES: an address (data, handle or callback), size_t, float, uint32_t, int32_t.
TYPES = {
    "p": ctypes.c_void_p,
    "z": ctypes.c_size_t,
    "f": ctypes.c_float,
    "u": ctypes.c_uint32,
    "i": ctypes.c_int32,
}

#: Functions that do not return a covbeam_status.
RESULTS = {
    "covbeam_abi_version": ctypes.c_uint32,
    "covbeam_version": ctypes.c_char_p,
    "covbeam_status_name": ctypes.c_char_p,
    "covbeam_last_error": ctypes.c_char_p,
}

#: Parameters of every function that the library exports.
PROTOTYPES = {
    "covbeam_abi_version": "",
    "covbeam_version": "",
    "covbeam_status_name": "i",
    "covbeam_last_error": "",
    "covbeam_light_fields_point": "zpzpzpz",
    "covbeam_light_fields_disk": "zpzpzpzpzpz",
    "covbeam_light_fields_collimated": "zpzpzpz",
    "covbeam_light_fields_gaussian": "zpzpzpzpzpz",
    "covbeam_light_fields_travel": "zpzpz",
    "covbeam_light_fields_carry": "zpzppzpz",
    "covbeam_light_fields_rotate": "zpzpz",
    "covbeam_light_fields_reflect": "zpzpzpz",
    "covbeam_light_fields_refract": "zpzpzpzpzpz",
    "covbeam_light_fields_occlude": "zpzpzpz",
    "covbeam_light_fields_attenuate": "zpzpzpz",
    "covbeam_light_fields_narrow": "zpzpzpz",
    "covbeam_light_fields_scatter": "zpzpzpz",
    "covbeam_light_fields_diffuse": "zpzpzpz",
    "covbeam_light_fields_slice": "zpzpz",
    "covbeam_light_fields_fluence": "zpzpzpz",
    "covbeam_light_fields_variance_along_ray": "zpzpzpz",
    "covbeam_phase_evaluate_many": "pzpzpz",
    "covbeam_phase_sample_many": "pzpzpzpz",
    "covbeam_phase_sample_cosine_many": "pzpzpz",
    "covbeam_phase_angular_variance": "pp",
    "covbeam_density_new": "ppzzp",
    "covbeam_density_free": "p",
    "covbeam_medium_density_at_many": "pzpzpz",
    "covbeam_medium_derivatives_at_many": "pzpzpz",
    "covbeam_medium_step": "pp",
    "covbeam_medium_column_at_many": "pzpzpzpzpz",
    "covbeam_medium_distance_at_many": "pzpzpzpzpzpz",
    "covbeam_medium_transmittance_many": "pzpzpzpzpz",
    "covbeam_medium_column_transmittance_many": "pzpzpz",
    "covbeam_medium_opaque_column": "pp",
    "covbeam_medium_reach_many": "pzpzpzpz",
    "covbeam_medium_knots": "pppfffpzp",
    "covbeam_medium_tabulate": "pppfpzp",
    "covbeam_medium_column": "ppppzp",
    "covbeam_column_at_many": "pzpzpz",
    "covbeam_column_distance_at_many": "pzpzpz",
    "covbeam_spectra_variance_along": "zpzpzpz",
    "covbeam_spectra_add_along": "zpzpzpz",
    "covbeam_path_numbers": "uuzpzupz",
    "covbeam_emission_guide_fill": "upzfpz",
    "covbeam_emission_guide_warp": "upzzpzpzpz",
    "covbeam_find_edges": "pppppp",
    "covbeam_segments_field_at": "zpzppzpz",
    "covbeam_grid_new": "pp",
    "covbeam_grid_new_in": "ppzpzp",
    "covbeam_grid_free": "p",
    "covbeam_grid_get_layout": "pp",
    "covbeam_grid_clear": "p",
    "covbeam_grid_deposit": "ppzpzpp",
    "covbeam_grid_deposit_spectra": "pzpzpzpz",
    "covbeam_grid_merge": "ppz",
    "covbeam_grid_resolve": "p",
    "covbeam_grid_look_up": "pzpzpzpz",
    "covbeam_grid_get_cells": "ppp",
    "covbeam_grid_get_means": "ppp",
    "covbeam_grid_get_saved_size": "pp",
    "covbeam_grid_save": "ppz",
    "covbeam_grid_load": "pzp",
    "covbeam_schedule_kernel": "pup",
    "covbeam_progressive_radius": "ffup",
    "covbeam_error_bound": "fup",
    "covbeam_kernel_evaluate": "uffp",
    "covbeam_kernel_second_moment": "up",
    "covbeam_kernel_radius_from_error": "uffp",
    "covbeam_kernel_radius_at_many": "ppzpzpzpzpz",
    "covbeam_beam_map_new": "pp",
    "covbeam_beam_map_free": "p",
    "covbeam_beam_map_clear": "p",
    "covbeam_beam_map_add": "pzpz",
    "covbeam_beam_map_commit": "pfpp",
    "covbeam_beam_map_get_count": "pp",
    "covbeam_beam_map_get_memory": "pp",
    "covbeam_scratch_new": "p",
    "covbeam_scratch_free": "p",
    "covbeam_beam_map_gather": "pppzpzpzppp",
    "covbeam_beam_map_gather_shaded": "pppzpzpzpppp",
    "covbeam_cross_many": "pzpzpzpz",
    "covbeam_gather_pairs": "pzpzpzpzpppzppppz",
    "covbeam_filter_beams": "pzpzfpz",
    "covbeam_image_spectra_along": "ppzpzpzpz",
    "covbeam_image_spectra_filter": "zpzpzpzpz",
    "covbeam_image_filters_density": "zpzpz",
    "covbeam_pixel_threshold_many": "uuzpzpz",
    "covbeam_film_regions": "uuzpzpz",
    "covbeam_film_new": "uufzpzp",
    "covbeam_film_free": "p",
    "covbeam_film_get_memory": "pp",
    "covbeam_film_get_node_count": "pp",
    "covbeam_film_nodes": "pzpz",
    "covbeam_film_plan": "pufuzpzpp",
    "covbeam_film_density": "pzpz",
    "covbeam_film_add": "pzpz",
    "covbeam_film_verify": "ppp",
    "covbeam_film_picture": "puzpz",
    "covbeam_film_errors": "uuzpzpz",
    "covbeam_march_lay": "ppffpzpz",
    "covbeam_march_new": "p",
    "covbeam_march_free": "p",
    "covbeam_march_update": "pzpz",
    "covbeam_march_get_expected": "pp",
    "covbeam_march_get_first_round": "pzp",
    "covbeam_march_place": "pzpzpz",
    "covbeam_march_refine": "pzpzzpzpz",
    "covbeam_importance_new": "pp",
    "covbeam_importance_free": "p",
    "covbeam_importance_add_eye_rays": "ppzpzpz",
    "covbeam_importance_add_paths": "ppzpzpz",
    "covbeam_importance_add_surfaces": "pzpzpz",
    "covbeam_importance_merge": "ppz",
    "covbeam_importance_resolve": "p",
    "covbeam_importance_at": "pzpzpz",
    "covbeam_importance_of_segments": "ppzpzpz",
    "covbeam_weight_window": "zpzf",
}
