//! Prints the error of the light field's arithmetic on every hard case, beside the textbook form's.

use covbeam_tests::stability::{
    cases, errors, extinguished_beam, families, many_deposits, sensitivity, spread,
};
use covbeam_tests::twin::Big;

fn main() {
    println!(
        "Relative error of the fluence covariance against 1600 bits or more; determinant: of the slice."
    );
    println!(
        "textbook f32: 4x4 covariance. f32/f64: the same stored in f32, each operator computed in f64.\n"
    );
    println!(
        "{:<70} {:>9} {:>9} {:>11} {:>11} {:>9} {:>9}  reason",
        "case", "textbook", "f32/f64", "square root", "determinant", "tolerance", "inputs"
    );
    for case in cases() {
        let e = errors::<Big>(&case);
        let determinant = e.determinant.map_or("-".to_owned(), |d| format!("{d:.1e}"));
        println!(
            "{:<70} {:>9.1e} {:>9.1e} {:>11.1e} {determinant:>11} {:>9.0e} {:>9.1e}  {}",
            case.name,
            e.textbook,
            e.textbook_wide,
            e.square_root,
            case.tolerance,
            sensitivity::<Big>(&case),
            case.reason
        );
    }
    println!(
        "\nRandom paths, also those that end near a focus; strong: ways of 1e-3..1e3, curvatures of 0.01..100 \
         (median, 99 %, max)"
    );
    for family in families() {
        let s = spread(&family);
        let show = |[a, b, c]: [f64; 3]| format!("{a:.1e} {b:.1e} {c:.1e}");
        println!("{:<40} textbook {}, square root {}", family.name, show(s.textbook), show(s.square_root));
        if s.above > 0 {
            println!(
                "{:<40} {} above {:.0e}, by at most {:.1} times what neighbouring f32 inputs change",
                "", s.above, family.paths[0].tolerance, s.worst_in_units_of_sensitivity
            );
        }
    }
    let (error, filled) = extinguished_beam();
    println!("\nbeam through optical depth 200: {filled} of 100 voxels have data, worst error {error:.1e}");
    let (single, grid) = many_deposits(1_000_000_000);
    println!("1e9 deposits into one voxel: f32 running sums {single:.1e}, grid {grid:.1e}");
}
