# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures on the GPU, and from there into Blender's viewport."""

import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d


class Drawing:
    """A picture as a texture: linear Rec. 709, as the viewport is until Blender shows it.

    - light: (h, w, 3), rows from the top. Fog's light on black: alpha is 1.
    - pixel: side of a pixel of it, in pixels of the region.
    """

    def __init__(self, light, pixel):
        height, width, _ = light.shape
        pixels = np.ones((height, width, 4), np.float32)
        # Textures begin at the bottom.
        pixels[..., :3] = light[::-1]
        buffer = gpu.types.Buffer("FLOAT", pixels.size, pixels)
        self._texture = gpu.types.GPUTexture((width, height), format="RGBA32F", data=buffer)
        self._size = width * pixel, height * pixel

    def draw(self, engine, scene, height):
        """Draws it into a region of that height, from its upper left corner."""
        width, own_height = self._size
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (0, height - own_height), width, own_height)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")
