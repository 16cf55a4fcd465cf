"""What a notebook shows: pictures, plots and videos of an episode, and tables of a run."""

import re
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

import vpf_sim
from vpf_sim.reporting import overlay


class Looks(vpf_sim.Driver):
    """Keeps the frames that it saw."""

    def reset(self, setup: vpf_sim.DriverSetup) -> None:  # noqa: ARG002
        self.frames: list[np.ndarray[tuple[int, ...], np.dtype[np.uint8]]] = []

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
        self.frames.append(observation.image)
        return vpf_sim.Command(0.1, 0.0)


class Lost(vpf_sim.Driver):
    uses_images = False

    def reset(self, setup: vpf_sim.DriverSetup) -> None:  # noqa: ARG002
        raise KeyError("no such road")

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
        raise AssertionError(observation)


def test_a_picture_is_the_frame_of_its_time(short: Path, tmp_path: Path) -> None:
    driver = Looks()
    episode = vpf_sim.drive(short, driver=driver, weather="rain", seed=5)
    seen = list(driver.frames)
    picture = episode.picture(time_s=0.5)
    assert (np.asarray(picture) == seen[30]).all()
    assert (np.asarray(episode.picture(0.509)) == seen[31]).all()
    assert not (np.asarray(episode.picture()) == seen[-1]).all(), "the last is that after the last command"
    written = cv2.imread(str(picture.save(tmp_path / "a.png")))
    assert written is not None
    assert (written[:, :, ::-1] == seen[30]).all()
    assert repr(picture) == "<Picture 640 x 480>"
    shown = cv2.imdecode(np.frombuffer(picture._repr_png_(), np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    assert (shown[:, :, ::-1] == seen[30]).all()


def test_a_picture_has_the_drivers_overlay(short: Path) -> None:
    picture = np.asarray(vpf_sim.drive(short, driver="vpf").picture(time_s=0.9)).astype(int)
    assert (np.abs(picture - overlay.EDGE).max(axis=2) < 30).sum() > 200


@pytest.mark.parametrize("time_s", [-0.1, 60.0, "a"])
def test_a_time_outside_the_drive_is_refused(time_s: float, short: Path) -> None:
    episode = vpf_sim.drive(short, driver="pid")
    last_s = episode.steps["time_s"].iloc[-1]
    with pytest.raises(vpf_sim.InputError, match=re.escape(f"time_s: expected 0 to {last_s:.2f}, got {time_s!r}")):
        episode.picture(time_s)


def test_a_plot_has_path_signals_and_scores_and_loads_nothing(short: Path, tmp_path: Path) -> None:
    episode = vpf_sim.drive(short, driver="pid", seed=1)
    html = episode.plot().save(tmp_path / "plot.html").read_text("utf-8")
    labels = re.findall(r'role="img" aria-label="([^"]+)"', html)
    for what in ("paths over the road", "offset from the lane", "throttle", "steering", "speed"):
        assert any(what in label for label in labels), what
    assert f"success after {episode.steps['time_s'].iloc[-1]:.1f}" in html
    assert not re.findall(r'(?:src|href)="(?!data:)', html)
    shown = episode._repr_html_()
    assert shown == episode.plot()._repr_html_()
    assert shown.startswith("<iframe ")
    assert shown.count("<") == 2, "the page is escaped within the frame"


def test_a_video_has_every_frame_and_is_embedded(short: Path, tmp_path: Path) -> None:
    episode = vpf_sim.drive(short, driver="pid")
    video = episode.video()
    assert video.path == Path(f"{episode.record['id']}.mp4")
    with av.open(str(video.path)) as container:
        assert sum(1 for _ in container.decode(video=0)) == len(episode.steps)
    assert video._repr_html_().startswith("<video ")
    stored = vpf_sim.drive(short, driver="pid", out=tmp_path / "run")
    assert stored.video().path == tmp_path / "run" / "videos" / f"{episode.record['id']}.mp4"


def test_an_episode_that_never_began_shows_its_error(short: Path) -> None:
    episode = vpf_sim.drive(short, driver=Lost)
    assert "no such road" in episode._repr_html_()
    for view in (episode.picture, episode.plot, episode.video):
        with pytest.raises(vpf_sim.InputError, match="expected an episode with steps, got one that never began"):
            view()


@pytest.mark.usefixtures("in_one_process")
def test_the_episodes_of_a_run_are_those_that_were_driven(
    short: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = vpf_sim.sweep(short, driver=[Looks, "pid"], seeds="2:3", out=tmp_path / "run", progress=False)
    name = run.records.query("driver == 'pid'")["id"].iloc[0]
    single = vpf_sim.drive(short, driver="pid", seed=2)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    short.unlink()
    stored = run.episode(name)
    assert stored.record == single.record
    assert stored.steps.equals(single.steps)
    assert stored.plot().html == run.episode(name).plot().html
    assert stored.picture(0.1)._repr_png_()
    shown = run._repr_html_()
    assert re.findall(r"<td>([^<]*Looks|pid)</td>", shown)
    assert shown.count("<tr") == 3
    with pytest.raises(vpf_sim.InputError, match="unknown episode"):
        run.episode("pidd")
