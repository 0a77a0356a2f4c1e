"""One picture and many fonts: the ranking, the executors, and fonts that are not fitted."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import fonts as tiny
import numpy as np
import pytest
from pictures import axis_error, draw, random_place

import vfwidget as vf
from vfwidget.matching import Match, catalogue
from vfwidget.matching.catalogue import KEPT

BUNDLED = vf.bundled_fonts()
FONTS = ("afacad-flux", "dynapuff", "recursive", "shantell-sans")
FEW = FONTS[:2]
SIZE = (40, 40)


def match(image, fonts, string="R", **options) -> Match:
    return vf.match(image, string, fonts=fonts, progress=False, **options)


def picture(name: str, seed: int = 1, size=SIZE) -> tuple[np.ndarray, vf.Text]:
    text = random_place(vf.Text(name, "R"), np.random.default_rng(seed))
    return draw(text, size), text


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch) -> None:
    """Two fonts a worker, so that few fonts make several chunks."""
    monkeypatch.setattr(catalogue, "CHUNK", 2)


@pytest.fixture(scope="module")
def image() -> np.ndarray:
    return picture("dynapuff")[0]


@pytest.fixture(scope="module")
def serial(image) -> Match:
    return match(image, FONTS)


@pytest.fixture(scope="module")
def serial_few(image) -> Match:
    return match(image, FEW)


def numbers(found: Match) -> list[tuple]:
    """All that each of the matches came to, bit by bit."""
    return [
        (
            one.text.font.family_name,
            one.outcome.state.flat().tobytes(),
            one.outcome.deviation.tobytes(),
            [(theta.tobytes(), loss) for theta, loss in one.history],
            (one.loss, one.score, one.outcome.iterations, one.outcome.converged),
        )
        for one in found.ranking
    ]


# Which font it is


def test_the_right_font_comes_first(serial):
    assert serial.text.font.family_name == "DynaPuff"
    assert serial.status == "matched"
    assert axis_error(serial, picture("dynapuff")[1]) < 0.01
    assert len(serial.ranking) == len(FONTS)
    assert serial.left_out == {}
    scores = [one.score for one in serial.ranking]
    assert scores == sorted(scores, reverse=True)
    assert scores[0] == serial.score > 0.999 > scores[1] + 0.05
    assert serial.ranking[0].axes == serial.axes


@pytest.mark.slow
@pytest.mark.parametrize("name", BUNDLED)
@pytest.mark.parametrize("seed", [2, 3])
def test_every_font_is_told_from_the_others(name, seed):
    image, text = picture(name, seed, (96, 96))
    found = match(image, BUNDLED)
    assert found.text.font.family_name == text.font.family_name
    assert axis_error(found, text) < 0.01


def test_each_is_fitted_as_it_would_be_by_itself(serial, image):
    alone = vf.match(image, "R", "afacad-flux", progress=False)
    (same,) = (one for one in serial.ranking if one.text.font.family_name.startswith("Afacad"))
    assert same.axes == alone.axes
    assert same.loss == alone.loss


def test_fonts_are_given_in_any_way(image):
    folder = Path(vf.__file__).parent / "fonts"
    kinds = ["dynapuff", vf.load_font("dynapuff"), folder / "dynapuff.woff2"]
    kinds.append((folder / "dynapuff.woff2").read_bytes())
    found = vf.match(image, "R", kinds, progress=False)
    assert len(found.ranking) == len(kinds)
    assert len({str(one.axes) for one in found.ranking}) == 1


# Whoever computes it


def pool(**options) -> ProcessPoolExecutor:
    # A fork would copy a process in which torch has threads.
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(2, mp_context=context, **options)


def test_threads_come_to_the_same(serial_few, image, monkeypatch):
    monkeypatch.setattr(catalogue, "CHUNK", 1)
    with ThreadPoolExecutor(2) as executor:
        assert numbers(match(image, FEW, executor=executor)) == numbers(serial_few)


@pytest.mark.slow
def test_processes_come_to_the_same(serial, serial_few, image):
    with pool() as executor:
        assert numbers(match(image, FONTS, executor=executor)) == numbers(serial)
        loaded = [vf.load_font(name) for name in FEW]
        few = match(image, loaded, executor=executor)
    assert numbers(few) == numbers(serial_few)


class Travelling(Executor):
    """Works in place, but all that goes in and comes out is pickled."""

    def submit(self, job, /, *arguments, **options):
        job, arguments = pickle.loads(pickle.dumps((job, arguments)))
        future: Future = Future()
        future.set_result(pickle.loads(pickle.dumps(job(*arguments, **options))))
        return future


def test_work_and_results_travel(serial_few, image):
    # A font that is open travels as a file.
    fonts = [FEW[0], vf.load_font(FEW[1])]
    assert numbers(match(image, fonts, executor=Travelling())) == numbers(serial_few)


def test_open_fonts_are_left_as_they_are(image):
    font = vf.load_font("dynapuff")
    flavor = font._ttfont.flavor
    with ThreadPoolExecutor(1) as executor:
        match(image, [font], executor=executor)
    assert font._ttfont.flavor == flavor


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, protocol="tcp"
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.mark.slow
def test_a_dask_cluster_comes_to_the_same(serial, image, cluster):
    assert numbers(match(image, FONTS, executor=cluster.get_executor())) == numbers(serial)


# Workers that are lost


class Crashing(bytes):
    """A font that, when a worker first unpacks it, ends that worker's process."""

    marker: str

    def marked(self, marker: str) -> Crashing:
        self.marker = marker
        return self

    def __reduce__(self):
        return crash_once, (self.marker, os.getpid(), bytes(self))


def crash_once(marker: str, sender: int, data: bytes) -> bytes:
    # Dask's scheduler unpacks it too, in the process of the tests.
    if os.getpid() == sender:
        return Crashing(data).marked(marker)
    try:
        os.close(os.open(marker, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return data
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError


def crashing(tmp_path) -> Crashing:
    folder = Path(vf.__file__).parent / "fonts"
    return Crashing((folder / "dynapuff.woff2").read_bytes()).marked(str(tmp_path / "crashed"))


@pytest.mark.slow
def test_a_lost_process_costs_nothing_but_time(image, serial, tmp_path):
    sources = [crashing(tmp_path) if name == "dynapuff" else name for name in FONTS]
    with pool() as executor, pytest.warns(UserWarning, match=r"A worker was lost .*trying again"):
        found = match(image, sources, executor=executor)
    assert (tmp_path / "crashed").exists()
    assert numbers(found) == numbers(serial)
    assert found.left_out == {}


@pytest.mark.slow
def test_a_lost_dask_worker_costs_nothing_but_time(image, serial, cluster, tmp_path):
    sources = [crashing(tmp_path) if name == "dynapuff" else name for name in FONTS]
    found = match(image, sources, executor=cluster.get_executor(retries=2))
    assert (tmp_path / "crashed").exists()
    assert numbers(found) == numbers(serial)


class Unreliable(Executor):
    """Works in place, but the first few jobs are lost."""

    def __init__(self, losses: int, at_submission: bool = False) -> None:
        self.losses, self.at_submission, self.jobs = losses, at_submission, 0

    def submit(self, job, /, *arguments, **options):
        self.jobs += 1
        future: Future = Future()
        if self.jobs <= self.losses:
            if self.at_submission:
                raise RuntimeError("no pool")
            future.set_exception(ConnectionError("gone"))
        else:
            future.set_result(job(*arguments, **options))
        return future


@pytest.mark.parametrize("at_submission", [False, True])
def test_a_lost_chunk_is_given_out_again(image, serial_few, at_submission, monkeypatch):
    monkeypatch.setattr(catalogue, "CHUNK", 1)
    executor = Unreliable(1, at_submission)
    with pytest.warns(UserWarning, match="no pool" if at_submission else "gone") as caught:
        found = match(image, FEW, executor=executor)
    assert len(caught) == 1
    # Two chunks, one of them twice.
    assert executor.jobs == 3
    assert numbers(found) == numbers(serial_few)


def test_without_any_worker_the_work_is_done_here(image, serial_few):
    executor = Unreliable(10**6)
    with pytest.warns(UserWarning, match="A worker was lost"):
        found = match(image, FEW, executor=executor)
    assert executor.jobs == 3
    assert numbers(found) == numbers(serial_few)


# Fonts that are left out


def shape(*points) -> bytes:
    """A font whose only letter, R, is a shape that grows wider as it grows bolder."""
    outline = tiny.outline(points)
    wider = [(2 * x // 5, 0) for x, *_ in points]
    return tiny.build(
        {"R": outline}, {"R": [(tiny.BOLD, [*wider, *tiny.STILL])]}, axes=(tiny.WEIGHT,)
    )


def polygon(corners: int, star: float = 1.0) -> bytes:
    angles = 2 * np.pi * np.arange(corners) / corners + 0.3
    radii = np.where(np.arange(corners) % 2, 300 * star, 300)
    x, y = 320 + radii * np.cos(angles), 320 + radii * np.sin(angles)
    return shape(*zip(x.astype(int).tolist(), y.astype(int).tolist(), strict=True))


STARS = [polygon(corners, star) for corners in (4, 6, 8, 10, 14) for star in (0.3, 0.6, 1.0)]


def test_fonts_that_cannot_be_fitted_are_left_out_with_their_reasons(image, tmp_path):
    missing = tmp_path / "missing.ttf"
    sources = ["dynapuff", "no-such-font", missing, b"no font", tiny.build(*tiny.base_glyphs())]
    found = match(image, sources)
    assert [one.text.font.family_name for one in found.ranking] == ["DynaPuff"]
    assert list(found.left_out) == ["no-such-font", str(missing), "fonts[3]", "fonts[4]"]
    reasons = list(found.left_out.values())
    assert "No bundled font and no readable file" in reasons[0]
    assert "missing.ttf" in reasons[1]
    assert "Not a font file" in reasons[2]
    assert "no glyph for 'R'" in reasons[3]


def test_reasons_travel_from_a_worker(image):
    with ThreadPoolExecutor(2) as executor:
        found = match(image, ["dynapuff", b"no font"], executor=executor)
    assert "Not a font file" in found.left_out["fonts[1]"]


def test_fonts_of_one_name_are_all_named(image):
    font = vf.load_font(tiny.build(*tiny.base_glyphs()))
    found = match(image, [font, "dynapuff", font])
    assert list(found.left_out) == ["Tiny", "Tiny, fonts[2]"]


@pytest.mark.parametrize("kept, threads", [(3, 0), pytest.param(KEPT, 2, marks=pytest.mark.slow)])
def test_of_many_fonts_the_coarse_search_selects_those_that_are_fitted(kept, threads, monkeypatch):
    monkeypatch.setattr(catalogue, "KEPT", kept)
    assert len(STARS) > KEPT
    truth = vf.Text(STARS[7], "R", axes={"wght": 700})
    image = draw(truth, SIZE)
    fonts = [*STARS, b"no font"]
    if threads:
        with ThreadPoolExecutor(threads) as executor:
            found = match(image, fonts, executor=executor)
    else:
        found = match(image, fonts)
    assert len(found.ranking) == kept
    assert len(found.left_out) == len(fonts) - kept
    assert "Not a font file" in found.left_out.pop(f"fonts[{len(STARS)}]")
    for name, why in found.left_out.items():
        assert name.startswith("fonts[")
        assert name != "fonts[7]"
        assert why.startswith("the coarse search explains ")
        assert why.endswith(" % of the ink")
    assert found.status == "matched"
    assert axis_error(found, truth) < 0.01
    best = found.text.font.glyph("R").default
    assert np.array_equal(best, truth.glyphs[0].default)


# Bad input


def test_there_is_no_font_to_match(image):
    with pytest.raises(vf.ImageError, match="There are no fonts to match"):
        match(image, [])


@pytest.mark.parametrize("fonts", ["recursive", vf.load_font("recursive"), {"dynapuff": 1}, 3])
def test_fonts_that_are_no_sequence(fonts, image):
    with pytest.raises(vf.ImageError, match="fonts must be a sequence of fonts"):
        vf.match(image, "R", fonts=fonts, progress=False)


def test_no_font_can_be_fitted(image):
    with pytest.raises(vf.ImageError, match=r"No font could be fitted: .*no glyph for 'あ'"):
        match(image, FONTS, "あ")
    with pytest.raises(vf.ImageError, match="No font could be fitted: Not a font file"):
        match(image, [b"no font"])


def test_a_bad_picture_is_the_same_for_all_fonts():
    with pytest.raises(vf.ImageError, match="The image is uniform"):
        match(np.ones(SIZE), FONTS[:2])


@pytest.mark.parametrize("fonts", [None, [], "dynapuff"], ids=repr)
def test_a_font_and_fonts(fonts, image):
    with pytest.raises(vf.ImageError, match=r"Give a font, or several|There are no fonts"):
        vf.match(image, "R", "recursive" if fonts else None, fonts=fonts, progress=False)
