"""The beams of a pass: added, committed to a hierarchy, gathered by eye rays."""

import ctypes

from ._arrays import COUNT, Kind, elementwise, given, made, struct
from ._callbacks import Call
from ._handles import Object, Owner, using
from ._library import check, lib
from .dtypes import BEAM, EYE_RAY, GATHERED
from .kernel import Kernel
from .media import Medium


class Scratch(Object):
    """Memory that gathers need, kept from call to call: one a thread."""

    def __init__(self):
        self._owner = Owner(lib.covbeam_scratch_new, lib.covbeam_scratch_free)


class BeamMap(Object):
    """The beams of one medium and one pass. The cycle of a pass: clear, add (any number of times), commit, gather (any number).

    - medium: what the beams run through; its Density is kept alive. For gather_shaded: any homogeneous one.
    """

    def __init__(self, medium):
        self._owner = Owner(lib.covbeam_beam_map_new, lib.covbeam_beam_map_free, struct("medium", medium, Medium))

    def clear(self):
        """Begins a pass: forgets all beams, keeps their memory."""
        with using(changed=self) as [beams]:
            check(lib.covbeam_beam_map_clear(beams))

    def add(self, beams):
        """Adds beams: BEAM of shape () or (n,), copied. Their order matters, how they are cut into batches does not."""
        with using(changed=self) as [handle]:
            elementwise(lib.covbeam_beam_map_add, handle, COUNT, given("beams", beams, Kind(BEAM)))

    def commit(self, max_radius, *, poll=None):
        """Builds the hierarchy over the beams: about 1 us a beam. Stopped, the map is as before.

        - max_radius: largest kernel radius that it will be gathered with [m] > 0: Kernel.max_radius.
        - poll: a function asked every few milliseconds: True to go on, False raises Cancelled; what it raises ends the call.
        """
        call = Call(poll)
        with using(changed=self) as [beams]:
            call.check(lib.covbeam_beam_map_commit(beams, max_radius, call.poll, None))

    @property
    def count(self):
        """How many beams the map has."""
        return self._number(lib.covbeam_beam_map_get_count)

    @property
    def memory(self):
        """How much memory the map holds [bytes]."""
        return self._number(lib.covbeam_beam_map_get_memory)

    def _number(self, function):
        number = ctypes.c_size_t()
        with using(self) as [beams]:
            check(function(beams, ctypes.addressof(number)))
        return number.value

    def gather(self, kernel, grid, rays, *, out=None, scratch=None, poll=None):
        """Gathers the light that beams scatter into eye rays: GATHERED. Stopped or failed, nothing is written.

        - kernel: a Kernel; its max_radius at most that of commit.
        - grid: a Grid that has been resolved, for kernels as wide as the light's bandwidth allows. None: kernel.min_radius.
        - rays: EYE_RAY of shape () or (n,), all in the map's medium. Each 64 that follow each other share one walk through the
          hierarchy: give those of a tile of 8x8 pixels together.
        - scratch: a Scratch; None allocates for this call.
        - poll: as in commit.
        """
        call = Call(poll)
        return self._gather(lib.covbeam_beam_map_gather, kernel, grid, rays, out, scratch, call, [call.poll])

    def gather_shaded(self, kernel, grid, rays, shade, *, out=None, scratch=None, poll=None):
        """`gather` in a medium that only you know.

        - shade: a function (contacts, values) called with up to 256 contacts at a time, CONTACT of shape (m,), read-only. It fills
          values, float32 of shape (m, 3) and 0 before, with scattering coefficient x phase function x transmittance along the
          eye ray x transmittance along the beam, both up to the contact, per channel [1/(m sr)]. The arrays are used again for
          the next batch: copy what you keep. What it raises ends the call.
        """
        if shade is None:
            raise TypeError("shade: None; give a function (contacts, values)")
        call = Call(poll, shade)
        return self._gather(
            lib.covbeam_beam_map_gather_shaded, kernel, grid, rays, out, scratch, call, [call.shade, call.poll]
        )

    def _gather(self, function, kernel, grid, rays, out, scratch, call, callbacks):
        with using(self, grid, changed=scratch) as [beams, spectra, *memory]:
            return elementwise(
                function,
                beams,
                struct("kernel", kernel, Kernel),
                spectra,
                COUNT,
                given("rays", rays, Kind(EYE_RAY)),
                made("out", out, Kind(GATHERED)),
                memory[0] if memory else None,
                *callbacks,
                None,
                ended=call.check,
            )
