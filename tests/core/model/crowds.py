"""Particles that lie in all sorts of ways, in the plane and in space, and the error of a sum of eq. (9) on them."""

import numpy as np


def sum_of_all_pairs(points, some):
    """Eq. (9) for some particles, on distances that are divided by the largest one, times its square."""
    extent = np.ptp(points, axis=0).max() or 1.0
    apart = (points[some, None] - points[None]) / extent
    distance = np.linalg.norm(apart, axis=-1)
    distance[distance == 0.0] = np.inf
    return (apart / distance[..., None] ** 3).sum(axis=1), extent


def relative_error(points, force, seed=0):
    """Root of the sum of the squared errors of some hundred particles over that of their forces."""
    some = np.random.default_rng(seed).choice(len(points), min(len(points), 150), replace=False)
    exact, extent = sum_of_all_pairs(points, some)
    size = np.abs(exact).max() or 1.0
    return np.linalg.norm((force[some] * extent * extent - exact) / size) / (np.linalg.norm(exact / size) or 1.0)


def ring(count, radius=1.0):
    angle = 2.0 * np.pi * np.arange(count) / count
    return radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)


def rings(count, rng, noise=0.1):
    """Particles 1.5 px apart along circles that cross."""
    centers = 140.0 * np.stack(np.divmod(np.arange(count // 400), 5), axis=1)
    points = (centers[:, None] + ring(400, 600.0 / (2.0 * np.pi))[None]).reshape(-1, 2)
    return points + rng.normal(0.0, noise, points.shape)


def even_sphere(count, radius=60.0):
    """Particles that lie evenly on a sphere, so that most of the pushes on each along it cancel."""
    turn, height = np.pi * (1.0 + 5.0**0.5) * np.arange(count), 1.0 - (2.0 * np.arange(count) + 1.0) / count
    across = np.sqrt(1.0 - height**2)
    return radius * np.stack([height, across * np.sin(turn), across * np.cos(turn)], axis=1)


def _plane():
    rng = np.random.default_rng(7)
    grid = np.stack(np.mgrid[:60, :60], axis=-1).reshape(-1, 2).astype(float)
    line = np.stack([np.arange(4000) * 1.5, np.arange(4000) * 0.5], axis=1)
    cluster = rng.normal(0.0, 1.0, (3000, 2))
    angle = rng.uniform(0.0, 7.0, 4000)
    return {
        "curves": rings(6000, rng),
        "cloud": rng.uniform(0.0, 500.0, (5000, 2)),
        "grid": grid,
        "grid far away": grid + 1e8,
        "ring": ring(6000, 500.0),
        "rings in rings": np.concatenate([ring(1500, radius) for radius in (100.0, 200.0, 300.0)]),
        "line": line,
        "column": line * (1.0, 0.0),
        "row": line * (0.0, 1.0),
        "clusters": rng.uniform(0.0, 1000.0, (20, 2))[rng.integers(0, 20, 4000)] + rng.normal(0.0, 0.5, (4000, 2)),
        "cluster with outliers": np.concatenate([cluster, rng.uniform(-1e6, 1e6, (80, 2))]),
        "some spots": np.round(rng.uniform(0.0, 40.0, (4000, 2))),
        "two spots": np.array([(0.0, 0.0), (3.0, 4.0)])[rng.integers(0, 2, 3000)],
        "spots and one far": np.concatenate([np.round(rng.uniform(0.0, 3.0, (4000, 2))), [(3e5, 1e6)]]),
        "one in another": np.concatenate([rng.normal(0.0, size, (1500, 2)) for size in (1000.0, 30.0, 1.0, 0.02)]),
        "many twins": np.repeat(rng.uniform(0.0, 500.0, (2000, 2)), 2, axis=0),
        "near twins": np.repeat(rng.uniform(0.0, 500.0, (2000, 2)), 2, axis=0) + rng.normal(0.0, 1e-9, (4000, 2)),
        "all scales": np.exp(rng.uniform(-25.0, 5.0, 4000))[:, None] * np.stack([np.sin(angle), np.cos(angle)], axis=1),
        "one scale in another": np.concatenate([rng.normal(0.0, 1e-14, (1500, 2)), rng.normal(0.0, 1.0, (1500, 2))]),
        "huge": rings(4000, rng) * 1e120,
        "tiny": rings(4000, rng) * 1e-120,
    }


def _space():
    rng = np.random.default_rng(7)
    grid = np.stack(np.mgrid[:16, :16, :16], axis=-1).reshape(-1, 3).astype(float)
    one, other = rng.uniform(0.0, 2.0 * np.pi, (2, 4000))
    torus = np.stack([np.sin(other), (3 + np.cos(other)) * np.sin(one), (3 + np.cos(other)) * np.cos(one)], axis=1)
    cloud = rng.uniform(0.0, 200.0, (4000, 3))
    sphere = even_sphere(4000)
    return {
        "sphere": sphere,
        "shell": np.concatenate([even_sphere(2000, 40.0), even_sphere(3000, 60.0)]),
        "torus": 20.0 * torus,
        "cloud": cloud,
        "grid": grid,
        "grid far away": grid + 1e8,
        "plane": sphere * (0.0, 1.0, 1.0),
        "line": np.arange(4000)[:, None] * np.array([1.5, 0.5, 0.25]),
        "clusters": cloud[rng.integers(0, 20, 4000)] + rng.normal(0.0, 0.5, (4000, 3)),
        "cluster with outliers": np.concatenate([rng.normal(size=(3000, 3)), rng.uniform(-1e6, 1e6, (80, 3))]),
        "some spots": np.round(cloud / 20.0),
        "two spots": np.array([(0.0, 0.0, 1.0), (3.0, 4.0, 0.0)])[rng.integers(0, 2, 3000)],
        "near twins": np.concatenate([sphere[:2000], sphere[:2000] + 1e-9]),
        "all scales": np.exp(rng.uniform(-25.0, 5.0, 4000))[:, None] * sphere,
        "huge": sphere * 1e100,
        "tiny": sphere * 1e-100,
    }


PLANE, SPACE = _plane(), _space()
