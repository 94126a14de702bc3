//! A message names the element and the field that is wrong, as C does.

use crate::beam::{beam, covbeam_beam};
use crate::eye_ray::{covbeam_eye_ray, eye_ray};
use crate::hostile::message;
use crate::image::spectrum::{covbeam_image_spectrum, image_spectrum};
use crate::light_field::field::{covbeam_light_field, light_field};
use crate::light_field::smooth_surface::{covbeam_curvature, curvature};
use crate::light_path::edge::covbeam_edge;
use crate::light_path::segment::{covbeam_segment, whole};
use crate::memory::{Element, Inputs};
use crate::spectrum::{covbeam_spectrum, spectrum};
use crate::status::Failure;

/// What is said of the second of three elements.
fn said<T: Copy, R>(value: T, name: &str, check: fn(Element<T>) -> Result<R, Failure>) -> String {
    let array = [value; 3];
    // SAFETY: an array of this function's.
    let inputs = unsafe { Inputs::new(array.as_ptr(), size_of::<T>(), 3, name) }.unwrap();
    assert!(check(inputs.get(1)).is_err());
    message()
}

/// For each field: a sound element with a NaN in it, and what the message begins with.
macro_rules! each_field {
    ($sound:expr, $check:path, $name:literal, [$($field:ident $([$index:literal])*),+]) => {
        $({
            let mut element = $sound;
            element.$field $([$index])* = f32::NAN;
            let expected = concat!($name, "[1].", stringify!($field), ": ");
            let found = said(element, $name, $check);
            assert!(found.starts_with(expected), "{found}, not {expected}");
        })+
    };
}

const BEAM: covbeam_beam = covbeam_beam {
    origin: [0.0; 3],
    direction: [0.0, 0.0, 1.0],
    length: 1.0,
    power: [1.0; 3],
    start_normal: [0.0; 3],
    end_normal: [0.0; 3],
};

fn field() -> covbeam_light_field {
    covbeam_core::LightField::point(glam::Vec3::Z, 1.0).into()
}

fn segment() -> covbeam_segment {
    let edge = covbeam_edge { depth: 1.0, distance: 0.5, towards: [1.0, 0.0, 0.0] };
    let second = covbeam_edge { depth: 2.0, ..edge };
    covbeam_segment {
        field: field(),
        origin: [0.0; 3],
        length: 3.0,
        power: 1.0,
        unscattered: 0,
        knots: core::ptr::null(),
        knot_count: 0,
        edges: [edge, second, edge, edge],
        edge_count: 2,
    }
}

#[test]
fn the_field_of_an_element_is_named() {
    each_field!(
        BEAM,
        beam,
        "beams",
        [origin[1], direction[2], length, power[0], start_normal[0], end_normal[2]]
    );
    let ray = covbeam_eye_ray { origin: [0.0; 3], direction: [1.0, 0.0, 0.0], length: 1.0 };
    each_field!(ray, eye_ray, "rays", [origin[0], direction[0], length]);
    each_field!(field(), light_field, "fields", [root[2], x_axis[0], direction[1]]);
    let bend = covbeam_curvature { tangent: [1.0, 0.0, 0.0], along: 1.0, across: 1.0, twist: 0.0 };
    each_field!(bend, curvature, "curvatures", [tangent[0], along, across, twist]);
    let found = covbeam_spectrum { xx: 1.0, yy: 1.0, zz: 1.0, xy: 0.0, xz: 0.0, yz: 0.0 };
    each_field!(found, spectrum, "spectra", [xx, yy, zz, xy, xz, yz]);
    let picture = covbeam_image_spectrum { xx: 1.0, xy: 0.0, yy: 1.0, weight: 1.0 };
    each_field!(picture, image_spectrum, "spectra", [xx, xy, yy, weight]);
    each_field!(segment(), whole, "segments", [origin[2], length, power]);
}

#[test]
fn fields_of_fields_and_elements_of_arrays_are_named() {
    let mut wrong = segment();
    wrong.edges[1].towards = [0.0; 3];
    assert_eq!(said(wrong, "segments", whole), "segments[1].edges[1].towards: has no direction: it is 0");
    wrong = segment();
    wrong.edges[1].depth = 0.5;
    assert_eq!(said(wrong, "segments", whole), "segments[1].edges[1].depth: edges are not sorted by depth");
    wrong = segment();
    wrong.field.root[0] = f32::INFINITY;
    assert_eq!(said(wrong, "segments", whole), "segments[1].field.root: inf is not finite");
    wrong = segment();
    wrong.edge_count = 5;
    assert_eq!(said(wrong, "segments", whole), "segments[1].edge_count: 5 is more than 4");
    let beams = covbeam_beam { direction: [0.0; 3], ..BEAM };
    let message = "beams[1].direction: [0.0, 0.0, 0.0] does not have length 1; normalise it";
    assert_eq!(said(beams, "beams", beam), message);
}

#[test]
fn a_beam_without_end_is_told_where_to_end() {
    let endless = covbeam_beam { length: f32::INFINITY, ..BEAM };
    let message = "beams[1].length: inf; end it where nothing is left to see, at covbeam_medium_reach";
    assert_eq!(said(endless, "beams", beam), message);
}
