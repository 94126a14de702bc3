# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads Blender's evaluated scene into a host.scene.Scene, and reports what it could not take over.

The entry point is `scene.export`.
"""
