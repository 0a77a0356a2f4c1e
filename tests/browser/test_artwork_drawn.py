"""Artwork from SVG is what Chromium draws."""

from __future__ import annotations

from typing import Any

import pytest
from drawn import differing

CASES = {
    "transforms": '<g transform="translate(100 20) rotate(30)"><g transform="scale(1.5 .5)">'
    '<rect x="5" y="5" width="40" height="60" transform="rotate(10 20 20) skewX(20)"/></g></g>',
    "symbols": '<symbol id="a" viewBox="0 0 20 10" preserveAspectRatio="xMinYMax slice">'
    '<rect x="2" y="2" width="15" height="6"/></symbol>'
    '<use href="#a" x="9" width="60" height="90"/>'
    '<use href="#a" x="90" y="90" width="99" height="9" transform="rotate(5)"/>',
    "nested": '<svg x="40" y="30" width="99" height="50" viewBox="0 0 10 10"><circle cx="50%" '
    'cy="50%" r="60%"/><svg viewBox="0 0 4 4"><rect width="2" height="25%"/></svg></svg>',
    "clips": '<style>.k{clip-path:url(#c)}</style><clipPath id="a"><rect x="50" width="200" '
    'height="200"/></clipPath><clipPath id="c" clip-path="url(#a)"><circle cx="60" cy="60" r="30"/>'
    '</clipPath><g clip-path="url(#a)"><rect class="k" x="20" y="20" width="150" height="100"/>'
    '<path d="M0 150H200" stroke="#000" stroke-width="30" transform="skewY(5)"/></g>',
    "styles": "<style>/* .a{} */ #x{fill:black}.a,.b{fill:none}.n .b{fill:black;stroke:black;"
    'stroke-width:9}rect.c{opacity:0}</style><rect id="x" class="a" width="40" height="40"/>'
    '<rect class="a" width="200" height="200"/><g class="n"><circle class="b" cx="99" cy="99" '
    'r="30"/></g><rect class="c" width="200" height="200"/>',
    "joins": '<g fill="none" stroke="#000" stroke-width="18"><path d="M20 80L60 20L99 80"/>'
    '<path d="M20 170L60 110L99 170" stroke-linejoin="round"/><path stroke-linejoin="bevel" '
    'd="M120 80L150 20L180 80"/><path d="M130 180L140 110L150 180" stroke-miterlimit="2"/></g>',
    "caps": '<g fill="none" stroke="#000" stroke-width="24"><path d="M40 50L150 20"/>'
    '<path d="M40 90L150 60" stroke-linecap="round"/><path d="M40 150C40 100 90 100 150 150" '
    'stroke-linecap="square"/><path d="M180 180h0" stroke-linecap="round"/></g>',
    "dashes": '<g fill="none" stroke="#000" stroke-width="12" stroke-dasharray="30 10 5">'
    '<path d="M10 20H190"/><path d="M10 50H190" stroke-dashoffset="15"/><path d="M20 80H180V180'
    'H20Z" stroke-linecap="round" stroke-dasharray="40 25"/></g>',
    "curves": '<g fill="none" stroke="#000" stroke-width="20">'
    '<path d="M20 150C20 20 99 20 99 150"/>'
    '<path d="M130 160C130 60 160 60 160 160" stroke-width="50"/>'
    '<path d="M20 190A60 9 5 1 1 90 190" stroke-width="5"/></g>',
    "pens": '<g fill="none" stroke="#000" stroke-width="6"><g transform="scale(4 2)">'
    '<circle cx="20" cy="30" r="12"/></g><g transform="translate(190 99) skewX(30) scale(-1 1)">'
    '<path d="M0 0L60 20L9 80"/></g><path transform="scale(9 1)" d="M2 190H20" '
    'vector-effect="non-scaling-stroke"/></g>',
    "boxes": '<clipPath id="b" clipPathUnits="objectBoundingBox"><rect x=".1" y=".2" width=".6" '
    'height=".5"/><circle cx=".8" cy=".8" r=".2"/></clipPath><clipPath id="t" clipPathUnits='
    '"objectBoundingBox" transform="rotate(20)"><rect width=".7" height=".7"/></clipPath>'
    '<path d="M20 20C20 90 90 -40 90 60V80H10Z" stroke="#000" stroke-width="9" '
    'clip-path="url(#b)"/>'
    '<g transform="translate(120 20) skewX(10)" clip-path="url(#t)"><rect width="40" height="50"/>'
    '<circle cx="50" cy="60" r="20" transform="rotate(10)"/></g>'
    '<g clip-path="url(#b)"><use href="#u" x="9" clip-path="url(#b)"/><rect x="30" y="170" '
    'width="90" height="20"/></g><rect id="u" x="20" y="110" width="150" height="70"/>',
    "markers": '<marker id="a" viewBox="0 0 10 10" refX="2" refY="5" markerWidth="4" '
    'markerHeight="5" orient="auto" overflow="visible"><path d="M0 0L10 5L0 10Z"/></marker>'
    '<marker id="r" markerWidth="30" markerHeight="20" refX="9" refY="9" orient='
    '"auto-start-reverse" markerUnits="userSpaceOnUse"><path d="M0 0L20 9L0 18Z"/></marker>'
    '<marker id="o" overflow="visible" orient="45"><rect x="-2" y="-2" width="4" height="3"/>'
    '</marker><g fill="none" stroke="#000" stroke-width="6"><path d="M20 20L80 20L80 60'
    'C90 90 50 90 20 70" marker-start="url(#r)" marker-mid="url(#a)" marker-end="url(#a)"/>'
    '<path d="M120 20H170V70Z" style="marker:url(#a)"/><polyline points="20,120 60,150 100,120" '
    'marker-end="url(#r)" marker-start="url(#r)" marker-mid="url(#o)"/>'
    "</g>",
    "markers of groups": '<marker id="a" viewBox="0 0 10 10" refX="2" refY="5" markerWidth="4" '
    'markerHeight="5" orient="auto"><path d="M0 0L10 5L0 10Z"/></marker>'
    '<marker id="o" overflow="visible" orient="45"><rect x="-2" y="-2" width="4" height="3"/>'
    '</marker><g fill="none" stroke="#000" stroke-width="6">'
    '<path d="M130 110A30 30 0 0 1 180 150H140" marker-mid="url(#o)" marker-end="url(#a)"/>'
    '<path d="M20 180h0" stroke-width="4" marker-start="url(#o)"/>'
    '<g marker-end="url(#a)" transform="scale(1 .6)"><path d="M60 300q40 -40 60 0"/></g></g>',
    "smooth": '<path d="M20 90S40 20 80 90S100 160 140 90T190 90T120 120"/>'
    '<path d="M20 190Q40 120 60 190S90 190 120 150T150 190V195H20Z"/>',
    "tight turns": '<g fill="none" stroke="#000" stroke-width="14"><path d="M30 30C38 110 31 110 '
    '36 40"/><path d="M80 40C90.18 -47 82.32 120 83.12 60" stroke-linejoin="round"/>'
    '<path d="M120 90T180 93.3T150 30" transform="skewX(-5)"/>'
    '<rect x="20.1" y="120.3" width="57.45" height="31.87" rx="54.92" stroke-linejoin="bevel"/>'
    '<path d="M104.9 128.83z" stroke-linecap="round"/></g>',
    "dashes of corners": '<g fill="none" stroke="#000" stroke-width="20"><rect x="20" y="20" '
    'width="70" height="70" stroke-dasharray="53 20"/><polygon stroke-linecap="round" points='
    '"155 170 140 70 181 195" stroke-dasharray="7.438 17.94" stroke-dashoffset="54.73"/>'
    '<path d="M20 120H90" stroke-dasharray="10% 5mm"/><path d="M20 150H90" stroke-dasharray="1 2" '
    'pathLength="9"/><path d="M20 180H90" stroke-dasharray="20,"/></g>',
    "boxes of open paths": '<clipPath id="b" clipPathUnits="objectBoundingBox"><circle cx=".5" '
    'cy=".5" r=".4"/></clipPath><path d="M22 77C35 147 85 22 54 142S60 13 116 127S133 28 187 145" '
    'stroke="#000" stroke-width="20" clip-path="url(#b)"/>',
    "inherited shares": '<g stroke="#000" stroke-width="5%" fill="none"><path d="M10 20H190"/>'
    '<svg viewBox="0 0 50 50" width="100" height="100" y="60"><path d="M5 10H45"/></svg></g>',
    "rules": "<style>@media print{rect{fill:none}} g&gt;.b{fill:none} .b{fill:green} "
    'rect[height="9"]{fill:none;fill:nocolour}</style><g><rect id="b" class="b" width="60" '
    'height="50"/></g>'
    '<use href="#b" x="100" y="20"/><rect y="120" width="90" height="9"/>'
    '<rect y="150" width="90" height="30" fill="url(#no)"/>'
    '<rect x="99" y="150" width="90" height="30" fill="url(#no) red"/>',
    "transforms of styles": '<rect x="60" y="30" width="60" height="40" style="transform:'
    'rotate(.1turn) translateX(10%);transform-origin:right 40px"/><symbol id="s" transform='
    '"rotate(9)" viewBox="0 0 0 9"><rect width="90" height="90"/></symbol><use href="#s"/>'
    '<symbol id="t" transform="rotate(9)" viewBox="0 0 9 9"><rect width="9" height="9"/></symbol>'
    '<use href="#t" x="40" y="110" width="60" height="60"/>',
    "arcs": '<path d="M20 20A0 30 0 0 1 90 20V60Z"/><path d="M10 100a50 30 30 01110 20z"/>'
    '<path d="M60 190A-60 40 -20 1 0 100 150Z"/>',
}


@pytest.mark.parametrize("name", CASES)
def test_it_is_what_a_browser_draws(name: str, browser: Any) -> None:
    assert differing(CASES[name], browser) <= 8
