//! What passes need of earlier ones, in a file: the light fields in the voxels after each pass that traced some.
//!
//! A machine that renders a late pass would trace the light fields of all earlier ones; it reads one state instead.

use crate::files::output::{OutputError, replace_file};
use crate::files::shard::Origin;
use crate::files::stored::{Kind, Reason, StoredError, open, write_header, write_record};
use covbeam_session::pass::{FieldState, Renderer, latest_field_pass};
use serde::{Deserialize, Serialize};
use std::path::Path;

const KIND: Kind =
    Kind { magic: b"covfield", format: 2, name: "file of light fields", writers: "`covbeam prepare`" };

#[derive(Serialize, Deserialize)]
struct Header {
    origin: Origin,
    /// Passes that it serves, from the first.
    passes: u32,
    /// By state: after which pass, counted from 1, and bytes of its record.
    states: Vec<[u32; 2]>,
}

/// Traces the light fields of passes `1..=passes` and writes the voxels after each. False = cancelled: nothing is written.
///
/// # Errors
/// As [`replace_file`].
pub fn write_prepared(
    path: &Path,
    origin: &Origin,
    renderer: &mut Renderer,
    passes: u32,
    cancelled: &(dyn Fn() -> bool + Sync),
    mut report: impl FnMut(u32),
) -> Result<bool, OutputError> {
    let mut header = Header { origin: origin.clone(), passes, states: Vec::new() };
    let mut records = Vec::new();
    while let Some(after) = renderer.next_fields(passes) {
        let Some(state) = renderer.trace_fields(cancelled) else { return Ok(false) };
        header.states.push([after, state.grids.len() as u32]);
        records.push(state.grids);
        report(after);
    }
    replace_file(path, |file| {
        let crc = write_header(file, &KIND, &header)?;
        (0..).zip(&records).try_for_each(|(place, record)| write_record(file, crc, place, record))
    })?;
    Ok(true)
}

/// The light fields that were there before pass `index`, counted from 1; None: there were none.
///
/// # Errors
/// A file that cannot be read, is damaged, is of another render, or serves other passes.
pub fn read_prepared(path: &Path, origin: &Origin, index: u32) -> Result<Option<FieldState>, StoredError> {
    read_state(path, origin, index - 1).map_err(|reason| StoredError::new(path, reason))
}

fn read_state(path: &Path, origin: &Origin, passes: u32) -> Result<Option<FieldState>, Reason> {
    let (header, mut records) = open::<Header>(path, &KIND)?;
    let stranger = |why| Err(Reason::Stranger(format!("{why}; make it with `covbeam prepare`")));
    if let Some(difference) = header.origin.difference(origin) {
        return stranger(format!("it is of another render ({difference})"));
    }
    let after = latest_field_pass(passes);
    if after == 0 {
        return Ok(None);
    }
    let place = header.states.iter().position(|[state, _]| *state == after);
    let Some(place) = place.filter(|_| passes <= header.passes) else {
        return stranger(format!("it serves passes 0..{}", header.passes));
    };
    let lengths: Vec<u32> = header.states.iter().map(|[_, length]| *length).collect();
    records.skip(&lengths[..place])?;
    Ok(Some(FieldState { after, grids: records.next(lengths[place] as usize)? }))
}
