"""Activation times: at the start, of every beat, at the membrane's threshold; no celerity, and why."""

import myostrain as ms
from myostrain.output.probes import ActivationTimes, Probes

import numpy as np
import pytest


class Watched:
    """A line of four nodes whose potential the test sets."""

    def __init__(self, threshold=0.5, probe=1.5):
        body = ms.build(ms.geometry.Line(length=3.0, spacing=1.0))
        self.potential = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo())
        X = self.potential.v.function_space.tabulate_dof_coordinates()[:, 0]
        self.order = np.argsort(X)
        self.times = ActivationTimes(
            self.potential.v, Probes(self.potential.v.function_space, {"p": (probe,)}), threshold
        )

    def put(self, *values):
        self.potential.v.x.array[self.order] = values

    def nodes(self):
        return self.times.beats()[:, self.order]


def test_what_starts_above_the_threshold_is_activated_at_the_start():
    """ActivationTimes: time 0 above the threshold, none below, and the next rise is the second beat."""
    seen = Watched()
    seen.put(0.9, 0.5, 0.4, 0.0)
    seen.times.start()
    np.testing.assert_array_equal(seen.nodes(), [[0.0, 0.0, np.nan, np.nan]])
    assert seen.times.at_probes() == {"p": []}  # 0.45 between two nodes
    seen.put(0.1, 0.6, 0.6, 0.0)
    seen.times.observe(0.0, 1.0)
    np.testing.assert_allclose(seen.nodes(), [[0.0, 0.0, 0.5, np.nan]])
    seen.put(0.9, 0.6, 0.6, 0.0)
    seen.times.observe(1.0, 2.0)
    np.testing.assert_allclose(seen.nodes(), [[0.0, 0.0, 0.5, np.nan], [1.5, np.nan, np.nan, np.nan]])
    np.testing.assert_allclose(seen.times.nodes[seen.order], [0.0, 0.0, 0.5, np.nan])


def test_every_beat_has_its_time():
    """Beats of a node are counted apart from those of the others, at probes too."""
    seen = Watched()
    seen.put(0, 0, 0, 0)
    seen.times.start()
    for beat in range(3):
        seen.put(1, 1, 1, beat % 2)
        seen.times.observe(10.0 * beat, 10.0 * beat + 1)
        seen.put(0, 0, 0, 0)
        seen.times.observe(10.0 * beat + 1, 10.0 * beat + 2)
    np.testing.assert_allclose(seen.nodes()[:, 0], [0.5, 10.5, 20.5])
    np.testing.assert_allclose(seen.nodes()[:, 3], [10.5, np.nan, np.nan])
    assert seen.times.at_probes()["p"] == pytest.approx([0.5, 10.5, 20.5])


def test_the_threshold_is_the_membranes():
    """Rises through −40 count where that is the threshold, and 0.5 does not."""
    seen = Watched(threshold=-40.0)
    seen.put(-80, -80, -80, -30)
    seen.times.start()
    seen.put(-60, 0, 0.6, -80)
    seen.times.observe(0.0, 1.0)
    np.testing.assert_allclose(seen.nodes(), [[np.nan, 0.5, 40 / 80.6, 0.0]])


def test_times_go_on_from_a_state():
    """What a checkpoint keeps is enough to go on: beats, and that a node has been above."""
    seen, other = Watched(), Watched()
    seen.put(0.9, 0, 0, 0)
    seen.times.start()
    seen.put(0.1, 1, 0, 0)
    seen.times.observe(0.0, 1.0)
    other.put(0.1, 1, 0, 0)
    other.times.restore(seen.times.state())
    for each in (seen, other):
        each.put(0.9, 1, 1, 0)
        each.times.observe(1.0, 2.0)
    np.testing.assert_array_equal(other.nodes(), seen.nodes())
    assert other.times.at_probes() == seen.times.at_probes()
    assert np.isfinite(seen.nodes()[1, 0])


@pytest.mark.parametrize(
    "probes, reason",
    [
        ({"a": (1.0,)}, "there are not two"),
        ({"a": (1.0,), "b": (30.0,)}, "probe 'b' was not activated"),
        ({"a": (1.0,), "b": (2.0,)}, "activated at the same time"),
    ],
)
def test_there_is_no_celerity_and_why(probes, reason):
    """metrics, docstring: None where a number does not exist, with the reason in the notes."""
    body = ms.build(ms.geometry.Line(length=40.0, spacing=1.0))
    bump = ms.InitialValues(where=ms.Place(center=(0.0,), radius=5.0), potential=0.9)
    potential = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo(), initial=[bump])
    results = ms.Simulation(ms.Electromechanics(potential), step=1e-3, end=5e-3, probes=probes).run()
    assert results["metrics"]["celerity"] is None
    assert reason in results["notes"]["celerity"]


def test_a_driven_body_has_no_celerity():
    """A potential that is the same everywhere activates all probes at once: no celerity of 1e16."""
    case = ms.Case.from_dict(
        {
            "geometry": {"kind": "line", "length": 4.0, "spacing": 0.5},
            "mechanics": {"kinematics": "line", "fixed": ["left"]},
            "drive": {"potential": [[0.0, 0.0], [0.3, 1.0]]},
            "time": {"step": 0.07, "end": 0.35},
            "probes": {"a": [1.0], "b": [3.3]},
        }
    )
    results = case.simulation().run()
    assert results["probes"]["a"]["activation_time"] == pytest.approx(0.15, abs=0.02)
    assert results["metrics"]["celerity"] is None
    assert "same time" in results["notes"]["celerity"]
