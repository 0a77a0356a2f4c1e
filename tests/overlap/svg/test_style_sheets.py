"""Style sheets of an SVG: which rules apply, custom properties, and sheets that take long."""

from __future__ import annotations

import time
import warnings

import numpy as np
import pytest
from svgs import MANY, ONE, area, artwork

import vfwidget as vf


@pytest.mark.parametrize(
    "css, shown",
    [
        ("rect{fill:none}", False),
        ("*{fill:none}", False),
        (".a{fill:none}", False),
        ("#one{fill:none}", False),
        ("rect.a{fill:none}", False),
        ("circle.a{fill:none}", True),
        (".b, .a{fill:none}", False),
        ("/* {} */ .a{fill:none}/* .a{fill:red} */", False),
        ("g.g rect{fill:none}", False),
        ("g.g .a{fill:none}", False),
        ("g.h rect{fill:none}", True),
        ("svg g rect{fill:none}", False),
        ("g svg rect{fill:none}", True),
        ("g g rect{fill:none}", True),
        ("rect rect{fill:none}", True),
        ("g .x#one.a{fill:none}", False),
        ("g .y#one.a{fill:none}", True),
        ("#one{fill:red} .a{fill:none} rect{fill:none}", True),
        (".a{fill:red} rect{fill:none}", True),
        (".a{fill:none} .a{fill:red}", True),
        ("#one{fill:red} rect{fill:none !important}", False),
        (".a:hover{fill:none}", True),
        ("g>rect{fill:none}", False),
        ("svg > g > rect{fill:none}", False),
        ("svg > rect{fill:none}", True),
        ("svg > g rect{fill:none}", False),
        ("g.g > .a, svg > .b{fill:none}", False),
        ("[height]{fill:none}", False),
        ("rect[width='2'][id=one]{fill:none}", False),
        ("rect[width='3']{fill:none}", True),
        (":root{fill:none} circle{fill:red}", False),
        ("g:root rect{fill:none}", True),
        ("@media screen{rect{fill:none}}", False),
        ("@media print{rect{fill:none}}", True),
        ("@media (prefers-color-scheme: dark){rect{fill:none}}", True),
        ("@media print{circle{fill:none}} rect{fill:none}", False),
        ("@import 'a.css'; @font-face{font-family:a} rect{fill:none}", False),
        ("rect{fill:none;fill:nocolour}", False),
        ("rect{FILL:NONE}", False),
        ("rect{fill:none ! important;fill:red}", False),
        ("g{fill:none} rect{fill:unset}", False),
        ("g{fill:none} rect{fill:initial}", True),
        ("}}{{.a{fill", True),
        ("g > rect:first-child{fill:none}", False),
        ("g + rect{fill:none} rect:not(#one, .z){fill:none}", True),
        ("rect:not(.z):not([x]):not(:hover){fill:none}", False),
        ("rect:is(.a, circle){fill:none}", False),
        (":where(#one){fill:none} rect{fill:red}", True),
        (":is(#one, b){fill:none} .x.a{fill:red}", False),
        (".a{fill:red} rect:not(#z){fill:none}", False),
        (
            "rect[class~=a][width^='2'][class$=a][class*='x '][id|=one][id='ONE' i]{fill:none}",
            False,
        ),
        ("rect[class~='x a'], rect[class^=''], rect[id=ONE]{fill:none}", True),
        (
            "[class='x a,b'], rect:nth-child(2n + 1):nth-last-child(1):only-of-type{fill:none}",
            False,
        ),
        ("rect:nth-child(2n), rect:nth-child(-n), rect:empty:nth-child(0){fill:none}", True),
        (r"#\6f ne{fill:none}", False),
        ("rect,{fill:none}", True),
    ],
)
def test_style_sheets(css, shown):
    square = '<rect class="x a" id="one" width="2" height="2"/>'
    for sheet in (css.replace(">", "&gt;"), f"<![CDATA[{css}]]>"):
        body = f'<g class="g">{square}</g><circle cx="9" r="1"/><defs><style>{sheet}</style></defs>'
        if css.startswith("*"):
            with pytest.raises(vf.OverlapError, match="draws nothing"):
                artwork(body)
        else:
            assert area(body) == pytest.approx(np.pi + 4 * shown, rel=1e-3)


@pytest.mark.parametrize(
    "body",
    [
        "<style>" + "a" * 2_000_000 + "</style>" + ONE,
        "<style>" + "/*" * 1_000_000 + "</style>" + ONE,
        "<style>" + "a " * 1_000_000 + "{}</style>" + ONE,
        f'<rect id="p" width="1" height="1" style="{"fill:red;" * 99_999}"/>{MANY[:1600]}',
        f'<rect id="p" width="1" height="1" stroke-dasharray="{"1 " * 99_999}"/>{MANY[:1600]}',
        "<style>" + ".a .b .c{fill:red}" * 999 + "</style>" + '<g class="b">' * 90
        + '<g class="c"/>' * 3000 + "</g>" * 90 + ONE,
    ],
    ids=[
        "a selector", "comments", "a long selector", "a long style", "many dashes", "deep groups"
    ],
)  # fmt: skip
def test_long_styles_take_no_time(body):
    start = time.perf_counter()
    assert area(body) == pytest.approx(1)
    assert time.perf_counter() - start < 10


ROW = "".join(
    f'<rect id="r{i}" class="c{i % 2}" y="{20 * i}" width="10" height="10"/>' for i in range(6)
)


@pytest.mark.parametrize(
    ("selector", "hidden"),
    [
        ("rect + rect", 5),
        ("rect+rect+rect", 4),
        ("#r1 ~ .c0", 2),
        ("#r1 ~ .c1 + rect", 1),
        ("#r1 + .c0 ~ rect", 3),
        ("g > #r1 ~ rect:not(:last-child)", 3),
        (".c0 .c1, circle ~ rect, circle + rect, #r5 ~ rect", 0),
        ("rect:nth-child(3n + 1)", 2),
        ("rect:nth-child(-n+3)", 3),
        ("rect:nth-last-of-type(odd)", 3),
        ("rect:nth-child(n+3):nth-child(-n+4)", 2),
        (":not(g, svg, style):not(.c0):not(#r1)", 2),
        (":is(#r1, #r2, :nth-child(2)):not(:not(.c1))", 1),
    ],
)
def test_selectors_of_elements_in_a_row(selector, hidden):
    body = f"<style><![CDATA[{selector}{{fill:none}}]]></style><g>{ROW}</g>"
    assert area(body) == pytest.approx(100 * (6 - hidden))


def test_rules_for_siblings_look_no_farther_than_a_use():
    css = "<style>rect:first-child + rect, g + rect{fill:none}</style>"
    body = f'{css}<defs><g/><rect id="u" width="9" height="9"/></defs><use href="#u"/>'
    assert area(body) == pytest.approx(81)


@pytest.mark.parametrize(
    ("css", "message"),
    [
        (f"rect{'[id]' * 4_001}{{fill:red}}", "at most 4,000 conditions"),
        ("rect:is(" + "a[b]," * 3_000 + "b){fill:red}", "at most 4,000 conditions"),
        ("g + a{fill:red}", "more than 20,000 elements"),
        ("a,:foo," * 300_000 + "a{fill:red}", "600,001 rules"),
        ("a{" + "".join(f"--a{i}:b;" for i in range(30_000)) + "}", "and 20,000 properties"),
    ],
)
def test_style_sheets_that_would_take_long_are_refused(css, message):
    with pytest.raises(vf.OverlapError, match=message):
        artwork(f"<style>{css}</style><switch>{'<desc/>' * 21_000}{ONE}</switch>")


@pytest.mark.parametrize(
    "css",
    [
        ":not(" * 100_000 + "a" + ")" * 100_000 + "{fill:none}",
        "rect" + ":not(" * 100_000 + "{fill:none}",
        "a[b=" * 300_000 + "{fill:none}",
        "rect +{fill:none}",
        "[a='" * 300_000 + "]{fill:none}",
        "\\" * 500_001 + "{fill:none}",
        "rect:nth-child(" + "9" * 500_000 + "){fill:none}",
        "(" * 1_000_000 + "{fill:none}",
    ],
    ids=["nested", "open", "attributes", "end", "quotes", "escapes", "digits", "brackets"],
)
def test_hostile_selectors_are_ignored_at_once(css):
    start = time.perf_counter()
    with pytest.warns(vf.OverlapWarning, match="selectors are not read"):
        assert area(f"<style>{css}</style>{ONE}") == pytest.approx(1)
    assert time.perf_counter() - start < 10


@pytest.mark.parametrize(
    ("css", "shown"),
    [
        (":root{--c:none} rect{fill:var(--c)}", False),
        ("rect{fill:var(--c, none)}", False),
        ("rect{fill:var(--c, var(--d, var(--e,none)))}", False),
        ("rect{fill:var(--c)}", True),
        # A value that turns out to be none does not leave that before it.
        ("g{fill:red} rect{fill:none;fill:var(--c)}", True),
        ("g{fill:none} rect{fill:red;fill:var(--c)}", False),
        (":root{--c:none} g{--c:red} rect{fill:var(--c)}", True),
        (":root{--c:none} g{--c:initial} rect{fill:var(--c, red)}", True),
        (":root{--c:none} g{--c:unset} rect{fill:var(--c, red)}", False),
        (":root{--C:none} rect{fill:var(--c, red)}", True),
        (":root{--c:none} g{--d:var(--c)} rect{--c:red;fill:var( --d )}", False),
        (":root{--c:none!important} svg{--c:red} rect{fill:VAR(--c)}", False),
        (":root{--c:var(--c,red)} rect{fill:var(--c,none)}", False),
        (":root{--c:var(--d,red);--d:var(--c,red)} rect{fill:var(--c,none)}", False),
        (":root{--c:none} g{--c:var(--c)} rect{fill:var(--c,red)}", True),
        (":root{--c:} rect{fill:none;fill:var(--c)}", True),
        ("rect{fill:var(c,none)}", True),
        ("rect{fill:none;fill:var(--c", True),
        (":root{--v:hidden;--o:1} rect{visibility:var(--v);opacity:var(--o)}", False),
        (":root{--i:3} rect{scale:calc(var(--i)/3);fill:var(--i,none)}", True),
    ],
)
def test_custom_properties(css, shown):
    body = f'<style>{css}</style><g><rect width="2" height="2"/></g><circle cx="9" r="1"/>'
    assert area(body) == pytest.approx(np.pi + 4 * shown, rel=1e-3)


def test_custom_properties_in_attributes_and_lengths():
    css = "<style>svg{--w:20px + 10%;--n:20} #u{--x:5px}</style>"
    one = '<rect id="r" width="calc(var(--w))" height="var(--n)" style="x:var(--x,0)"/>'
    two = '<rect y="30" width="1" height="1" style="width:var(--n)px"/>'
    body = f'{css}<defs>{one}</defs>{two}<use id="u" href="#r"/>'
    found = artwork(body, 'viewBox="0 0 100 100"')
    np.testing.assert_allclose(found.box, [(5, -20), (35, 0)])


@pytest.mark.parametrize("body", ["fill:red;", "fill:red !important;", "a:b;", "width:3 px;"])
def test_declarations_are_read_once_for_all_elements(body):
    start = time.perf_counter()
    sheet = f"<style>{('circle{' + body * 180 + '}') * 990}</style>"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vf.OverlapWarning)
        assert area(sheet + "<circle/>" * 900 + ONE) == pytest.approx(1)
    assert time.perf_counter() - start < 30


def test_properties_that_are_none_of_a_style_sheet_leave_attributes():
    style = "x1:9px;d:M0 0H9V9;points:1;x2:3px"
    assert area(f'<path d="M0 0H2V2" style="{style}"/>') == pytest.approx(2)
    shapes = '<polygon points="0 9 2 9 2 11" style="{0}"/><line x2="2" style="{0};stroke:red"/>'
    assert area(shapes.replace("{0}", style)) == pytest.approx(2 + 2)


def test_a_style_may_state_a_path():
    paths = '<path style="d:path(&quot;M0 0H2V2&quot;)"/><path d="M5 0h9v9" style="d:none"/>'
    css = "<style>#a{d:path('M9 0h2v4') !important}</style>"
    assert area(f'{css}{paths}<path id="a" d="M0 0H9V9"/>') == pytest.approx(2 + 4)


LAUGHS = ";".join(f"--a{i}:{f'var(--a{i + 1})' * 9}" for i in range(30)) + ";--a30:red"


@pytest.mark.parametrize(
    ("css", "drawn"),
    [
        (f"rect{{{LAUGHS};fill:var(--a0)}}", True),
        ("rect{" + ";".join(f"--a{i}:var(--a{i + 1})" for i in range(9_999)) + ";fill:var(--a0)}",
         True),
        ("rect{fill:none;fill:" + "var(--a," * 110 + ")" * 110 + "}", True),
        ("rect{--a:" + "x" * 900 + ";fill:none;fill:" + "var(--a)" * 100 + "}", True),
        ("rect{" + ";".join(f"--a{i}:var(--a{(i + 1) % 25})" for i in range(25))
         + ";fill:var(--a9, none)}", False),
    ],
    ids=["laughs", "a chain", "fallbacks", "a long value", "a circle"],
)  # fmt: skip
def test_hostile_custom_properties_take_no_time(css, drawn):
    start = time.perf_counter()
    body = (
        f'<style>{css}</style><circle cx="9" r="1"/><rect width="2" height="2"/>{"<rect/>" * 300}'
    )
    assert area(body) == pytest.approx(np.pi + 4 * drawn, rel=1e-3)
    assert time.perf_counter() - start < 10


def test_scopes_of_custom_properties_do_not_nest_too_deep():
    groups = "".join(
        f'<g style="{";".join(f"--a{i}-{j}:var(--a{i}-{j + 1})" for j in range(29))};'
        f'--a{i}-29:var(--a{i - 1}-0)">'
        for i in range(90)
    )
    body = f'{groups}<rect width="2" height="2" style="fill:var(--a89-0,none)"/>{"</g>" * 90}'
    assert area(ONE + body) == pytest.approx(1)


def test_too_many_references_are_refused():
    css = ";".join(f"--a{i}:{'var(--b,)' * 99}" for i in range(100))
    references = "".join(f"var(--a{i},)" for i in range(70))
    body = f"<style>rect{{{css};fill:{references}}}</style>" + '<rect width="2" height="2"/>' * 999
    with pytest.raises(vf.OverlapError, match=r"more than 100,000 var\(\)"):
        artwork(body)
