//! What processors do differently: core's vector code meets none of it.

use crate::rooms::{code, sources};

#[test]
fn eight_numbers_side_by_side_meet_no_operation_that_processors_do_differently() {
    // Of NaN and of zeros of two signs the crate's least and greatest are the processor's choice; fused and approximate operations
    // round as it does.
    let forbidden = [".min(", ".max(", "_precise(", "reduce_", "clamp(", "mul_add", "mul_sub", "approximate"];
    let code = code(&sources("core/src"));
    for module in ["eight", "packet", "shade", "simd"] {
        let code = &code[&format!("beam_map/{module}.rs")];
        assert!(code.contains("fearless_simd"), "{module}");
        let found: Vec<&str> = forbidden.into_iter().filter(|name| code.contains(name)).collect();
        assert!(found.is_empty(), "{module}: {found:?}");
    }
}
