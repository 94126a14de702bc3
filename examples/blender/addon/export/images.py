# SPDX-License-Identifier: GPL-3.0-or-later
"""Mean colours of images."""

import numpy as np


def mean_colour(image):
    """Mean of linear Rec. 709 and alpha of a bpy.types.Image, float64 (4,), or None if it has no pixels to read."""
    if image is None or image.size[0] * image.size[1] == 0:
        return None
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    # A million pixels are enough for a mean; an odd stride does not follow rows.
    pixels = pixels.reshape(-1, image.channels)[:: len(pixels) // image.channels >> 20 | 1]
    channels = [pixels[:, min(k, image.channels - 1)] for k in range(min(image.channels, 3))]
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        channels = [_linear(c) for c in channels]
    means = [float(np.mean(c, dtype=np.float64)) for c in channels]
    alpha = float(np.mean(pixels[:, 3], dtype=np.float64)) if image.channels == 4 else 1.0
    return np.array([*(means * 3 if len(means) == 1 else (*means, 0.0)[:3]), alpha])


def _linear(encoded):
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
