//! The calls of `tests/vectors.txt`: what the core answers, for the clients of the C ABI in every language to compare with.
//!
//! The file pins that all languages give the same bits. It says nothing about their truth, which the other tests judge.
//!
//! One call a line, `name inputs... -> outputs...`, and comments after `#`. The name is that of the C function without
//! `covbeam_`. A word is the bit pattern of a number in hexadecimal: 8 digits for an f32 or u32 (a u8 is written as u32), 16
//! for a u64. The inputs are the C parameters in their order, structs by their fields, arrays element by element; left out
//! are `struct_size`, handles, pointers, counts and strides. What is changed in place is the first input and the last output.
//!
//! Lines follow each other like calls: there is one density, grid, map, film and march at a time. A medium of kind 2 has the
//! current density. `use_grid` (0 or 1) says whether the grid is passed. Several elements stand one after the other:
//!
//! ```text
//! medium      scattering[3] absorption[3] phase.kind phase.asymmetry density origin[3] up[3] scale_height
//! kernel      shape min_radius max_radius error        schedule  shape radius alpha max_radius error
//! segment     origin[3] length power unscattered field[16] edge_count edge[5]..., without knots
//! density_new layout[9] value... ->                  grid_new layout[9] ->
//! segment_field_at segment medium distance -> field[16]  path_number seed sequence path dimension -> number
//! grid_deposit medium segment... ->                  grid_deposit_spectra position[3] spectrum[6] weight ->
//! grid_resolve ->                                    grid_look_up position[3]... -> (found spectrum[6])...
//! grid_save -> size (16 digits) FNV-1a of the bytes (16 digits)
//! beam_map_new medium ->                             beam_map_add beam[16]... ->
//! beam_map_commit max_radius ->                         beam_map_clear ->
//! beam_map_gather use_grid kernel ray[7]... -> gathered[7]...
//! gather_pair use_grid medium kernel from to ray[7] beam[16] -> accepted gathered[7], from zero, columns NULL
//! kernel_radius_at use_grid kernel position[3] axis[3] -> radius sigma
//! cross ray[7] beam[16] -> crosses crossing[7]       filter_beams ray[7] beam[16]... max_radius -> mask...
//! medium_knots medium origin[3] direction[3] length error most -> knot[2]...
//! medium_tabulate medium origin[3] direction[3] length -> knot[2]...
//! image_spectrum_along medium ray[7] steps[12] -> spectrum[4]
//! pixel_threshold pass seed x y -> threshold         film_regions width height depth... -> label...
//! film_new width height typical_radiance region... ->    film_nodes -> (x y)...
//! film_plan pass error light_paths spectrum[4]... -> film_density -> density...
//! film_add ray[10]... ->                             film_picture -> pixel[8]..., once verified
//! film_errors width height (variance difference)... -> error...
//! march_lay origin[3] direction[3] from to light[3] count -> distance...       march_update knot[4]... ->
//! march_get_expected -> radiance error               march_get_first_round rays -> first
//! march_place jitter... -> sample[6]...              march_refine first_count sample[6]... jitter... -> sample[6]...
//! importance_new layout[9] ->                       importance_add_eye_rays medium (ray[7] weight)... ->
//! importance_add_paths medium (ray[7] weight)... ->  importance_add_surfaces (position[3] weight)... ->
//! importance_resolve ->                              importance_at position[3]... -> cell[3]...
//! importance_of_segments medium ray[7]... -> worth[3]...  weight_window expected... u -> factor...
//! emission_guide_fill side weight... even -> number...
//! emission_guide_warp side number... (point[2])... -> (place[2] density)...
//! light_field_refract field[16] normal[3] curvature[6] eta -> passed field[16]
//! ```

mod film;
mod grids;
mod hard;
mod importance;
mod kernels;
mod light;
mod maps;
mod march;
mod media;
mod words;

use words::Script;
pub use words::fnv;

/// What `tests/vectors.txt` must contain.
pub fn text() -> String {
    let mut script = Script::new();
    script.comment("Made by `cargo run -p covbeam-tests --bin vectors`; the format is described in tests/src/vectors/mod.rs.");
    light::write(&mut script);
    kernels::write(&mut script);
    media::write(&mut script);
    grids::write(&mut script);
    maps::write(&mut script);
    film::write(&mut script);
    march::write(&mut script);
    importance::write(&mut script);
    script.into_text()
}
