"""Watching: the same beliefs as reading afterwards, and how late they are."""

from __future__ import annotations

import math

import pytest
from fake_camera import Clock, Everywhere, FakeCamera

from kendon.estimate import estimate
from kendon.features import observe
from kendon.models import load_model
from kendon.person import Track
from kendon.simulation import SCRIPTS, SimulatedPerson
from kendon.sources import CameraSource, RecordedSource, SourceOptions
from kendon.watch import Watch

MODEL = load_model()


def recorded() -> Track:
    person, frames = SimulatedPerson(SCRIPTS["normal"]), []
    while not person.finished:
        frames.append(person.frame()._replace(t=person.t))
        person.step()
    return Track.from_frames(frames)


def test_beliefs_are_those_of_reading_the_recording_afterwards() -> None:
    track = recorded()
    watch = Watch(RecordedSource(track), MODEL)
    seen = {w.observation.t: w for w in watch.run() if w.observation and w.belief}
    afterwards = estimate(observe(track), MODEL)
    assert len(seen) >= len(afterwards.observations) - 1  # the last interval ends with the track
    for i, w in enumerate(seen.values()):
        assert w.belief is not None
        assert w.belief.probabilities == pytest.approx(afterwards.probabilities[i], abs=1e-9)
    assert watch.track.t.tolist() == track.t.tolist()
    assert watch.latency is None


def test_the_seconds_asked_for_end_it() -> None:
    watch = Watch(RecordedSource(recorded()), MODEL)
    for _ in watch.run(seconds=2.0):
        pass
    assert watch.track.duration == pytest.approx(2.0, abs=0.05)


def test_latency_is_from_the_last_picture_of_an_interval_to_the_belief() -> None:
    pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")
    clock, detector = Clock(), Everywhere()
    device = FakeCamera(clock, (1000, "fine"))
    source = CameraSource(
        0, SourceOptions(), lambda: detector.both, device.open, clock=clock, sleep=clock.sleep
    )
    watch = Watch(source, MODEL, clock=clock)
    assert watch.latency is None
    for _ in watch.run(seconds=3.0):
        clock.sleep(0.004)  # what somebody does with each frame
    latency = watch.latency
    assert latency is not None
    # The next picture, 0.1 s later, shows that the interval is over.
    assert latency.median == pytest.approx(0.104, abs=1e-6)
    assert latency.high == pytest.approx(0.104, abs=1e-6)


def test_each_watched_frame_comes_with_its_picture() -> None:
    pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")
    clock, detector = Clock(), Everywhere()
    device = FakeCamera(clock, (2, "fine"), (5, "unplugged"))
    source = CameraSource(
        0, SourceOptions(), lambda: detector.both, device.open, clock=clock, sleep=clock.sleep
    )
    for w in Watch(source, MODEL, clock=clock).run():
        assert (w.look is not None) == w.frame.seen
        if w.look is not None:
            assert w.look.picture.t == w.frame.t
            assert not math.isnan(w.look.scene.frame.smile)
            assert w.look.picture.image is not None
            assert w.look.picture.image.shape == (240, 320, 3)
