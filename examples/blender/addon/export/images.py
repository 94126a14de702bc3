# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of images."""

import numpy as np

from .working_space import from_rec709

#: A sky has no more columns than this: a third of a degree each.
SKY_COLUMNS = 1024


def mean_colour(image):
    """Mean colour and alpha of a bpy.types.Image, float64 (4,), or None if it has no pixels to read, or they are not plain."""
    pixels = _pixels(image)
    if pixels is None or not is_plain(image):
        return None
    # A million pixels are enough for a mean; an odd stride does not follow rows.
    pixels = pixels[:: len(pixels) >> 20 | 1]
    # Grey has one channel, or two with alpha.
    colours = pixels[:, (0, 1, 2) if image.channels >= 3 else (0, 0, 0)]
    alpha = float(np.mean(pixels[:, -1], dtype=np.float64)) if image.channels in (2, 4) else 1.0
    return np.array([*np.mean(linear(image, colours), axis=0, dtype=np.float64), alpha])


def picture(image):
    """Colours and alpha of a bpy.types.Image between which Cycles interpolates: float64 (h, w, 4), the bottom row first; or None if it has
    no pixels to read.

    They are as the image keeps them, for `linear`, and times alpha where `is_multiplied` says so.
    """
    pixels = _pixels(image)
    if pixels is None:
        return None
    width, height = image.size
    # Grey has one channel, or two with alpha.
    chosen = (0, 1, 2) if image.channels >= 3 else (0, 0, 0)
    alpha = pixels[:, -1:] if image.channels in (2, 4) else np.ones((len(pixels), 1))
    if image.alpha_mode == "NONE":
        alpha = np.ones_like(alpha)
    colour = pixels[:, chosen]
    # Those of floats are kept like that.
    if is_multiplied(image) and not image.is_float:
        colour = colour * alpha
    found = np.concatenate([colour, alpha], axis=1)
    return np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0).reshape(height, width, 4).astype(np.float64)


def is_multiplied(image):
    """Whether Cycles sees the colours of a bpy.types.Image times its alpha."""
    return image.alpha_mode in ("STRAIGHT", "PREMUL") and not image.colorspace_settings.is_data


def blocks(image, columns):
    """Light of a bpy.types.Image that is plain, the top row first, as means of blocks so that there are no more columns than that:
    float64 (h, w, 3); or None if it has no pixels to read. What is no number, or negative, is black."""
    pixels = _pixels(image)
    if pixels is None:
        return None
    width, height = image.size
    # Grey has one channel, or two with alpha.
    chosen = (0, 1, 2) if image.channels >= 3 else (0, 0, 0)
    pixels = linear(image, pixels.reshape(height, width, -1)[::-1, :, chosen])
    pixels = np.maximum(np.nan_to_num(pixels, nan=0.0, posinf=0.0, neginf=0.0), 0)
    size = -(-width // columns)
    for axis in (0, 1):
        ends = np.arange(0, pixels.shape[axis], size)
        counts = np.diff(ends, append=pixels.shape[axis])
        sums = np.add.reduceat(pixels, ends, axis=axis, dtype=np.float64)
        pixels = sums / (counts[:, None, None] if axis == 0 else counts[:, None])
    return pixels


def _pixels(image):
    """All pixels of an image, as it keeps them: float32 (n, channels), the bottom row first; or None."""
    if image is None or image.size[0] * image.size[1] == 0:
        return None
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(-1, image.channels)


def is_plain(image):
    """Whether `linear` knows what the colours of a bpy.types.Image mean: those of floats are linear already."""
    return image is None or image.is_float or image.colorspace_settings.is_data or image.colorspace_settings.name == "sRGB"


def linear(image, encoded):
    """Colours of an image's pixels as light, (..., 3); `is_plain` must hold."""
    if image.is_float or image.colorspace_settings.is_data:
        return encoded
    return from_rec709(np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4))
