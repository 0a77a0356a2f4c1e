"""Artwork reads values of style sheets as Chromium does."""

from __future__ import annotations

import warnings
from typing import Any

import pytest
from drawn import differing

import vfwidget as vf

TRANSFORMS = (
    "transform:translate(calc(10% - 5px), 1em)",
    "transform:rotate(calc(18deg*2)) scale(calc(1/2))",
    "transform:translate3d(20px,30px,0) scale(120%)",
    "transform:TRANSLATE(5px) Rotate(5DEG)",
    "transform:translate(5px),rotate(5deg)",
    "transform:translate (5px)",
    "transform:rotate(5)",
    "transform:translate(5px)rotate(5deg)",
    "translate:10% 10%",
    "translate:20",
    "translate:20px 30px 40px",
    "rotate:.1turn",
    "rotate:20",
    "rotate:20deg z",
    "rotate:0 0 1 20deg",
    "scale:50% 120%",
    "scale:-1 1;transform-origin:55px 80px",
    "transform:scale(1.5);transform-origin:bottom",
    "transform:scale(1.5);transform-origin:calc(50% - 45px) 80px",
    "transform:rotate(30deg) translate(10px,20px);translate:10px;rotate:10deg;scale:.8",
    "transform:rotate(20deg);transform-box:fill-box;transform-origin:100% 50%",
    "transform:translate(50%,50%);transform-box:fill-box",
    "transform:scale(1.5);transform-box:view-box;transform-origin:50% 50%",
)
LENGTHS = (
    *("calc(50)", "calc(5 + 3px)", "calc(50% - 10px)", "calc(50%-10px)", "calc(50% -10px)"),
    *("calc(3*10px)", "calc(3px*10px)", "calc(90/3px)", "min(50px,20%)", "max(50px,20%,1em)"),
    *("clamp(60px,50px,40px)", "calc(calc(10px) + 10px)", "CALC(10PX + 2EM)", "calc(10px,5px)"),
    *("(10px)", "calc(10px - -5px)", "calc(10px * -2 + 50px)", "20.px", ".5e2px", "20 px", "-5"),
    *("foo", "20Q", "5furlong", "calc(10px + 5deg)", "+20px", "initial", "auto"),
)
GROUPS = {
    "boxes in boxes": '<g transform="translate(20 10)" style="transform-box:fill-box;'
    'transform-origin:center;rotate:20deg"><rect x="20" y="20" width="90" height="30" '
    'style="transform-box:fill-box;transform-origin:right;scale:.5"/>'
    '<circle cx="60" cy="80" r="30"/></g>',
    "viewports": '<svg viewBox="10 10 50 50" width="150" height="100"><rect x="20" y="20" '
    'width="20" height="20" style="translate:10% 10%;rotate:10deg;transform-origin:50% 50%"/>'
    "</svg>",
    "dashes": '<g stroke="#000" stroke-width="9" stroke-dasharray="30 10">'
    '<path d="M10 20H150" stroke-dasharray="20 foo"/><path d="M10 50H150" stroke-dasharray="'
    'calc(9px + 1%), 5"/><path d="M10 80H150" stroke-dasharray="20 -5" stroke-width="4 px"/></g>',
    "long numbers": '<path d="M0 0H50V50A1e200 1e200 0 0 1 5 5V90"/><path transform="translate(60)"'
    ' d="M0 0H50V50A1e30 1e30 0 0 1 5 5V90"/><path transform="translate(0 99)" '
    'd="M0 0H50V50A1e-200 1e-200 0 0 1 5 5V90"/>',
}
SELECTORS = (
    "rect+rect",
    "circle ~ rect",
    "circle + rect",
    "g > rect:first-child",
    "rect:last-child",
    "rect:nth-child(2n)",
    "rect:nth-child(-n+3)",
    "rect:nth-child(3n + 1)",
    "rect:nth-last-child(2)",
    "rect:last-of-type",
    "rect:nth-of-type(2n+1)",
    "circle:only-of-type",
    "circle:only-child",
    "rect:not(.a,.b)",
    "rect:not(.a):not(#r3)",
    ":is(rect,circle).a",
    ":not(g):not(svg):not(style)",
    "rect[class~='c']",
    "rect[class$=c]",
    "rect[class*=' ']",
    "rect[lang|=en]",
    "rect[class=A i]",
    "rect[class^='']",
    "rect[ data-x = '1' ]",
    "rect:empty",
    "g > circle ~ rect.b",
    "svg > g + g rect",
    ".x .a + rect",
    "#r\\33 ",
    "rect:not(:hover)",
    "rect:nth-child(+n)",
    "rect:nth-child(-2n+5)",
    "rect:not()",
    "rect:is()",
    "rect + + rect",
    "rect,",
    ".b:not(g .b)",
    "* + rect",
    ":is(g,svg) > rect",
    "rect:not(:not(.a))",
    "rect:first-child+rect+rect",
    "title + rect",
)
WEIGHTS = (
    "rect{fill:none} rect:not(.zz){fill:red}",
    "rect:not(#q){fill:none} rect.a{fill:red}",
    ":where(#r2,.a){fill:none} rect{fill:red}",
    ":is(#r2,.a){fill:none} rect.a{fill:red}",
    "rect:nth-child(n){fill:none} rect{fill:red}",
    "rect:first-child{fill:none} .a{fill:red}",
    ".a{fill:none} rect:first-child{fill:red}",
)
"""Rules that the more specific one decides."""
VARIABLES = (
    ":root{--a:var(--b);--b:none} rect{fill:var(--a)}",
    ":root{--a:var(--b);--b:var(--a)} rect{fill:var(--a,none)}",
    ":root{--a:var(--b,red);--b:var(--a,red)} rect{fill:var(--a,none)}",
    ":root{--a:red} rect{--a:var(--a)} rect{fill:var(--a,none)}",
    ":root{--a:none} g{--b:var(--a)} rect{--a:red;fill:var(--b)}",
    ":root{--a:none} g{--a:initial} rect{fill:var(--a,red)}",
    ":root{--a:none} g{--a:inherit} rect{fill:var(--a,red)}",
    ":root{--A:none} rect{fill:VAR( --a ,red)}",
    "g{fill:none} rect{fill:red;fill:var(--no)}",
    "rect{fill:none;fill:var(--no)}",
    "rect{width:80px;width:var(--no)}",
    "rect{fill:none;fill:var(--a,)}",
    "rect{fill:var(--a,var(--b,var(--c,none)))}",
    "rect{fill:var(c,none)}",
    "rect{fill:var(--c,none)!important;fill:red}",
    ":root{--c:none!important} svg{--c:red} rect{fill:var(--c)}",
    ":root{--x:10px;--r:10deg} rect{transform:translate(var(--x)) rotate(var(--r,1deg))}",
    ":root{--s:2} rect{scale:var(--s);rotate:calc(var(--s)*5deg)}",
    ":root{--w:20px + 10%} rect{width:calc(var(--w))}",
    ":root{--w:20} rect{width:var(--w)px}",
    ":root{--d:20px 10px} rect{stroke-dasharray:var(--d);stroke:#000;stroke-width:9}",
    ":root{--d:none} rect{display:var(--d)}",
    "g{--c:none} #u{--c:red} rect{fill:var(--c)}",
)
"""Rules with custom properties."""
CLIPS = (
    *("circle()", "circle(30px at 0 0)", "circle(at 20px 50%)", "circle(30)", "circle(-5px)"),
    *("circle(farthest-side at 60% 50%)", "circle(20px at bottom right)", "circle(40%) view-box"),
    *("CIRCLE(20PX AT TOP)", "circle(20px at)", "ellipse(50% 20%)", "ellipse() content-box"),
    *("ellipse(closest-side farthest-side at 30% 30%)", "ellipse(20px)", "inset(5px 10px 15px)"),
    *("inset(10%)", "inset(5px round 10px / 20px)", "inset(0 round 5px 10px 15px 20px / 8px)"),
    *("inset(0 round 90px 90px 10px 10px)", "inset(-10px)", "inset(10)", "inset(60%)"),
    *(
        "polygon(0 0, 100% 0, 50% 100%)",
        "polygon(0 0, 100%)",
        "path(evenodd,'M0 0H50V50H0ZM9 9H4')",
    ),
    *("xywh(10% 10% 50% 50% round 10px)", "rect(10px 60px 40px 5px)", "fill-box", "foo(3px)"),
    *("circle(30px) foo", "circle(50%) margin-box", "inset(10px) stroke-box"),
)
CLIPPED = {
    "groups": '<g style="clip-path:circle(40%);transform:rotate(10deg)"><rect x="50" y="10" '
    'width="80" height="60" style="clip-path:inset(0 round 20px)"/><rect x="50" y="90" width="80" '
    'height="60"/></g>',
    "strokes": '<path style="clip-path:circle(closest-side)" d="M50 50C90 30 70 90 150 150" '
    'fill="none" stroke="#000" stroke-width="20"/>',
    "viewports": '<g/><svg x="20" y="20" width="100" height="80" overflow="visible" '
    'style="clip-path:circle(50%)" viewBox="10 10 50 50"><rect width="80" height="80"/></svg>',
    "inner clip paths": '<clipPath id="k"><rect x="10" y="10" width="50" height="50"/></clipPath>'
    '<svg x="20" y="20" width="100" height="80" overflow="visible" viewBox="0 0 50 40" style='
    '"transform:rotate(5deg)" clip-path="url(#k)"><rect width="150" height="150"/></svg>',
    "symbols": '<clipPath id="k"><rect x="10" y="10" width="50" height="50"/></clipPath><symbol '
    'id="s" viewBox="0 0 50 50" clip-path="url(#k)" overflow="visible"><rect width="50" '
    'height="90"/></symbol><use href="#s" x="20" y="20" width="100" height="100"/>',
    "clips of clips": '<clipPath id="k" style="clip-path:circle(30px at 60px 60px)"><rect x="10" '
    'y="10" width="90" height="90"/></clipPath><rect clip-path="url(#k)" width="150" '
    'height="150"/>',
}
ROW = (
    '<style>@S@{fill:none}</style><rect x="0" y="0" width="190" height="6" id="base" '
    'style="fill:#000!important"/><g class="x"><rect class="a" x="5" y="10" width="20" '
    'height="20"/><rect id="r2" class="b" x="35" y="10" width="20" height="20"/><circle '
    'class="a" cx="75" cy="20" r="10"/><rect id="r3" class="a c" x="95" y="10" width="20" '
    'height="20"/><rect lang="en-US" data-x="1" x="125" y="10" width="20" '
    'height="20"/></g><g><title/><rect class="b" x="5" y="60" width="20" '
    'height="20"><title>x</title></rect><rect class="a b" x="35" y="60" width="20" '
    'height="20"/></g><g class="y"><circle class="c" cx="15" cy="120" r="10"/></g><rect '
    'x="125" y="110" width="20" height="20"/><use href="#u" y="30"/><defs><g id="u" '
    'class="x"><rect class="a" x="5" y="130" width="20" height="20"/><rect class="b" '
    'x="35" y="130" width="20" height="20"/></g></defs>'
)
"""Shapes of which a rule hides some."""


def same(body: str, browser: Any) -> bool:
    """Whether a drawing is that of the browser; warnings about ignored values do not count."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vf.OverlapWarning)
        return differing(body, browser) <= 8


def test_transforms_are_those_of_the_browser(browser: Any) -> None:
    shape = '<path d="M99 0H200V20H99"/><rect width="50" height="40" x="30" y="60" style="{}"/>'
    assert [one for one in TRANSFORMS if not same(shape.format(one), browser)] == []


def test_lengths_are_those_of_the_browser(browser: Any) -> None:
    shapes = (
        '<rect width="99" height="20"/><rect width="{0}" height="40" x="10" y="60"/>'
        '<rect width="33" height="40" x="10" y="120" style="width:{0}"/>'
    )
    assert [one for one in LENGTHS if not same(shapes.replace("{0}", one), browser)] == [
        # In a style, browsers accept numbers without units, but no expressions without units.
        "calc(50)"
    ]


@pytest.mark.parametrize("name", GROUPS)
def test_groups_are_those_of_the_browser(name: str, browser: Any) -> None:
    assert same(GROUPS[name], browser)


def test_selectors_are_those_of_the_browser(browser: Any) -> None:
    sheets = [*(f"{selector}{{fill:none}}" for selector in SELECTORS), *WEIGHTS]
    drawings = {css: ROW.replace("@S@{fill:none}", f"<![CDATA[{css}]]>") for css in sheets}
    assert [css for css, body in drawings.items() if not same(body, browser)] == []


def test_custom_properties(browser: Any) -> None:
    shape = (
        '<path d="M99 0H200V20H99"/><g><rect id="r" width="50" height="40" x="10" y="60"/></g>'
        '<use id="u" href="#r" x="80"/>'
    )
    drawings = {css: f"<style>{css}</style>{shape}" for css in VARIABLES}
    assert [css for css, body in drawings.items() if not same(body, browser)] == []
