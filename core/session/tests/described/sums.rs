//! Sums of sessions that share a picture's passes out: the bits of one that has rendered all.

use crate::scenes::{assert_same, fill, options, picture, session, shown, sphere_at, sphere_in_fog, view};
use covbeam_session::film::Picture;
use covbeam_session::film::passes::PassRange;
use covbeam_session::scene::Scene;
use covbeam_session::session::{Identity, Options, Session};
use covbeam_session::settings::{Layers, Settings};
use covbeam_session::work::failure::Failure;
use glam::Vec3;
use std::sync::Arc;

const IDENTITY: Identity = Identity([7; 32]);

/// From a pass on, without a pilot.
fn unguided(first_pass: u32) -> Options {
    let options = options(500);
    let settings = Settings { guided: false, ..options.settings };
    Options { settings, first_pass, identity: IDENTITY, ..options }
}

fn save(session: &Session) -> Vec<u8> {
    session.save(&mut || true).expect("there are passes")
}

#[track_caller]
fn merge(session: &Session, bytes: &[u8]) {
    session.merge(bytes, &mut || true).expect("they fit");
}

/// Half-open ranges of the passes of a session, as they are shown.
fn held(session: &Session) -> String {
    assert_eq!(session.passes().count(), session.info().passes);
    session.passes().to_string()
}

/// What sessions of some options have after so many passes each.
fn rendered<const N: usize>(scene: &Arc<Scene>, made: [(Options, u32); N]) -> [Session; N] {
    made.map(|(options, passes)| {
        let begun = session(scene, options);
        fill(&begun, passes);
        begun
    })
}

/// Kinds of light are parts of a picture that add up to it, but for roundings of single precision.
fn assert_parts(picture: &Picture) {
    for (pixel, all) in picture.radiance.iter().enumerate() {
        let sum: Vec3 = picture.kinds.iter().map(|(_, colors)| colors[pixel]).sum();
        assert!((sum - *all).abs().max_element() <= 1e-5 * all.max_element(), "{sum} is not {all}");
    }
}

#[test]
fn passes_of_two_sessions_add_up_to_the_bits_of_one_in_either_order() {
    let scene = sphere_in_fog(view(16));
    // Once with the pilot, which takes most of the time.
    for (layers, guided) in [(Layers::Together, false), (Layers::EachKind, true)] {
        let of = |first_pass| {
            let settings = Settings { layers, guided, ..options(1000).settings };
            Options { settings, first_pass, ..options(1000) }
        };
        let [whole, first, second, third] =
            rendered(&scene, [(of(0), 5), (of(0), 3), (of(3), 2), (of(9), 0)]);
        assert_eq!([held(&first), held(&second)], ["0..3", "3..5"]);
        let [one, two] = [save(&first), save(&second)];
        assert!(one != two);
        merge(&first, &two);
        merge(&second, &one);
        merge(&third, &two);
        merge(&third, &one);
        let (expected, bytes) = (shown(&whole), save(&whole));
        for merged in [&first, &second, &third] {
            assert_eq!(held(merged), "0..5");
            assert_same(&shown(merged), &expected);
            assert!(save(merged) == bytes, "the same passes have other sums");
        }
        if layers == Layers::EachKind {
            assert_eq!(expected.kinds.len(), 3);
            assert_parts(&expected);
        }
    }
}

#[test]
fn passes_after_a_merge_fill_the_gaps() {
    let scene = sphere_in_fog(view(16));
    let [whole, begun, apart, late] =
        rendered(&scene, [(unguided(0), 6), (unguided(0), 1), (unguided(2), 2), (unguided(3), 1)]);
    merge(&begun, &save(&apart));
    assert_eq!(begun.passes().ranges(), [PassRange { start: 0, end: 1 }, PassRange { start: 2, end: 4 }]);
    // Sums with a gap are saved as they are.
    let with_gap = save(&begun);
    for expected in ["0..4", "0..5", "0..6"] {
        fill(&begun, begun.info().passes + 1);
        assert_eq!(held(&begun), expected);
    }
    assert_same(&shown(&begun), &shown(&whole));
    let again = session(&scene, unguided(4));
    merge(&again, &with_gap);
    // From its first pass on: what is missing before that is left to others.
    fill(&again, 5);
    assert_eq!(held(&again), "0..1, 2..6");
    assert!(save(&begun) == save(&whole));
    // The one of a merged session that begins late.
    fill(&late, 2);
    assert_eq!(held(&late), "3..5");
    merge(&late, &save(&session_of(&scene, 0, 3)));
    fill(&late, 6);
    assert_same(&shown(&late), &shown(&whole));
}

fn session_of(scene: &Arc<Scene>, first_pass: u32, passes: u32) -> Session {
    let begun = session(scene, unguided(first_pass));
    fill(&begun, passes);
    begun
}

/// Panics unless bytes are refused and nothing is changed by that.
#[track_caller]
fn refused(session: &Session, bytes: &[u8], before: &Option<Vec<u8>>) -> String {
    let passes = session.passes();
    let Err(Failure::Data(message)) = session.merge(bytes, &mut || true) else {
        panic!("it was not refused");
    };
    assert!(message.starts_with("sums: ") && message.contains("; "), "{message}");
    assert_eq!(session.passes(), passes);
    assert!(session.save(&mut || true).ok() == *before, "what was refused has changed something: {message}");
    message
}

#[test]
fn sums_of_another_picture_or_of_the_same_passes_are_refused() {
    let scene = sphere_in_fog(view(16));
    let [begun, same, crossing, empty] =
        rendered(&scene, [(unguided(0), 2), (unguided(1), 1), (unguided(1), 2), (unguided(0), 0)]);
    let (before, expected) = (Some(save(&begun)), shown(&begun));
    for (other, passes) in [(&begun, "0..2"), (&same, "1..2"), (&crossing, "1..2")] {
        let message = refused(&begun, &save(other), &before);
        assert!(message.contains(&format!("passes {passes} are there")), "{message}");
    }

    let of = |scene: &Arc<Scene>, options: Options| {
        let other = session(scene, options);
        fill(&other, 1);
        save(&other)
    };
    let stranger = of(&scene, Options { identity: Identity([8; 32]), ..unguided(2) });
    let wide = of(&sphere_in_fog(view(17)), unguided(2));
    let settings = Settings { layers: Layers::EachKind, ..unguided(0).settings };
    let apart = of(&scene, Options { settings, ..unguided(2) });
    let settings = Settings { planned: false, ..unguided(0).settings };
    let unplanned = of(&scene, Options { settings, ..unguided(2) });
    let build = of_another_build(of(&scene, unguided(2)));
    for (bytes, what) in [
        (&stranger, "another scene"),
        (&wide, "another kind"),
        (&apart, "another kind"),
        (&build, "another libm"),
    ] {
        let message = refused(&begun, bytes, &before);
        assert!(message.contains(what), "{message}");
        // A session without passes has no picture yet, but knows what it will be of.
        refused(&empty, bytes, &None);
    }
    refused(&begun, &unplanned, &before);

    assert_same(&shown(&begun), &expected);
    merge(&begun, &save(&session_of(&scene, 2, 1)));
    assert_same(&shown(&begun), &picture(&session(&scene, unguided(0)), 3));
}

/// Sums whose header names another version or libm: after its length and CRC-32, the first word.
fn of_another_build(mut sums: Vec<u8>) -> Vec<u8> {
    let length = u32::from_le_bytes([sums[8], sums[9], sums[10], sums[11]]) as usize;
    sums[16] ^= 1;
    let crc = crc32fast::hash(&sums[16..16 + length]);
    sums[12..16].copy_from_slice(&crc.to_le_bytes());
    sums
}

#[test]
fn damaged_sums_are_refused_and_change_nothing() {
    let scene = sphere_in_fog(view(16));
    let [begun, other, empty] = rendered(&scene, [(unguided(0), 2), (unguided(2), 2), (unguided(0), 0)]);
    let (before, sums) = (Some(save(&begun)), save(&other));
    let expected = shown(&begun);
    let mut bad: Vec<Vec<u8>> = Vec::new();
    // No bytes, and then more and more of them.
    bad.extend((0..50).map(|part| sums[..part * sums.len() / 50].to_vec()));
    bad.push(sums[..sums.len() - 1].to_vec());
    bad.push([&sums[..], &[0]].concat());
    bad.push([&sums[..], &sums[..]].concat());
    bad.push(vec![0; sums.len()]);
    // Of every eleventh one all bits, of the others one or a few.
    bad.extend((0..200).map(|flip| {
        let mut bytes = sums.clone();
        bytes[flip * sums.len() / 200] ^=
            if flip % 11 == 0 { 255 } else { 1 << (flip % 8) | 1 << (flip / 8 % 8) };
        bytes
    }));
    // All of the header: magic, length, check, build, identity, passes and layout.
    bad.extend((0..100).map(|place| {
        let mut bytes = sums.clone();
        bytes[place] ^= 1 << (place % 8);
        bytes
    }));
    for bytes in &bad {
        refused(&begun, bytes, &before);
        refused(&empty, bytes, &None);
    }
    assert_same(&shown(&begun), &expected);
    let whole = picture(&session(&scene, unguided(0)), 4);
    merge(&begun, &sums);
    merge(&empty, &sums);
    fill(&empty, 4);
    for merged in [&begun, &empty] {
        assert_eq!(held(merged), "0..4");
        assert_same(&shown(merged), &whole);
    }
}

#[test]
fn passes_of_what_moves_add_up_to_the_same_bits_too() {
    let instants = [-0.3, 0.3].map(|x| sphere_at(x * Vec3::X, view(16)));
    let of = |first_pass, passes| {
        let begun = Session::new(&instants, unguided(first_pass), &mut || true).expect("valid");
        fill(&begun, passes);
        begun
    };
    let [whole, first, second] = [(0, 6), (0, 2), (2, 3)].map(|(first_pass, passes)| of(first_pass, passes));
    merge(&second, &save(&first));
    merge(&first, &save(&of(2, 3)));
    fill(&first, 6);
    fill(&second, 6);
    for merged in [&first, &second] {
        assert_eq!(held(merged), "0..6");
        assert_same(&shown(merged), &shown(&whole));
    }
}
