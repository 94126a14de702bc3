//! Passes whose light paths carry light fields.

/// Every one of the first passes traces light fields, and after them one pass in so many: the grid's own noise falls with the number of
/// light fields, and later ones change it little. Where surfaces scatter much light they cost as much as all the rest of a pass.
const FIRST_FIELD_PASSES: u32 = 8;
const FIELD_PASS_EVERY: u32 = 8;

/// From some pass on, each time that the passes double so many of them trace light fields: what a late pass needs of all earlier ones must not
/// grow with its number, or a thousand machines would wait for it.
const FIELD_PASSES_A_DOUBLING: u32 = 4;

/// How many of passes 1 to `passes` trace light fields.
pub fn field_passes(passes: u32) -> u32 {
    let mut count = 0;
    let mut pass = next_field_pass(0);
    while pass <= passes {
        count += 1;
        pass = next_field_pass(pass);
    }
    count
}

/// The last pass up to `index` whose paths carry light fields; 0 = none.
pub fn latest_field_pass(index: u32) -> u32 {
    index - index % field_pass_step(index)
}

/// The first pass after `pass` whose paths carry light fields.
pub(super) fn next_field_pass(pass: u32) -> u32 {
    (pass - pass % field_pass_step(pass)).saturating_add(field_pass_step(pass))
}

/// One pass in so many around this one traces light fields: a power of two.
fn field_pass_step(pass: u32) -> u32 {
    match pass {
        ..FIRST_FIELD_PASSES => 1,
        _ => ((1 << pass.ilog2()) / FIELD_PASSES_A_DOUBLING).max(FIELD_PASS_EVERY),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_with_light_fields_follow_one_another() {
        let mut found = vec![];
        while found.last() < Some(&512) {
            found.push(next_field_pass(*found.last().unwrap_or(&0)));
        }
        let expected = [
            1, 2, 3, 4, 5, 6, 7, 8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 112, 128, 160, 192, 224, 256, 320,
            384, 448, 512,
        ];
        assert_eq!(found, expected);
        assert_eq!(latest_field_pass(u32::MAX), 7 << 29);
        for passes in 0..=512 {
            let seen: Vec<u32> = found.iter().copied().filter(|pass| *pass <= passes).collect();
            assert_eq!(latest_field_pass(passes), seen.last().copied().unwrap_or(0));
            assert_eq!(field_passes(passes), seen.len() as u32);
        }
    }
}
