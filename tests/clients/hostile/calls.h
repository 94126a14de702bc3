/*
 * Every function of the header, what its parameters are, and how it is called. Included several times, with macros that
 * make of each entry what is needed: CALL for functions that return a status, FREE for those that free, OTHER for the rest.
 *
 * A parameter is its name in the header and its kind:
 *   n count of the arrays after it; s stride of the array before; k number of elements of the packed array before
 *   $R a float under rule R; #shape, #pass, #extent (of a picture), #row (its first), #side (of a guide), #any an integer; poll, shade, probe, user
 *   @KIND a handle that is looked at, !KIND one that is changed, +KIND place for a new one; .STATE it must be in
 *   <TYPE read, >TYPE written, =TYPE both; TYPE a struct of types.c, or f:RULES floats
 *   ? may be NULL
 * Rules: see types.c.
 */
OTHER(covbeam_abi_version)
OTHER(covbeam_version)
CALL(covbeam_beam_map_new,
    "medium <medium; out +map",
    POINTER(0), POINTER(1))
FREE(covbeam_beam_map_free,
    "map !map",
    POINTER(0))
CALL(covbeam_beam_map_clear,
    "map !map",
    POINTER(0))
CALL(covbeam_beam_map_add,
    "map !map.adding; count n; beams <beam; beam_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3))
CALL(covbeam_beam_map_commit,
    "map !map.adding; max_radius $+; poll poll; user user",
    POINTER(0), NUMBER(1), POLL(2), POINTER(3))
CALL(covbeam_beam_map_get_count,
    "map @map; count >size",
    POINTER(0), POINTER(1))
CALL(covbeam_beam_map_get_memory,
    "map @map; bytes >size",
    POINTER(0), POINTER(1))
CALL(covbeam_scratch_new,
    "out +scratch",
    POINTER(0))
FREE(covbeam_scratch_free,
    "scratch !scratch?",
    POINTER(0))
CALL(covbeam_beam_map_gather,
    "map @map.committed; kernel <kernel; grid @grid.resolved?; count n; rays <ray; ray_stride s; "
    "gathered >gathered; gathered_stride s; scratch !scratch?; poll poll; user user",
    POINTER(0), POINTER(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7), POINTER(8),
    POLL(9), POINTER(10))
CALL(covbeam_beam_map_gather_shaded,
    "map @map.committed; kernel <kernel; grid @grid.resolved?; count n; rays <ray; ray_stride s; "
    "gathered >gathered; gathered_stride s; scratch !scratch?; shade shade; poll poll; user user",
    POINTER(0), POINTER(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7), POINTER(8),
    SHADE(9), POLL(10), POINTER(11))
CALL(covbeam_medium_knots,
    "medium <medium; origin <f:fff; direction <f:uuu; length $p; error $P; most $p; knots >knot; "
    "capacity k; count >size",
    POINTER(0), POINTER(1), POINTER(2), NUMBER(3), NUMBER(4), NUMBER(5), POINTER(6), SIZE(7), POINTER(8))
CALL(covbeam_medium_tabulate,
    "medium <medium; origin <f:fff; direction <f:uuu; length $p; knots >knot; capacity k; count >size",
    POINTER(0), POINTER(1), POINTER(2), NUMBER(3), POINTER(4), SIZE(5), POINTER(6))
CALL(covbeam_medium_column,
    "medium <medium; origin <f:fff; direction <f:uuu; knots <knot; knot_count k; column >column",
    POINTER(0), POINTER(1), POINTER(2), POINTER(3), SIZE(4), POINTER(5))
CALL(covbeam_column_at,
    "column <column; distance $p; value >f:p",
    POINTER(0), NUMBER(1), POINTER(2))
CALL(covbeam_column_at_many,
    "column <column; count n; distances <f:p; distance_stride s; values >f:p; value_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_column_distance_at,
    "column <column; value $p; distance >f:p",
    POINTER(0), NUMBER(1), POINTER(2))
CALL(covbeam_column_distance_at_many,
    "column <column; count n; values <f:p; value_stride s; distances >f:p; distance_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_density_new,
    "layout <layout; values <f:q; value_stride s; value_count k; out +density",
    POINTER(0), POINTER(1), SIZE(2), SIZE(3), POINTER(4))
FREE(covbeam_density_free,
    "density !density",
    POINTER(0))
CALL(covbeam_grid_new,
    "layout <layout; out +grid",
    POINTER(0), POINTER(1))
CALL(covbeam_grid_new_in,
    "layout <layout; cells =cell; cell_count k; means =mean; mean_count k; out +grid",
    POINTER(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5))
FREE(covbeam_grid_free,
    "grid !grid",
    POINTER(0))
CALL(covbeam_grid_get_layout,
    "grid @grid; layout >layout",
    POINTER(0), POINTER(1))
CALL(covbeam_grid_clear,
    "grid !grid",
    POINTER(0))
CALL(covbeam_grid_deposit,
    "grid !grid; medium <medium; count n; segments <segment; segment_stride s",
    POINTER(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4))
CALL(covbeam_segment_field_at,
    "segment <way; medium <medium; distance $q; out >field",
    POINTER(0), POINTER(1), NUMBER(2), POINTER(3))
CALL(covbeam_segments_field_at,
    "count n; segments <way; segment_stride s; medium <medium; distances <f:q; distance_stride s; out >field; "
    "out_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7))
CALL(covbeam_find_edges,
    "direction <f:uuu; hit <hit?; probe probe; user user; edges >edges; edge_count >word",
    POINTER(0), POINTER(1), PROBE(2), POINTER(3), POINTER(4), POINTER(5))
CALL(covbeam_path_number,
    "seed #any; sequence #any; path #any; dimension #any; number >f:r",
    WORD(0), WORD(1), WORD(2), WORD(3), POINTER(4))
CALL(covbeam_path_numbers,
    "seed #any; sequence #any; count n; paths <word; path_stride s; dimension #any; numbers >f:r; number_stride s",
    WORD(0), WORD(1), SIZE(2), POINTER(3), SIZE(4), WORD(5), POINTER(6), SIZE(7))
CALL(covbeam_grid_deposit_spectra,
    "grid !grid; count n; positions <f:fff; position_stride s; spectra <spectrum; spectrum_stride s; "
    "weights <f:q; weight_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7))
CALL(covbeam_grid_merge,
    "grid !grid; others <grids; other_count k",
    POINTER(0), POINTER(1), SIZE(2))
CALL(covbeam_grid_resolve,
    "grid !grid",
    POINTER(0))
CALL(covbeam_grid_look_up,
    "grid @grid.resolved; count n; positions <f:fff; position_stride s; spectra >spectrum; "
    "spectrum_stride s; found >flag?; found_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7))
CALL(covbeam_grid_get_cells,
    "grid @grid; cells >pointer; count >size",
    POINTER(0), POINTER(1), POINTER(2))
CALL(covbeam_grid_get_means,
    "grid @grid.resolved; means >pointer; count >size",
    POINTER(0), POINTER(1), POINTER(2))
CALL(covbeam_grid_get_saved_size,
    "grid @grid; size >size",
    POINTER(0), POINTER(1))
CALL(covbeam_grid_save,
    "grid @grid; bytes >byte; size k",
    POINTER(0), POINTER(1), SIZE(2))
CALL(covbeam_grid_load,
    "bytes <saved; size k; out +grid",
    POINTER(0), SIZE(1), POINTER(2))
CALL(covbeam_importance_new,
    "layout <layout; out +importance",
    POINTER(0), POINTER(1))
FREE(covbeam_importance_free,
    "importance !importance",
    POINTER(0))
CALL(covbeam_importance_add_eye_rays,
    "importance !importance; medium <medium; count n; rays <ray; ray_stride s; weights <f:q; weight_stride s",
    POINTER(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_importance_add_paths,
    "importance !importance; medium <medium; count n; paths <ray; path_stride s; weights <f:q; weight_stride s",
    POINTER(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_importance_add_surfaces,
    "importance !importance; count n; positions <f:fff; position_stride s; weights <f:q; weight_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_importance_merge,
    "importance !importance; others <importances; other_count k",
    POINTER(0), POINTER(1), SIZE(2))
CALL(covbeam_importance_resolve,
    "importance !importance",
    POINTER(0))
CALL(covbeam_importance_at,
    "importance @importance.resolved; count n; positions <f:fff; position_stride s; cells >worth; cell_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_importance_of_segments,
    "importance @importance.resolved; medium <medium; count n; segments <ray; segment_stride s; worths >worth; "
    "worth_stride s",
    POINTER(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_weight_window,
    "count n; factors =f:q; factor_stride s; u $r",
    SIZE(0), POINTER(1), SIZE(2), NUMBER(3))
CALL(covbeam_emission_guide_fill,
    "side #side; weights <f:q; weight_count k; even $L; guide >f:t; guide_count k",
    WORD(0), POINTER(1), SIZE(2), NUMBER(3), POINTER(4), SIZE(5))
CALL(covbeam_emission_guide_warp,
    "side #side; guide <f:E; guide_count k; count n; points <f:rr; point_stride s; places >f:rr; place_stride s; "
    "densities >f:+; density_stride s",
    WORD(0), POINTER(1), SIZE(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7), POINTER(8), SIZE(9))
CALL(covbeam_schedule_kernel,
    "schedule <schedule; pass #pass; kernel =kernel",
    POINTER(0), WORD(1), POINTER(2))
CALL(covbeam_progressive_radius,
    "radius $m; alpha $l; pass #pass; result >f:+",
    NUMBER(0), NUMBER(1), WORD(2), POINTER(3))
CALL(covbeam_error_bound,
    "error $+; pass #pass; result >f:+",
    NUMBER(0), WORD(1), POINTER(2))
CALL(covbeam_kernel_evaluate,
    "shape #shape; distance $f; radius $+; value >f:p",
    WORD(0), NUMBER(1), NUMBER(2), POINTER(3))
CALL(covbeam_kernel_second_moment,
    "shape #shape; moment >f:+",
    WORD(0), POINTER(1))
CALL(covbeam_kernel_radius_from_error,
    "shape #shape; error $+; variance $p; radius >f:p",
    WORD(0), NUMBER(1), NUMBER(2), POINTER(3))
CALL(covbeam_kernel_radius_at,
    "kernel <kernel; grid @grid.resolved?; position <f:fff; axis <f:uuu; radius >f:+; sigma >f:q",
    POINTER(0), POINTER(1), POINTER(2), POINTER(3), POINTER(4), POINTER(5))
CALL(covbeam_kernel_radius_at_many,
    "kernel <kernel; grid @grid.resolved?; count n; positions <f:fff; position_stride s; axes <f:uuu; "
    "axis_stride s; radii >f:+; radius_stride s; sigmas >f:q; sigma_stride s",
    POINTER(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6), POINTER(7), SIZE(8),
    POINTER(9), SIZE(10))
CALL(covbeam_light_field_point,
    "direction <f:ddd; angular_variance $p; out >field",
    POINTER(0), NUMBER(1), POINTER(2))
CALL(covbeam_light_field_disk,
    "direction <f:ddd; normal <f:ddd; radius $p; angular_variance $p; out >field",
    POINTER(0), POINTER(1), NUMBER(2), NUMBER(3), POINTER(4))
CALL(covbeam_light_field_collimated,
    "direction <f:ddd; radius $p; out >field",
    POINTER(0), NUMBER(1), POINTER(2))
CALL(covbeam_light_field_gaussian,
    "direction <f:ddd; x_axis <f:fff; spatial_variance <f:pp; angular_variance <f:pp; out >field",
    POINTER(0), POINTER(1), POINTER(2), POINTER(3), POINTER(4))
CALL(covbeam_light_field_travel,
    "field =field; distance $f",
    POINTER(0), NUMBER(1))
CALL(covbeam_light_field_carry,
    "field =field; medium <medium; origin <f:fff; distance $q",
    POINTER(0), POINTER(1), POINTER(2), NUMBER(3))
CALL(covbeam_light_field_rotate,
    "field =field; x_axis <f:ddd",
    POINTER(0), POINTER(1))
CALL(covbeam_light_field_reflect,
    "field =field; normal <f:ddd; curvature <curvature?",
    POINTER(0), POINTER(1), POINTER(2))
CALL(covbeam_light_field_refract,
    "field =field; normal <f:ddd; curvature <curvature?; eta $+; passed >flag",
    POINTER(0), POINTER(1), POINTER(2), NUMBER(3), POINTER(4))
CALL(covbeam_light_field_occlude,
    "field =field; towards_edge <f:ddd; distance $p",
    POINTER(0), POINTER(1), NUMBER(2))
CALL(covbeam_light_field_attenuate,
    "field =field; gradient <f:fff; hessian <f:ffffff",
    POINTER(0), POINTER(1), POINTER(2))
CALL(covbeam_light_field_narrow,
    "field =field; across <f:ddd; angular_variance $p",
    POINTER(0), POINTER(1), NUMBER(2))
CALL(covbeam_light_field_scatter,
    "field =field; direction <f:ddd; angular_variance $p",
    POINTER(0), POINTER(1), NUMBER(2))
CALL(covbeam_light_field_diffuse,
    "field =field; normal <f:ddd; direction <f:ddd",
    POINTER(0), POINTER(1), POINTER(2))
CALL(covbeam_light_field_slice,
    "field <field; variances >f:qfq",
    POINTER(0), POINTER(1))
CALL(covbeam_light_field_fluence,
    "field <field; limit $P; spectrum >spectrum",
    POINTER(0), NUMBER(1), POINTER(2))
CALL(covbeam_light_field_variance_along_ray,
    "field <field; extinction $q; variance >f:q",
    POINTER(0), NUMBER(1), POINTER(2))
CALL(covbeam_light_fields_point,
    "count n; directions <f:ddd; direction_stride s; angular_variances <f:p; angular_variance_stride s; "
    "out >field; out_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_light_fields_disk,
    "count n; directions <f:ddd; direction_stride s; normals <f:ddd; normal_stride s; radii <f:p; "
    "radius_stride s; angular_variances <f:p; angular_variance_stride s; out >field; out_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6), POINTER(7), SIZE(8),
    POINTER(9), SIZE(10))
CALL(covbeam_light_fields_collimated,
    "count n; directions <f:ddd; direction_stride s; radii <f:p; radius_stride s; out >field; out_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_light_fields_gaussian,
    "count n; directions <f:ddd; direction_stride s; x_axes <f:fff; x_axis_stride s; "
    "spatial_variances <f:pp; spatial_variance_stride s; angular_variances <f:pp; "
    "angular_variance_stride s; out >field; out_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6), POINTER(7), SIZE(8),
    POINTER(9), SIZE(10))
CALL(covbeam_light_fields_travel,
    "count n; fields =field; field_stride s; distances <f:f; distance_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4))
CALL(covbeam_light_fields_carry,
    "count n; fields =field; field_stride s; medium <medium; origins <f:fff; origin_stride s; "
    "distances <f:q; distance_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7))
CALL(covbeam_light_fields_rotate,
    "count n; fields =field; field_stride s; x_axes <f:ddd; x_axis_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4))
CALL(covbeam_light_fields_reflect,
    "count n; fields =field; field_stride s; normals <f:ddd; normal_stride s; curvatures <curvature?; "
    "curvature_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_light_fields_refract,
    "count n; fields =field; field_stride s; normals <f:ddd; normal_stride s; curvatures <curvature?; "
    "curvature_stride s; etas <f:+; eta_stride s; passed >flag; passed_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6), POINTER(7), SIZE(8),
    POINTER(9), SIZE(10))
CALL(covbeam_light_fields_occlude,
    "count n; fields =field; field_stride s; towards_edges <f:ddd; towards_edge_stride s; distances <f:p; "
    "distance_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_light_fields_attenuate,
    "count n; fields =field; field_stride s; gradients <f:fff; gradient_stride s; hessians <f:ffffff; "
    "hessian_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_light_fields_narrow,
    "count n; fields =field; field_stride s; acrosses <f:ddd; across_stride s; angular_variances <f:p; "
    "angular_variance_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_light_fields_scatter,
    "count n; fields =field; field_stride s; directions <f:ddd; direction_stride s; "
    "angular_variances <f:p; angular_variance_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_light_fields_diffuse,
    "count n; fields =field; field_stride s; normals <f:ddd; normal_stride s; directions <f:ddd; "
    "direction_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_light_fields_slice,
    "count n; fields <field; field_stride s; variances_out >f:qfq; out_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4))
CALL(covbeam_light_fields_fluence,
    "count n; fields <field; field_stride s; limits <f:P; limit_stride s; spectrum_out >spectrum; "
    "out_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_light_fields_variance_along_ray,
    "count n; fields <field; field_stride s; extinctions <f:q; extinction_stride s; variance_out >f:q; "
    "out_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_medium_density_at,
    "medium <medium; position <f:fff; density >f:q",
    POINTER(0), POINTER(1), POINTER(2))
CALL(covbeam_medium_density_at_many,
    "medium <medium; count n; positions <f:fff; position_stride s; densities >f:q; density_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_medium_derivatives_at,
    "medium <medium; position <f:fff; derivatives >derivatives",
    POINTER(0), POINTER(1), POINTER(2))
CALL(covbeam_medium_derivatives_at_many,
    "medium <medium; count n; positions <f:fff; position_stride s; derivatives >derivatives; "
    "derivative_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_medium_step,
    "medium <medium; step >f:P",
    POINTER(0), POINTER(1))
CALL(covbeam_medium_column_at,
    "medium <medium; origin <f:fff; direction <f:uuu; distance $p; column >f:p",
    POINTER(0), POINTER(1), POINTER(2), NUMBER(3), POINTER(4))
CALL(covbeam_medium_column_at_many,
    "medium <medium; count n; origins <f:fff; origin_stride s; directions <f:uuu; direction_stride s; "
    "distances <f:p; distance_stride s; columns >f:p; column_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7), POINTER(8), SIZE(9))
CALL(covbeam_medium_distance_at,
    "medium <medium; origin <f:fff; direction <f:uuu; length $p; column $p; distance >f:p",
    POINTER(0), POINTER(1), POINTER(2), NUMBER(3), NUMBER(4), POINTER(5))
CALL(covbeam_medium_distance_at_many,
    "medium <medium; count n; origins <f:fff; origin_stride s; directions <f:uuu; direction_stride s; "
    "lengths <f:p; length_stride s; columns <f:p; column_stride s; distances >f:p; distance_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7), POINTER(8),
    SIZE(9), POINTER(10), SIZE(11))
CALL(covbeam_medium_transmittance,
    "medium <medium; origin <f:fff; direction <f:uuu; distance $p; transmittance >f:ttt",
    POINTER(0), POINTER(1), POINTER(2), NUMBER(3), POINTER(4))
CALL(covbeam_medium_transmittance_many,
    "medium <medium; count n; origins <f:fff; origin_stride s; directions <f:uuu; direction_stride s; "
    "distances <f:p; distance_stride s; transmittances >f:ttt; transmittance_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7), POINTER(8), SIZE(9))
CALL(covbeam_medium_column_transmittance,
    "medium <medium; column $p; transmittance >f:ttt",
    POINTER(0), NUMBER(1), POINTER(2))
CALL(covbeam_medium_column_transmittance_many,
    "medium <medium; count n; columns <f:p; column_stride s; transmittances >f:ttt; transmittance_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_medium_opaque_column,
    "medium <medium; column >f:p",
    POINTER(0), POINTER(1))
CALL(covbeam_medium_reach,
    "medium <medium; origin <f:fff; direction <f:uuu; distance >f:p",
    POINTER(0), POINTER(1), POINTER(2), POINTER(3))
CALL(covbeam_medium_reach_many,
    "medium <medium; count n; origins <f:fff; origin_stride s; directions <f:uuu; direction_stride s; "
    "distances >f:p; distance_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7))
CALL(covbeam_cross,
    "ray <ray; beam <beam; crossing >crossing; crosses >flag",
    POINTER(0), POINTER(1), POINTER(2), POINTER(3))
CALL(covbeam_cross_many,
    "ray <ray; count n; beams <beam; beam_stride s; crossings >crossing; crossing_stride s; "
    "crosses >flag; cross_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7))
CALL(covbeam_gather_pair,
    "ray <ray; beam <beam; from $p; to $p; medium <medium; ray_column <column?; beam_column <column?; "
    "kernel <kernel; grid @grid.resolved?; gathered =gathered; accepted >flag",
    POINTER(0), POINTER(1), NUMBER(2), NUMBER(3), POINTER(4), POINTER(5), POINTER(6), POINTER(7),
    POINTER(8), POINTER(9), POINTER(10))
CALL(covbeam_gather_pairs,
    "ray <ray; count n; beams <beam; beam_stride s; froms <f:p; from_stride s; tos <f:p; to_stride s; "
    "medium <medium; ray_column <column?; beam_columns <column?; beam_column_stride s; kernel <kernel; "
    "grid @grid.resolved?; gathered =gathered; accepted >flag; accepted_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7), POINTER(8),
    POINTER(9), POINTER(10), SIZE(11), POINTER(12), POINTER(13), POINTER(14), POINTER(15), SIZE(16))
CALL(covbeam_filter_beams,
    "ray <ray; count n; beams <beam; beam_stride s; max_radius $+; masks >flag; mask_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), NUMBER(4), POINTER(5), SIZE(6))
CALL(covbeam_phase_evaluate,
    "phase <phase; cos_theta $c; value >f:q",
    POINTER(0), NUMBER(1), POINTER(2))
CALL(covbeam_phase_evaluate_many,
    "phase <phase; count n; cosines <f:c; cosine_stride s; values >f:q; value_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_phase_sample,
    "phase <phase; direction <f:uuu; xi <f:rr; scattered >f:uuu",
    POINTER(0), POINTER(1), POINTER(2), POINTER(3))
CALL(covbeam_phase_sample_many,
    "phase <phase; count n; directions <f:uuu; direction_stride s; xis <f:rr; xi_stride s; "
    "scattered >f:uuu; scattered_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7))
CALL(covbeam_phase_sample_cosine,
    "phase <phase; xi $r; cos_theta >f:c",
    POINTER(0), NUMBER(1), POINTER(2))
CALL(covbeam_phase_sample_cosine_many,
    "phase <phase; count n; xis <f:r; xi_stride s; cosines >f:c; cosine_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_phase_angular_variance,
    "phase <phase; variance >f:q",
    POINTER(0), POINTER(1))
CALL(covbeam_spectrum_variance_along,
    "spectrum <spectrum; axis <f:uuu; variance >f:q",
    POINTER(0), POINTER(1), POINTER(2))
CALL(covbeam_spectra_variance_along,
    "count n; spectra <spectrum; spectrum_stride s; axes <f:uuu; axis_stride s; variances >f:q; "
    "variance_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_spectrum_add_along,
    "spectrum =spectrum; axis <f:uuu; variance $q",
    POINTER(0), POINTER(1), NUMBER(2))
CALL(covbeam_spectra_add_along,
    "count n; spectra =spectrum; spectrum_stride s; axes <f:uuu; axis_stride s; variances <f:q; "
    "variance_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_image_spectrum_along,
    "grid @grid.resolved; medium <medium; ray <ray; steps <steps; spectrum >image",
    POINTER(0), POINTER(1), POINTER(2), POINTER(3), POINTER(4))
CALL(covbeam_image_spectra_along,
    "grid @grid.resolved; medium <medium; count n; rays <ray; ray_stride s; steps <steps; step_stride s; "
    "spectra >image; spectrum_stride s",
    POINTER(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6), POINTER(7), SIZE(8))
CALL(covbeam_image_spectrum_filter,
    "spectrum <image; error $+; widest $+; filter >filter",
    POINTER(0), NUMBER(1), NUMBER(2), POINTER(3))
CALL(covbeam_image_spectra_filter,
    "count n; spectra <image; spectrum_stride s; errors <f:+; error_stride s; widests <f:+; "
    "widest_stride s; filters >filter; filter_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6), POINTER(7), SIZE(8))
CALL(covbeam_image_filter_density,
    "filter <filter; density >f:l",
    POINTER(0), POINTER(1))
CALL(covbeam_image_filters_density,
    "count n; filters <filter; filter_stride s; densities >f:l; density_stride s",
    SIZE(0), POINTER(1), SIZE(2), POINTER(3), SIZE(4))
CALL(covbeam_pixel_threshold,
    "pass #any; seed #any; pixel <f:ii; threshold >f:r",
    WORD(0), WORD(1), POINTER(2), POINTER(3))
CALL(covbeam_pixel_threshold_many,
    "pass #any; seed #any; count n; pixels <f:ii; pixel_stride s; thresholds >f:r; threshold_stride s",
    WORD(0), WORD(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_film_regions,
    "width #extent; height #extent; count n; depths <f:*; depth_stride s; labels >f:i; label_stride s",
    WORD(0), WORD(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_film_new,
    "width #extent; height #extent; typical_radiance $+; count n; regions <f:i?; region_stride s; out +picture",
    WORD(0), WORD(1), NUMBER(2), SIZE(3), POINTER(4), SIZE(5), POINTER(6))
FREE(covbeam_film_free,
    "film !picture",
    POINTER(0))
CALL(covbeam_film_get_memory,
    "film @picture; bytes >size",
    POINTER(0), POINTER(1))
CALL(covbeam_film_get_node_count,
    "film @picture; count >size",
    POINTER(0), POINTER(1))
CALL(covbeam_film_nodes,
    "film @picture; count n; pixels >f:ii; pixel_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3))
CALL(covbeam_film_plan,
    "film !picture; pass #any; error $+; light_paths #any; count n; spectra <image; spectrum_stride s; "
    "poll poll; user user",
    POINTER(0), WORD(1), NUMBER(2), WORD(3), SIZE(4), POINTER(5), SIZE(6), POLL(7), POINTER(8))
CALL(covbeam_film_density,
    "film @picture.resolved; count n; densities >f:l; density_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3))
CALL(covbeam_film_add,
    "film !picture.resolved; count n; rays <seen; ray_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3))
CALL(covbeam_film_verify,
    "film !picture; poll poll; user user",
    POINTER(0), POLL(1), POINTER(2))
CALL(covbeam_film_picture,
    "film @picture.committed; first_row #row; count n; pixels >shown; pixel_stride s",
    POINTER(0), WORD(1), SIZE(2), POINTER(3), SIZE(4))
CALL(covbeam_film_errors,
    "width #extent; height #extent; count n; pixels <pixel; pixel_stride s; errors >f:q; error_stride s",
    WORD(0), WORD(1), SIZE(2), POINTER(3), SIZE(4), POINTER(5), SIZE(6))
CALL(covbeam_march_lay,
    "origin <f:fff; direction <f:uuu; from $f; to $N; light <f:fff; count n; knots >place; knot_stride s",
    POINTER(0), POINTER(1), NUMBER(2), NUMBER(3), POINTER(4), SIZE(5), POINTER(6), SIZE(7))
CALL(covbeam_march_new,
    "out +march",
    POINTER(0))
FREE(covbeam_march_free,
    "march !march",
    POINTER(0))
CALL(covbeam_march_update,
    "march !march; count n; knots <place; knot_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3))
CALL(covbeam_march_get_expected,
    "march @march.resolved; expected >f:qq",
    POINTER(0), POINTER(1))
CALL(covbeam_march_get_first_round,
    "march @march.resolved; rays #any; first >size",
    POINTER(0), SIZE(1), POINTER(2))
CALL(covbeam_march_place,
    "march !march.resolved; count n; jitters <f:r; jitter_stride s; samples >aim; sample_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), POINTER(4), SIZE(5))
CALL(covbeam_march_refine,
    "march !march.resolved; first_count n; firsts <aim; first_stride s; count n; jitters <f:r; "
    "jitter_stride s; samples >aim; sample_stride s",
    POINTER(0), SIZE(1), POINTER(2), SIZE(3), SIZE(4), POINTER(5), SIZE(6), POINTER(7), SIZE(8))
OTHER(covbeam_status_name)
OTHER(covbeam_last_error)
