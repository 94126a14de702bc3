/*
 * covbeam_extra.h: what hosts that gather beams do not need, for those with hierarchies, kernels or grids of their own:
 * pairs of beam and eye ray, columns as tables, the parts of kernels and filters, spectra, voxels of a grid. Of the same
 * library, under the conventions of covbeam.h.
 * MIT or Apache-2.0. Made from ffi/src; do not edit.
 */

#ifndef COVBEAM_EXTRA_H
#define COVBEAM_EXTRA_H

#include "covbeam.h"

