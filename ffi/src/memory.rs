//! The host's memory: pointers and strided arrays, checked before they are touched.

use crate::status::{Failure, covbeam_status::*, fail};
use core::fmt;
use core::marker::PhantomData;
use core::mem::MaybeUninit;

/// Refuses NULL and misaligned pointers.
pub(crate) fn aligned<T>(pointer: *const T, name: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(fail(COVBEAM_NULL_POINTER, format_args!("{name}: NULL")));
    }
    if !pointer.is_aligned() {
        let message = format_args!("{name}: not a multiple of {} bytes", align_of::<T>());
        return Err(fail(COVBEAM_MISALIGNED, message));
    }
    Ok(())
}

/// Reads one value.
pub(crate) unsafe fn read<T: Copy>(pointer: *const T, name: &str) -> Result<T, Failure> {
    aligned(pointer, name)?;
    // SAFETY: not NULL, aligned; readable by the host's promise. `T` is a plain struct of numbers and pointers.
    Ok(unsafe { pointer.read() })
}

/// Reads an options struct, which begins with its size as the host was compiled with it. A smaller one leaves
/// the later fields 0; a larger one is accepted if what this library does not know is 0.
///
/// - `least`: bytes that every version had.
pub(crate) unsafe fn read_options<T: Copy>(
    pointer: *const T,
    least: usize,
    name: &str,
) -> Result<T, Failure> {
    /// No options struct will ever be longer: what a host claims beyond is not read.
    const MOST: usize = 4096;
    aligned(pointer, name)?;
    // SAFETY: not NULL and aligned; by the host's promise at least `least` bytes, which begin with a u32.
    let size = unsafe { pointer.cast::<u32>().read() } as usize;
    if !(least..=MOST).contains(&size) {
        let message =
            format_args!("{name}: struct_size is {size}; set it to sizeof(*{name}), here {}", size_of::<T>());
        return Err(fail(COVBEAM_INVALID_VALUE, message));
    }
    // SAFETY: the host says that so many bytes are there.
    let bytes = unsafe { core::slice::from_raw_parts(pointer.cast::<u8>(), size) };
    if bytes.iter().skip(size_of::<T>()).any(|byte| *byte != 0) {
        let message = format_args!("{name}: has options that this version of the library does not know");
        return Err(fail(COVBEAM_INVALID_VALUE, message));
    }
    let mut options = MaybeUninit::<T>::zeroed();
    let known = size.min(size_of::<T>());
    // SAFETY: both are valid for `known` bytes and apart; `T` is a plain struct of numbers and pointers, for which every
    // pattern of bits is a value.
    unsafe {
        options.as_mut_ptr().cast::<u8>().copy_from_nonoverlapping(bytes.as_ptr(), known);
        Ok(options.assume_init())
    }
}

/// Where one result goes.
pub(crate) struct Slot<T>(*mut T);

impl<T: Copy> Slot<T> {
    /// Checks the pointer; nothing is written yet.
    pub(crate) fn new(pointer: *mut T, name: &str) -> Result<Self, Failure> {
        aligned(pointer, name)?;
        Ok(Self(pointer))
    }

    pub(crate) fn set(self, value: T) {
        // SAFETY: checked by `new`; writable by the host's promise.
        unsafe { self.0.write(value) }
    }
}

/// Whether an array of `count` elements, `stride` bytes apart, can lie at `pointer`. One without elements lies
/// anywhere.
fn fits<T>(pointer: *const T, stride: usize, count: usize, name: &str) -> Result<(), Failure> {
    if count == 0 {
        return Ok(());
    }
    aligned(pointer, name)?;
    if !stride.is_multiple_of(align_of::<T>()) {
        let message = format_args!("{name}: the stride {stride} is not a multiple of {}", align_of::<T>());
        return Err(fail(COVBEAM_MISALIGNED, message));
    }
    // One element that is repeated stands for as many as memory could hold.
    let end = (count - 1)
        .checked_mul(if stride == 0 { size_of::<T>() } else { stride })
        .and_then(|offset| offset.checked_add(size_of::<T>()))
        .filter(|bytes| *bytes <= isize::MAX as usize)
        .and_then(|bytes| pointer.addr().checked_add(if stride == 0 { size_of::<T>() } else { bytes }));
    if end.is_none() {
        let message =
            format_args!("{name}: {count} elements, {stride} bytes apart, are more than memory has");
        return Err(fail(COVBEAM_INVALID_ARRAY, message));
    }
    Ok(())
}

/// A slice of an array without gaps.
///
/// # Safety
/// NULL, or readable while the result lives.
pub(crate) unsafe fn array<'a, T: Copy>(
    first: *const T,
    count: usize,
    name: &str,
) -> Result<&'a [T], Failure> {
    fits(first, size_of::<T>(), count, name)?;
    // SAFETY: checked above; readable by this function's contract. `T` is a plain struct of numbers and pointers.
    Ok(if count == 0 { &[] } else { unsafe { core::slice::from_raw_parts(first, count) } })
}

/// An array that is read: element i lies at `first` + i x `stride` bytes. A stride of 0 repeats one element.
pub(crate) struct Inputs<'a, T> {
    first: *const T,
    stride: usize,
    count: usize,
    name: &'a str,
}

impl<'a, T: Copy> Inputs<'a, T> {
    /// # Safety
    /// The array is readable while this lives.
    pub(crate) unsafe fn new(
        first: *const T,
        stride: usize,
        count: usize,
        name: &'a str,
    ) -> Result<Self, Failure> {
        fits(first, stride, count, name)?;
        Ok(Self { first, stride, count, name })
    }

    /// Like `new`; none where the array is NULL.
    ///
    /// # Safety
    /// NULL, or readable while this lives.
    pub(crate) unsafe fn optional(
        first: *const T,
        stride: usize,
        count: usize,
        name: &'a str,
    ) -> Result<Option<Self>, Failure> {
        if first.is_null() {
            return Ok(None);
        }
        // SAFETY: by this function's contract.
        unsafe { Self::new(first, stride, count, name) }.map(Some)
    }

    #[inline(always)]
    pub(crate) fn get(&self, index: usize) -> Element<'a, T> {
        assert!(index < self.count);
        // SAFETY: inside the array that `new` checked, readable by its contract; a plain struct.
        let value = unsafe { self.first.byte_add(index * self.stride).read() };
        let index = (self.count > 1).then_some(index);
        Element { value, place: Place { name: self.name, index, ..Place::default() } }
    }
}

/// An element of an array, with what a message calls it.
#[derive(Clone, Copy)]
pub(crate) struct Element<'a, T> {
    pub(crate) value: T,
    place: Place<'a>,
}

/// What a message calls an element, as C names it but for the dot: `segments[3].edges[1].distance`.
#[derive(Clone, Copy, Default)]
struct Place<'a> {
    name: &'a str,
    /// None for the only one.
    index: Option<usize>,
    /// The part of it, and the part of that; an empty name is no part.
    outer: Part,
    inner: Part,
}

/// A field of a struct, or an element of an array in one.
#[derive(Clone, Copy, Default)]
struct Part {
    name: &'static str,
    index: Option<usize>,
}

// Inlined, so that a check that passes never writes down where: a gather was 1 % slower for it.
impl<'a, T: Copy> Element<'a, T> {
    /// A parameter that is no array.
    pub(crate) fn single(value: T, name: &'a str) -> Self {
        Self { value, place: Place { name, ..Place::default() } }
    }

    /// A parameter that is a pointer to one value.
    ///
    /// # Safety
    /// NULL, or readable.
    pub(crate) unsafe fn read(pointer: *const T, name: &'a str) -> Result<Self, Failure> {
        // SAFETY: by this function's contract.
        Ok(Self::single(unsafe { read(pointer, name) }?, name))
    }

    /// A part of this element, under the same name.
    #[inline(always)]
    pub(crate) fn part<U>(&self, part: impl FnOnce(T) -> U) -> Element<'a, U> {
        Element { value: part(self.value), place: self.place }
    }

    /// A field of this element, under its own name: see [`field!`]. Of fields of fields of fields the outer two are named.
    #[inline(always)]
    pub(crate) fn field<U>(
        &self,
        name: &'static str,
        index: Option<usize>,
        field: impl FnOnce(T) -> U,
    ) -> Element<'a, U> {
        let mut found = self.part(field);
        let part = Part { name, index };
        if found.place.outer.name.is_empty() {
            found.place.outer = part;
        } else if found.place.inner.name.is_empty() {
            found.place.inner = part;
        }
        found
    }

    /// The failure that says of this element that it is `what`.
    #[inline(always)]
    pub(crate) fn is(self, what: core::fmt::Arguments) -> Failure {
        self.place.is(what)
    }
}

impl Place<'_> {
    #[cold]
    #[inline(never)]
    fn is(self, what: core::fmt::Arguments) -> Failure {
        fail(COVBEAM_INVALID_VALUE, format_args!("{self}: {what}"))
    }
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name)?;
        self.index.map_or(Ok(()), |index| write!(f, "[{index}]"))?;
        for part in [self.outer, self.inner].iter().filter(|part| !part.name.is_empty()) {
            write!(f, ".{}", part.name)?;
            part.index.map_or(Ok(()), |index| write!(f, "[{index}]"))?;
        }
        Ok(())
    }
}

/// A field of an element, or an element of such an array: `field!(beam, direction)` is "beams[12].direction" in a message,
/// `field!(segment, edges[1])` "segments[3].edges[1]".
macro_rules! field {
    ($element:expr, $name:ident) => {
        $element.field(stringify!($name), None, |value| value.$name)
    };
    ($element:expr, $name:ident[$index:expr]) => {
        $element.field(stringify!($name), Some($index), |value| value.$name[$index])
    };
}
pub(crate) use field;

/// An array that is written, or read and written.
pub(crate) struct Outputs<'a, T> {
    first: *mut T,
    stride: usize,
    count: usize,
    name: &'a str,
    unique: PhantomData<&'a mut T>,
}

impl<'a, T: Copy> Outputs<'a, T> {
    /// # Safety
    /// The array is writable while this lives; readable too, if `get` is called.
    pub(crate) unsafe fn new(
        first: *mut T,
        stride: usize,
        count: usize,
        name: &'a str,
    ) -> Result<Self, Failure> {
        fits(first, stride, count, name)?;
        if count > 1 && stride < size_of::<T>() {
            let message = format_args!(
                "{name}: with a stride of {stride} bytes, elements of {} overlap",
                size_of::<T>()
            );
            return Err(fail(COVBEAM_INVALID_ARRAY, message));
        }
        Ok(Self { first, stride, count, name, unique: PhantomData })
    }

    pub(crate) fn count(&self) -> usize {
        self.count
    }

    pub(crate) fn get(&self, index: usize) -> Element<'a, T> {
        assert!(index < self.count);
        // SAFETY: inside the array that `new` checked, readable by its contract; a plain struct.
        let value = unsafe { self.first.byte_add(index * self.stride).read() };
        let index = (self.count > 1).then_some(index);
        Element { value, place: Place { name: self.name, index, ..Place::default() } }
    }

    pub(crate) fn set(&mut self, index: usize, value: T) {
        assert!(index < self.count);
        // SAFETY: inside the array that `new` checked, writable by its contract.
        unsafe { self.first.byte_add(index * self.stride).write(value) }
    }
}

/// Checks the array of a parameter that is read, and names the result like the parameter: `inputs!(count,
/// directions: [f32; 3], direction_stride)`. The type is left out where the pointer has it.
macro_rules! inputs {
    ($count:expr, $name:ident $(: $type:ty)?, $stride:expr) => {
        // SAFETY: the promise of the ABI's callers: what a parameter shows is readable during the call.
        let $name = unsafe {
            $crate::memory::Inputs::new($name$(.cast::<$type>())?, $stride, $count, stringify!($name))
        }?;
    };
}
pub(crate) use inputs;

/// Like [`inputs`], for an array that is written, or read and written.
macro_rules! outputs {
    ($count:expr, $name:ident $(: $type:ty)?, $stride:expr) => {
        // SAFETY: the promise of the ABI's callers: what a parameter shows is writable during the call.
        #[allow(unused_mut)]
        let mut $name = unsafe {
            $crate::memory::Outputs::new($name$(.cast::<$type>())?, $stride, $count, stringify!($name))
        }?;
    };
}
pub(crate) use outputs;

/// Says that two structs have the same layout: arrays of the host's are read as the core's without a copy.
macro_rules! same_layout {
    ($ours:ty, $core:ty, $last:ident) => {
        const _: () = assert!(
            size_of::<$ours>() == size_of::<$core>()
                && align_of::<$ours>() == align_of::<$core>()
                && core::mem::offset_of!($ours, $last) == core::mem::offset_of!($core, $last)
        );
    };
}
pub(crate) use same_layout;
