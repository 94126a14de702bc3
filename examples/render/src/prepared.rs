//! What passes need of earlier ones, in a file: the light fields in the voxels after each pass that traced some.
//!
//! A machine that renders a late pass would trace the light fields of all earlier ones; it reads one state instead.

use crate::output::{OutputError, replace_file};
use crate::pass::{FieldState, Renderer, latest_field_pass};
use crate::shard::Origin;
use crate::shard::planes::{MOST_BYTES, RUN, put, take};
use crate::stored::{Kind, Reason, StoredError, open, write_header, write_record};
use covbeam::GridCell;
use serde::{Deserialize, Serialize};
use std::path::Path;

const KIND: Kind =
    Kind { magic: b"covfield", format: 1, name: "file of light fields", writers: "`covbeam prepare`" };

/// Numbers of a voxel.
const WORDS: usize = 7;

#[derive(Serialize, Deserialize)]
struct Header {
    origin: Origin,
    /// Passes that it serves, from the first.
    passes: u32,
    /// Voxels of a layer, and layers.
    cells: [usize; 2],
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
    let mut header = Header { origin: origin.clone(), passes, cells: [0, 0], states: Vec::new() };
    let mut records = Vec::new();
    while let Some(after) = renderer.next_fields(passes) {
        let Some(state) = renderer.trace_fields(cancelled) else { return Ok(false) };
        header.cells = [state.layers.first().map_or(0, Vec::len), state.layers.len()];
        let record = encode(&state);
        header.states.push([after, record.len() as u32]);
        records.push(record);
        report(after);
    }
    replace_file(path, |file| {
        let crc = write_header(file, &KIND, &header)?;
        (0..).zip(&records).try_for_each(|(place, record)| write_record(file, crc, place, record))
    })?;
    Ok(true)
}

/// The light fields that were there before pass `index`, counted from 1; Err(Ok(…)): the file is of another render, and how it differs.
///
/// # Errors
/// A file that cannot be read, is damaged, or serves other passes.
pub fn read_prepared(
    path: &Path,
    origin: &Origin,
    index: u32,
) -> Result<Option<FieldState>, Result<String, StoredError>> {
    let failed = |reason| Err(StoredError::new(path, reason));
    let (header, mut records) = open::<Header>(path, &KIND).map_err(failed)?;
    if let Some(difference) = header.origin.difference(origin) {
        return Err(Ok(format!("it is of another render ({difference})")));
    }
    let wanted = latest_field_pass(index - 1);
    if wanted == 0 {
        return Ok(None);
    }
    let place = header.states.iter().position(|[after, _]| *after == wanted);
    let Some(place) = place.filter(|_| index - 1 <= header.passes) else {
        return Err(Ok(format!("it serves passes 0..{}", header.passes)));
    };
    let lengths: Vec<u32> = header.states[..place].iter().map(|[_, length]| *length).collect();
    let state = records.skip(&lengths).and_then(|()| {
        let [cells, layers] = header.cells;
        let most = cells.div_ceil(RUN).saturating_mul(layers).saturating_mul(WORDS * MOST_BYTES);
        decode(&records.next(most)?, wanted, header.cells)
    });
    state.map(Some).map_err(failed)
}

fn encode(state: &FieldState) -> Vec<u8> {
    let mut out = Vec::new();
    for cells in state.layers.iter().flat_map(|layer| layer.chunks(RUN)) {
        let mut planes = [[0; RUN]; WORDS];
        for (place, cell) in cells.iter().enumerate() {
            let numbers = cell.sum.iter().chain([&cell.weight]);
            planes.iter_mut().zip(numbers).for_each(|(plane, number)| plane[place] = number.to_bits());
        }
        planes.iter().for_each(|plane| put(plane, &mut out));
    }
    out
}

fn decode(mut bytes: &[u8], after: u32, [cells, layers]: [usize; 2]) -> Result<FieldState, Reason> {
    let mut state = FieldState { after, layers: Vec::new() };
    for _ in 0..layers {
        let mut layer = Vec::new();
        while layer.len() < cells {
            let mut planes = [[0; RUN]; WORDS];
            for plane in &mut planes {
                *plane = take(&mut bytes).map_err(|_| Reason::Damaged("a record holds no numbers"))?;
            }
            for place in 0..RUN.min(cells - layer.len()) {
                let [xx, xy, xz, yy, yz, zz, weight] = planes.map(|plane| f64::from_bits(plane[place]));
                layer.push(GridCell { sum: [xx, xy, xz, yy, yz, zz], weight });
            }
        }
        state.layers.push(layer);
    }
    if bytes.is_empty() { Ok(state) } else { Err(Reason::Damaged("a record goes on after its end")) }
}
