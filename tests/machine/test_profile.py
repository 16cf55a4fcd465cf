"""The profile's stages and ratios; never a time."""

from vpf_sim.machine import profile


def test_a_profile_has_all_stages() -> None:
    measured = profile.profile("town04-clean", "clear", steps=2)
    assert measured.stages_ms.keys() == measured.once_ms.keys()
    assert {
        "render",
        "render.backdrop",
        "physics",
        "flow",
        "road",
        "static_obstacles",
        "plan",
        "control",
        "hash",
    } <= measured.stages_ms.keys()
    assert measured.step_ratio == measured.step_ms / measured.yardstick_ms
    assert measured.camera_ratio == measured.once_ms["render"] / measured.yardstick_ms
    parts = sum(time for name, time in measured.stages_ms.items() if "." not in name and name != "hash")
    assert all(time > 0.0 for time in measured.stages_ms.values())
    assert 0.0 < parts <= measured.step_ms, "of one half second: the stages make up the step, but for a few lines"
