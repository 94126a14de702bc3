"""What a call through the Python module costs, next to numpy on the same arrays. Prints figures, asserts nothing."""

import timeit

import numpy as np

import covbeam as cb
from covbeam import light_field


def seconds(call, number):
    """Of one call: the best of five rounds, as the others were disturbed."""
    return min(timeit.repeat(call, number=number, repeat=5)) / number


one = light_field.point((0, 0, 1))
many = light_field.point(np.float32([0, 0, 1]) * np.ones((100_000, 1), np.float32))
distances = np.full(100_000, 1e-6, np.float32)
columns = np.zeros((100_000, 10), np.float32)

call = seconds(lambda: light_field.travel(one, 0.0), 10_000)
numpy_call = seconds(lambda: np.add(distances[:1], 1.0, out=distances[:1]), 10_000)
batch = seconds(lambda: light_field.travel(many, distances), 20)
# What numpy would have to do at least: touch the ten numbers of every root once.
touch = seconds(lambda: np.multiply(many["root"], np.float32(1), out=columns), 20)
print(f"one light field travels: {call * 1e6:.1f} us a call, {1 / call:.0f} calls/s (np.add on one number: {numpy_call * 1e6:.1f} us)")
print(f"100,000 travel: {batch * 1e9 / 1e5:.1f} ns each, {1e5 / batch / 1e6:.0f} M/s (one numpy multiplication of the roots: {touch * 1e9 / 1e5:.1f} ns each)")

fog = cb.Medium(0.2)
beams = np.zeros(20_000, cb.BEAM)
beams["direction"] = np.random.default_rng(1).normal(size=(20_000, 3))
beams["direction"] /= np.linalg.norm(beams["direction"], axis=1, keepdims=True)
beams["length"], beams["power"] = 4, 1e-4
rays = np.zeros(2048, cb.EYE_RAY)
# 32 tiles of 8x8 pixels, one after the other.
tiles, y, x = np.mgrid[0:32, 0:8, 0:8].reshape(3, -1)
rays["origin"] = np.stack([tiles % 8 * 8 + x - 32, tiles // 8 * 8 + y - 16, np.full(2048, -64)], axis=1) / 32
rays["direction"], rays["length"] = (0, 0, 1), 4
kernel = cb.Kernel(cb.KernelShape.EPANECHNIKOV, 0.05, 0.05, 0.01)


def commit():
    beam_map.clear()
    beam_map.add(beams)
    beam_map.commit(kernel.max_radius)


def shade(contacts, values):
    values[:] = 0.2 / (4 * np.pi)


with cb.BeamMap(fog) as beam_map, cb.Scratch() as scratch:
    print(f"20,000 beams added and committed: {seconds(commit, 2) * 1e9 / len(beams):.0f} ns each")
    out = np.zeros(len(rays), cb.GATHERED)
    asked = []
    plain = seconds(lambda: beam_map.gather(kernel, None, rays, out=out, scratch=scratch), 1)
    pairs = int(out["pairs"].sum())
    polled = seconds(lambda: beam_map.gather(kernel, None, rays, out=out, scratch=scratch, poll=lambda: asked.append(1) or True), 1)
    shaded = seconds(lambda: beam_map.gather_shaded(kernel, None, rays, shade, out=out, scratch=scratch), 1)
    print(f"gather: {plain * 1e9 / pairs:.1f} ns a pair, {pairs} pairs; with a poll: {polled * 1e9 / pairs:.1f}, asked {len(asked) // 5} times a call")
    print(f"gather with a shade function in Python: {shaded * 1e9 / pairs:.1f} ns a pair")
