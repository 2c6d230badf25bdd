"""The geodesic grid of viewpoints and the cameras that stand there."""

import numpy as np
import pytest

from snapfit.models.viewpoint_grid import geodesic_grid, viewpoint_pose


@pytest.mark.parametrize("n_divisions", [0, 1, 2, 3, 4])
def test_counts_and_lengths(n_divisions: int) -> None:
    directions, neighbours = geodesic_grid(n_divisions)
    n = 10 * 4**n_divisions + 2
    assert directions.shape == (n, 3)
    assert neighbours.shape == (n, 6)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1)
    assert len(np.unique(np.round(directions, 6), axis=0)) == n


def test_four_divisions_give_2562_views_about_four_degrees_apart() -> None:
    directions, neighbours = geodesic_grid()
    assert len(directions) == 2562
    cosines = np.einsum("ik,ijk->ij", directions, directions[neighbours])
    angles_deg = np.degrees(np.arccos(np.clip(cosines, -1, 1)))
    apart = angles_deg[neighbours != np.arange(2562)[:, None]]
    assert 3.5 < apart.min() < apart.max() < 5.0


def test_neighbours_are_mutual_and_twelve_have_five() -> None:
    _, neighbours = geodesic_grid(3)
    n = len(neighbours)
    adjacent = np.zeros((n, n), dtype=bool)
    adjacent[np.arange(n)[:, None], neighbours] = True
    assert np.array_equal(adjacent, adjacent.T)
    assert adjacent.diagonal().sum() == 12
    counts = (adjacent & ~np.eye(n, dtype=bool)).sum(axis=1)
    assert np.bincount(counts, minlength=7)[5:].tolist() == [12, n - 12]


def test_climbing_from_neighbour_to_neighbour_finds_the_closest_view() -> None:
    directions, neighbours = geodesic_grid()
    for wanted in np.random.default_rng(7).normal(size=(50, 3)):
        view, last = 0, -1
        while view != last:
            last = view
            nearby = [view, *neighbours[view].tolist()]
            view = nearby[int(np.argmax(directions[nearby] @ wanted))]
        assert view == int(np.argmax(directions @ wanted))


def test_a_viewpoint_faces_the_centre() -> None:
    center_m = np.array([0.1, -0.2, 0.3])
    for direction in geodesic_grid(1)[0]:
        pose = viewpoint_pose(direction, center_m, 0.8)
        assert np.allclose(pose.transform(center_m), [0, 0, 0.8])
        assert np.allclose(pose.inverse().translation, center_m + 0.8 * direction)
        assert np.allclose(pose.rotation @ pose.rotation.T, np.eye(3))
        assert np.linalg.det(pose.rotation) == pytest.approx(1)
