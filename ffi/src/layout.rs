//! The layout of every public struct and the values of every enum, as numbers: a change breaks hosts that are compiled already,
//! and so needs another `COVBEAM_ABI_VERSION`. `layout.h`, made from it, lets compilers of C and C++ assert the same
//! of the header.
#![cfg(target_pointer_width = "64")]

use crate::beam::covbeam_beam;
use crate::beam_map::shaded::{covbeam_contact, covbeam_shade};
use crate::eye_ray::{covbeam_eye_ray, covbeam_gathered};
use crate::film::picture::covbeam_film_pixel;
use crate::film::rays::covbeam_film_ray;
use crate::grid::cells::{covbeam_fluence_cell, covbeam_grid_cell};
use crate::image::filter::covbeam_image_filter;
use crate::image::spectrum::{covbeam_image_spectrum, covbeam_pixel_step};
use crate::importance::look_up::{covbeam_importance_cell, covbeam_segment_importance};
use crate::kernel::options::covbeam_kernel;
use crate::kernel::schedule::covbeam_schedule;
use crate::kernel::shape::covbeam_kernel_shape;
use crate::light_field::field::covbeam_light_field;
use crate::light_field::smooth_surface::covbeam_curvature;
use crate::light_path::edge::covbeam_edge;
use crate::light_path::find_edges::{covbeam_probe, covbeam_probe_hit};
use crate::light_path::segment::covbeam_segment;
use crate::march::expected::covbeam_march_expected;
use crate::march::knots::covbeam_march_knot;
use crate::march::rounds::covbeam_march_sample;
use crate::medium::column::covbeam_column;
use crate::medium::density::covbeam_derivatives;
use crate::medium::knots::covbeam_knot;
use crate::medium::options::{covbeam_density_kind, covbeam_medium};
use crate::medium::phase::{covbeam_phase, covbeam_phase_kind};
use crate::pair::cross::covbeam_crossing;
use crate::spectrum::covbeam_spectrum;
use crate::status::{covbeam_poll, covbeam_status};
use crate::version::COVBEAM_ABI_VERSION;
use crate::voxels::covbeam_grid_layout;
use core::mem::offset_of;

/// `name: size, alignment { field at offset }`
macro_rules! layout {
    ($($name:ident: $size:literal, $alignment:literal { $($field:ident $offset:literal),* })*) => {
        $(const _: () = {
            assert!(size_of::<$name>() == $size);
            assert!(align_of::<$name>() == $alignment);
            $(assert!(offset_of!($name, $field) == $offset);)*
        };)*
    };
}

layout! {
    covbeam_light_field: 64, 4 { root 0, x_axis 40, direction 52 }
    covbeam_curvature: 24, 4 { tangent 0, along 12, across 16, twist 20 }
    covbeam_spectrum: 24, 4 { xx 0, yy 4, zz 8, xy 12, xz 16, yz 20 }
    covbeam_grid_layout: 36, 4 { min 0, max 12, cells 24 }
    covbeam_grid_cell: 56, 8 { sum 0, weight 48 }
    covbeam_fluence_cell: 28, 4 { spectrum 0, weight 24 }
    covbeam_knot: 8, 4 { distance 0, column 4 }
    covbeam_edge: 20, 4 { depth 0, distance 4, towards 8 }
    covbeam_probe_hit: 20, 4 { distance 0, normal 4, offset 16 }
    covbeam_segment: 192, 8 {
        origin 0, length 12, power 16, unscattered 20, field 24, edges 88, edge_count 168, knots 176, knot_count 184
    }
    covbeam_phase: 8, 4 { kind 0, asymmetry 4 }
    covbeam_medium: 80, 8 {
        struct_size 0, scattering 4, absorption 16, phase 28, density 36, origin 40, up 52,
        scale_height 64, voxels 72
    }
    covbeam_column: 32, 8 { kind 0, density 4, rate 8, knots 16, knot_count 24 }
    covbeam_derivatives: 36, 4 { gradient 0, hessian 12 }
    covbeam_beam: 64, 4 { origin 0, direction 12, length 24, power 28, start_normal 40, end_normal 52 }
    covbeam_eye_ray: 28, 4 { origin 0, direction 12, length 24 }
    covbeam_gathered: 28, 4 { radiance 0, pairs 12, weight 16, radius 20, sigma 24 }
    covbeam_crossing: 28, 4 { ray_distance 0, beam_distance 4, gap 8, sin_theta 12, axis 16 }
    covbeam_contact: 44, 4 {
        position 0, ray 12, beam 16, ray_distance 20, beam_distance 24, cos_theta 28, kernel 32,
        radius 36, sigma 40
    }
    covbeam_kernel: 20, 4 { struct_size 0, shape 4, min_radius 8, max_radius 12, error 16 }
    covbeam_schedule: 24, 4 { struct_size 0, shape 4, radius 8, alpha 12, max_radius 16, error 20 }
    covbeam_pixel_step: 24, 4 { origin 0, direction 12 }
    covbeam_image_spectrum: 16, 4 { xx 0, xy 4, yy 8, weight 12 }
    covbeam_image_filter: 12, 4 { xx 0, xy 4, yy 8 }
    covbeam_film_ray: 40, 4 { pixel 0, has_volume 8, has_rest 12, volume 16, rest 28 }
    covbeam_film_pixel: 32, 4 { radiance 0, volume 12, variance 24, difference 28 }
    covbeam_march_knot: 16, 4 { distance 0, radiance 4, deviation 8, visibility 12 }
    covbeam_march_sample: 24, 8 { distance 0, weight 4, visibility 8, reserved 12, mass 16 }
    covbeam_march_expected: 8, 4 { radiance 0, error 4 }
    covbeam_importance_cell: 12, 4 { beam 0, scattered 4, surface 8 }
    covbeam_segment_importance: 12, 4 { beam 0, scattered 4, transmittance 8 }
    covbeam_status: 4, 4 {}
    covbeam_phase_kind: 4, 4 {}
    covbeam_density_kind: 4, 4 {}
    covbeam_kernel_shape: 4, 4 {}
    covbeam_poll: 8, 8 {}
    covbeam_shade: 8, 8 {}
    covbeam_probe: 8, 8 {}
}

macro_rules! values {
    ($($kind:ident { $($name:ident $value:literal,)* })*) => {
        $($(const _: () = assert!($kind::$name as i64 == $value);)*)*
    };
}

values! {
    covbeam_status {
        COVBEAM_OK 0,
        COVBEAM_NULL_POINTER 1,
        COVBEAM_MISALIGNED 2,
        COVBEAM_INVALID_VALUE 3,
        COVBEAM_INVALID_ARRAY 4,
        COVBEAM_SHORT_BUFFER 5,
        COVBEAM_INVALID_HANDLE 6,
        COVBEAM_WRONG_ORDER 7,
        COVBEAM_MISMATCH 8,
        COVBEAM_BAD_DATA 9,
        COVBEAM_OUT_OF_MEMORY 10,
        COVBEAM_CANCELLED 11,
        COVBEAM_CALLBACK_FAILED 12,
        COVBEAM_POISONED 13,
        COVBEAM_PANICKED 14,
        COVBEAM_BUSY 15,
    }
    covbeam_phase_kind {
        COVBEAM_PHASE_ISOTROPIC 0,
        COVBEAM_PHASE_HENYEY_GREENSTEIN 1,
        COVBEAM_PHASE_RAYLEIGH 2,
    }
    covbeam_density_kind {
        COVBEAM_DENSITY_UNIFORM 0,
        COVBEAM_DENSITY_EXPONENTIAL 1,
        COVBEAM_DENSITY_VOXELS 2,
    }
    covbeam_kernel_shape {
        COVBEAM_KERNEL_BOX 0,
        COVBEAM_KERNEL_EPANECHNIKOV 1,
        COVBEAM_KERNEL_BIWEIGHT 2,
    }
}

const _: () = assert!(COVBEAM_ABI_VERSION == 3);
