//! Any bits in any argument.

use covbeam::{
    Column, CovarianceGrid, FluenceCell, FluenceGrid, GridCell, GridLayout, LightField, Medium, Segment, Vec3,
};
use proptest::prelude::*;

use super::{UNIT, resolved, spectrum};

fn any_bits() -> impl Strategy<Value = f32> {
    let special =
        [0.0, -0.0, 0.25, 0.5, 1.0, f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-45];
    prop_oneof![any::<u32>().prop_map(f32::from_bits), prop::sample::select(special.to_vec()), -0.5_f32..1.5]
}

fn any_vector() -> impl Strategy<Value = Vec3> {
    [any_bits(), any_bits(), any_bits()].prop_map(Vec3::from_array)
}

fn any_layout() -> impl Strategy<Value = GridLayout> {
    let random = (any_vector(), any_vector(), [0_u32..6, 0_u32..6, 0_u32..6])
        .prop_map(|(min, max, cells)| GridLayout { min, max, cells });
    prop_oneof![3 => Just(UNIT), 1 => random]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(80 * ProptestConfig::default().cases))]

    #[test]
    fn hostile_numbers_never_panic_and_never_reach_a_cell(
        layout in any_layout(),
        origin in any_vector(),
        direction in any_vector(),
        x_axis in any_vector(),
        root in prop::array::uniform10(any_bits()),
        values in prop::array::uniform6(any_bits()),
        [length, power, extinction] in [any_bits(), any_bits(), any_bits()],
    ) {
        let mut cells = vec![GridCell::default(); layout.cell_count().min(1000)];
        if let Ok(mut grid) = CovarianceGrid::new(layout, &mut cells) {
            grid.deposit_spectrum(origin, &spectrum(values), power);
            let field = LightField { root, x_axis, direction };
            let segment = Segment { origin, length, power, unscattered: true, field, edges: &[], column: Column::Uniform };
            grid.deposit(&Medium::homogeneous(0.0, extinction), &segment);
            let mut out = vec![FluenceCell::default(); layout.cell_count()];
            grid.resolve(&mut out).unwrap();
            for cell in &cells {
                prop_assert!(cell.weight >= 0.0 && cell.weight.is_finite());
                prop_assert!(cell.sum.iter().all(|sum| sum.is_finite()));
            }
            let look_up = FluenceGrid::new(layout, &out).unwrap();
            for cell in &out {
                prop_assert!(cell.weight >= 0.0 && cell.weight.is_finite());
                prop_assert!(cell.spectrum.to_array().iter().all(|value| value.is_finite()));
            }
            for at in [origin, direction, layout.min, layout.max] {
                if let Some(found) = look_up.look_up(at) {
                    prop_assert!(found.to_array().iter().all(|value| !value.is_nan()));
                }
            }
        }
    }

    #[test]
    fn cells_that_no_grid_wrote_resolve_to_no_data_instead_of_nan(
        sums in prop::array::uniform6(any::<u64>().prop_map(f64::from_bits)),
        weight in any::<u64>().prop_map(f64::from_bits),
    ) {
        let one = GridLayout { cells: [1; 3], ..UNIT };
        let out = resolved(one, &mut [GridCell { sum: sums, weight }]);
        prop_assert!(out[0].weight >= 0.0 && out[0].weight.is_finite());
        prop_assert!(out[0].spectrum.to_array().iter().all(|value| value.is_finite()));
    }
}
