"""The profile's keys, and the stopwatch; no test asserts a time."""

import math

from vpf_sim.evaluation.episode import stopwatch
from vpf_sim.evaluation.machine import profile


def test_a_profile_has_the_promised_keys_and_all_stages() -> None:
    measured = profile.profile("town04-clean", "clear", steps=2)
    assert measured.keys() == {"step_ms", "yardstick_ms", "step_ratio", "camera_ratio", "stages_ms", "once_ms"}
    assert measured["stages_ms"].keys() == measured["once_ms"].keys() == {*profile.STAGES, "hash"}
    assert measured["step_ratio"] == measured["step_ms"] / measured["yardstick_ms"]
    assert measured["camera_ratio"] == measured["once_ms"]["render"] / measured["yardstick_ms"]
    parts = sum(time for name, time in measured["stages_ms"].items() if "." not in name and name != "hash")
    assert all(time > 0.0 for time in measured["stages_ms"].values())
    assert 0.0 < parts <= measured["step_ms"], "of one half second: the stages make up the step, but for a few lines"


def test_a_stopwatch_puts_back_what_it_replaced() -> None:
    before = math.hypot
    watch = stopwatch.Stopwatch()
    with watch.watching({"length": "math:hypot"}):
        assert math.hypot is not before
        assert math.hypot(3.0, 4.0) == 5.0
        assert math.hypot(3.0, 4.0) == 5.0
    assert math.hypot is before
    watch.end_step()
    assert watch.medians_ms().keys() == {"length"}


def test_a_stage_of_some_steps_counts_by_its_share_and_a_disturbed_window_does_not() -> None:
    watch = stopwatch.Stopwatch()
    for step in range(50):
        watch._step_ms = {"each": 2.0, **({"third": 30.0} if step % 5 == 0 else {})}
        if step == 7:
            watch._step_ms["each"] = 1000.0
        watch.end_step()
    assert watch.typical_ms(10) == {"each": 2.0, "third": 6.0}
    assert watch.medians_ms() == {"each": 2.0, "third": 30.0}


def test_medians_are_over_the_steps_that_count() -> None:
    watch = stopwatch.Stopwatch()
    with watch.stage("a"):
        pass
    watch.skip_step()
    with watch.stage("b"):
        pass
    watch.end_step()
    watch.end_step()
    assert watch.medians_ms().keys() == {"b"}
