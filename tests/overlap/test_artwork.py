"""SVG as obstacles: the areas of its shapes, and SVG that is refused."""

from __future__ import annotations

import io

import numpy as np
import pytest

import vfwidget as vf
from vfwidget.overlap.shape import read_obstacles

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">'


def artwork(body, **options):
    return vf.Artwork(f"{HEAD}{body}</svg>", **options)


def area(art):
    return read_obstacles([art])[0].area()


@pytest.mark.parametrize(
    "body, want",
    [
        ('<rect width="9" height="2"/>', 18),
        ('<circle r="5" cx="3"/>', 25 * np.pi),
        ('<ellipse rx="4" ry="2"/>', 8 * np.pi),
        ('<polygon points="0,0 4,0 0,3"/>', 6),
        ('<path d="M0 0H10V10H0Z M2 2H8V8H2Z" fill-rule="evenodd"/>', 64),
        ('<path d="M0 0H10V10H0Z M2 2H8V8H2Z"/>', 100),
        ('<path d="M0 0Q5 10 10 0"/>', 100 / 3),
        # Two shapes of opposite direction that overlap count once.
        ('<rect width="4" height="4"/><path d="M2 2V8H8V2Z"/>', 16 + 36 - 4),
        # Strokes: their area, with the tips of their corners.
        ('<line x2="10" stroke="black" stroke-width="2"/>', 20),
        ('<path d="M0 0H10" fill="none" stroke="red"/>', 10),
        (
            '<polyline points="0,0 10,0 10,10" fill="none" stroke="red" stroke-width="2"/>',
            40,
        ),
        (
            '<rect width="4" height="4" fill="none" stroke="#000" stroke-width="2"/>',
            32,
        ),
        ('<circle r="10" fill="none" stroke="black" stroke-width="2"/>', 40 * np.pi),
        # Transforms, groups and references.
        (
            '<g transform="scale(2)"><rect transform="skewX(9)" width="3" height="1"/></g>',
            12,
        ),
        ('<g transform="scale(2) skewX(30)"><circle r="3"/></g>', 36 * np.pi),
        ('<defs><rect id="r" width="2" height="2"/></defs><use href="#r" x="5"/>', 4),
        ('<defs><rect id="r" width="2" height="2"/></defs><use xlink:href="#r"/>', 4),
        ('<rect width="3" height="3" style="display:none"/><rect width="1" height="1"/>', 1),
    ],
)
def test_the_areas_of_shapes_are_those_of_geometry(body, want):
    assert area(artwork(body)) == pytest.approx(want, rel=2e-3)


def test_y_points_up_and_artwork_is_placed():
    art = artwork('<rect x="1" y="2" width="3" height="4"/>', scale=10, position=(100, 200))
    np.testing.assert_allclose(art.box, [[110, 140], [140, 180]])
    np.testing.assert_allclose(art.moved(5, -5).box, [[115, 135], [145, 175]])
    np.testing.assert_allclose(art.scaled(2).box, [[220, 280], [280, 360]])
    assert repr(art) == "<Artwork of 1 contour, 30 × 40>"
    np.testing.assert_allclose(art.scaled("2").box, art.scaled(2).box)
    for move in (
        lambda: art.scaled(1e300),
        lambda: art.moved(1e300, 0),
        lambda: art.scaled(10**400),
    ):
        with np.errstate(all="raise"), pytest.raises(vf.OverlapError):
            move()


def test_strings_bytes_files_and_paths(tmp_path):
    source = f'{HEAD}<rect width="9" height="2"/></svg>'
    path = tmp_path / "art.svg"
    path.write_text(source)
    for given in (source, source.encode(), path, str(path), io.StringIO(source)):
        assert area(vf.Artwork(given)) == pytest.approx(18)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1"])
def test_files_of_any_encoding(encoding, tmp_path):
    declared = f'<?xml version="1.0" encoding="{encoding.removesuffix("-sig").upper()}"?>'
    source = f'{declared}{HEAD}<!-- é --><rect width="9" height="2"/></svg>'
    path = tmp_path / "art.svg"
    path.write_text(source, encoding=encoding)
    for given in (source, path, path.read_bytes()):
        assert area(vf.Artwork(given)) == pytest.approx(18)


def test_a_closed_file_is_refused():
    file = io.StringIO(HEAD)
    file.close()
    with pytest.raises(vf.OverlapError, match="cannot be read"):
        vf.Artwork(file)


def test_it_is_an_obstacle():
    text = vf.Text("recursive", "H")
    art = artwork('<circle r="100"/>', position=(300, 350))
    [found] = vf.overlaps(text, art)
    assert found.area == pytest.approx(vf.overlaps(text, [list(art.contours)])[0].area)


NESTED = "".join(f'<g id="a{i}">' + f'<use href="#a{i - 1}"/>' * 10 + "</g>" for i in range(1, 9))


@pytest.mark.parametrize(
    "source, message",
    [
        ("<svg", "cannot be parsed"),
        (f"{HEAD}</svg>", "draws nothing"),
        (f"{HEAD}<path d='M0 0 L nan'/></svg>", "draws nothing"),
        (f'{HEAD}<g id="a0"><rect width="1" height="1"/></g>{NESTED}</svg>', "at most 5,000"),
        (f'{HEAD}<g id="x"><use href="#x"/></g></svg>', "uses itself"),
        (f'<!DOCTYPE svg [<!ENTITY a "b">]>{HEAD}&a;</svg>', "declares entities"),
        (f"{HEAD}{'<g>' * 200}{'</g>' * 200}</svg>", "nested more than 100"),
        ("no such file.svg", "cannot be read"),
        (" ", "text of the SVG is empty"),
        ("x" * 2**22 + "<", "larger than 4,194,304 bytes"),
        (5, "must be SVG text, a path or a file"),
    ],
)
def test_svg_that_is_refused(source, message):
    with pytest.raises(vf.OverlapError, match=message):
        vf.Artwork(source)


def test_nothing_is_fetched_or_run(monkeypatch):
    import urllib.request

    def fetched(*_):
        raise AssertionError("something was fetched")

    monkeypatch.setattr(urllib.request, "urlopen", fetched)
    body = (
        '<script>alert(1)</script><image href="http://localhost/x.png" width="5" height="5"/>'
        '<style>@import url("http://localhost/x.css");</style>'
        '<use href="http://localhost/x.svg#a"/><rect width="2" height="1"/>'
    )
    assert area(artwork(body)) == pytest.approx(2)


@pytest.mark.parametrize("options", [{"scale": 0}, {"scale": "a"}, {"position": 5}])
def test_placements_that_are_none(options):
    with pytest.raises(vf.OverlapError, match="scale must be a number > 0"):
        artwork('<rect width="9" height="2"/>', **options)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", ["1e308", "1e12"])
@pytest.mark.parametrize(
    "shape", ['<rect width="{}" height="9"/>', '<path d="M0 0H9" stroke="red" stroke-width="{}"/>']
)
def test_enormous_coordinates_are_refused(size, shape):
    with pytest.raises(vf.OverlapError, match="coordinates must be finite and at most"):
        artwork(shape.format(size))


def test_an_infinite_coordinate_is_named():
    with pytest.raises(vf.OverlapError, match="a coordinate of inf"):
        artwork('<rect width="1e308" height="1e308" transform="scale(9)"/>')


def test_many_shapes_are_joined_at_once():
    """A grid of 400 squares; each square of the second grid lies across one of the first."""
    squares = "".join(
        f'<rect x="{7 * (i % 20)}" y="{7 * (i // 20)}" width="5" height="5"/>' for i in range(400)
    )
    art = artwork(squares + f'<g transform="translate(2 2)">{squares}</g>')
    # The corners of neighbours touch at the point (7, 7).
    assert area(art) == pytest.approx(400 * (25 + 25 - 9))


RECTANGLES = '<rect width="5" height="5"/>' * 300
STROKE = "".join(f"L{i * 37 % 101} {i * 53 % 103}" for i in range(400))
SCRIBBLE = "".join(f"L{i * 617 % 1009} {i * 411 % 1013}" for i in range(400))


@pytest.mark.parametrize(
    "body, limit",
    [
        (RECTANGLES, "curve_pairs"),
        (f'<path d="M0 0{STROKE}" fill="none" stroke="red" stroke-width="9"/>', "curve_pairs"),
        (f'<path d="M0 0{SCRIBBLE}"/>', "curve_pairs"),
        (f'<path d="M0 0{STROKE * 15}" stroke="red"/>', "svg_curves"),
    ],
    ids=["equal rectangles", "one stroke", "a scribble", "curves of a stroke"],
)
def test_dense_artwork_is_refused(body, limit, monkeypatch):
    monkeypatch.setattr(vf.limits, "curve_pairs", 20_000)
    with pytest.raises(vf.OverlapError, match=rf"simplify .*raise vf\.limits\.{limit}"):
        artwork(body)
