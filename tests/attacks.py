"""Attacks on the package: damaged fonts and images, bombs, slow servers, malformed messages.

``python -m tests.attacks`` runs all of them and prints the table of docs/security.md. Each attack
runs in a process of its own, so that its memory can be measured.
"""

from __future__ import annotations

import argparse
import io
import logging
import multiprocessing
import os
import random
import struct
import sys
import tempfile
import threading
import warnings
import zlib
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import astuple
from itertools import pairwise
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import torch
from fontTools.ttLib import TTFont
from PIL import Image

import vfwidget as vf
from tests import fonts
from tests.attacks_on_motion import dense_artwork, hostile_names, junk_for_motion
from tests.font.test_unpack import BOMB_BYTES, woff2_bomb, woff_bomb
from tests.front_end import FrontEnd
from tests.outcome import Outcome
from vfwidget.matching.images import FORMATS, read_image

BUNDLED = ("dynapuff", "afacad-flux")


def mutated(data: bytes, rng: random.Random) -> bytes:
    """The bytes of a file with some changed, removed, repeated or cut off."""
    changed = bytearray(data)
    kind = rng.randrange(8)
    if kind == 0:
        return bytes(changed[: rng.randrange(len(changed))])
    if kind == 1:
        at, size = rng.randrange(len(changed)), rng.randrange(64)
        del changed[at : at + size]
    elif kind == 2:
        at, size = rng.randrange(len(changed)), rng.randrange(64)
        changed[at:at] = changed[at : at + size]
    for _ in range(rng.choice([1, 1, 2, 8, 32])):
        # Headers and directories matter most.
        end = len(changed) if rng.random() < 0.5 else min(len(changed), 512)
        at = rng.randrange(end)
        changed[at] = rng.choice([0, 255, 127, 128, changed[at] ^ 1 << rng.randrange(8)])
    return bytes(changed)


def font_mutants(count: int) -> Outcome:
    """Damaged files of each container, from fonts that use every feature of outlines."""
    rng = random.Random(0)
    seeds = [*map(fonts.bundled_file, BUNDLED)]
    for data in [*(make() for make in fonts.CASES.values()), *seeds]:
        for flavor in (None, "woff", "woff2") if len(data) < 2**14 else (None, "woff"):
            font, file = TTFont(io.BytesIO(data)), io.BytesIO()
            font.flavor = flavor
            font.save(file)
            seeds.append(file.getvalue())

    def act(data: bytes) -> None:
        font = vf.load_font(data)
        w = np.full(len(font.axes), 0.5)
        for name in rng.sample(font.glyph_names, min(len(font.glyph_names), 4)):
            glyph = font.glyph(name)
            glyph.points(w), glyph.jacobian(w), glyph.side_bearings(w)
        text = vf.Text(font, "aa")
        text.points(), text.jacobian(), repr((font, text, font.instances))

    inputs = (mutated(rng.choice(seeds), rng) for _ in range(count))
    return Outcome("damaged fonts: TTF, WOFF, WOFF2").try_all(inputs, act)


def mutated_table(data: bytes, rng: random.Random) -> bytes:
    """A font file with some bytes of one of its tables changed, mostly of its header."""
    changed = bytearray(data)
    count = int.from_bytes(data[4:6], "big")
    entry = 12 + 16 * rng.randrange(count)
    at, size = struct.unpack(">LL", data[entry + 8 : entry + 16])
    reach = rng.choice([16, 64, size])
    for _ in range(rng.choice([1, 1, 2, 8])):
        place = min(at + rng.randrange(max(1, min(size, reach))), len(changed) - 1)
        changed[place] = rng.choice([0, 255, 1, 128, changed[place] ^ 1 << rng.randrange(8)])
    return bytes(changed)


def format_mutants(count: int) -> Outcome:
    """Damaged tables of small fonts of every format, one table at a time, or the whole file."""
    # The builders of fonts import one another by their plain names, as the tests do.
    sys.path.append(str(Path(__file__).parent))
    import colour_fonts
    import formats
    import varc_fonts
    import variation_tables
    from variation_tables import add_avar_2

    rng = random.Random(5)
    builders = [*formats.VARIABLE.values(), variation_tables.avar_2, varc_fonts.varc]
    builders += [colour_fonts.coloured, colour_fonts.flat_colours]
    builders += [variation_tables.with_mvar, formats.accented_cff]
    seeds = [build() for build in builders]
    seeds.append(variation_tables.with_vertical_metrics(vvar=True))
    seeds += [build(add_avar_2) for build in (colour_fonts.coloured, varc_fonts.varc)]
    whole = formats.collection(seeds[0], seeds[-1])

    def act(data: bytes) -> None:
        font = vf.load_font(data, static=True)
        w = np.full(len(font.axes), 0.5)
        values = font.denormalize(font.final_coordinates(w), final=True)
        font.normalize(values), font.metrics(w), font.describe()
        for name in rng.sample(font.glyph_names, min(len(font.glyph_names), 4)):
            glyph = font.glyph(name)
            glyph.points(w), glyph.jacobian(w), glyph.side_bearings(w)
            if glyph.advance_height is not None:
                glyph.vertical_advance(w)
            for layer in glyph.layers:
                layer.glyph.jacobian(w), layer.paint.at(w)
        text = vf.Text(font, "ab")
        text.points(), text.jacobian(), text.to_svg()

    def inputs() -> Iterator[bytes]:
        for i in range(count):
            if i % 8 == 0:
                yield mutated(rng.choice([*seeds, whole]), rng)
            else:
                yield mutated_table(rng.choice(seeds), rng)

    attack = "damaged tables: CFF, CFF2, GLYF, avar 2, VARC, COLR, CPAL, MVAR, VVAR, TTC"
    return Outcome(attack).try_all(inputs(), act)


def image_mutants(count: int) -> Outcome:
    """Damaged files of each format that is read."""
    rng = random.Random(1)
    Image.init()
    pixels = np.random.default_rng(1).integers(0, 255, (40, 56, 4), np.uint8)
    seeds = []
    for name in FORMATS:
        for mode in ("L", "P", "RGB", "RGBA", "I;16"):
            file = io.BytesIO()
            try:
                Image.fromarray(pixels).convert(mode).save(file, name)
            except (OSError, ValueError, KeyError):
                continue  # The format has no such mode.
            seeds.append(file.getvalue())
        assert seeds, name
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "image")

        def act(data: bytes) -> None:
            path.write_bytes(data)
            read_image(path)

        for seed in seeds:
            act(seed)
        inputs = (mutated(rng.choice(seeds), rng) for _ in range(count))
        return Outcome(f"damaged images: {', '.join(FORMATS)}").try_all(inputs, act)


def font_bombs(count: int) -> Outcome:
    """Fonts of some 100 kB that unpack to more than 256 MiB, whatever size they state."""
    stated = (10 ** (3 + i % 7) for i in range(count))
    bombs = ((woff_bomb if i % 2 else woff2_bomb)(size) for i, size in enumerate(stated))
    # To make the bombs takes memory, too.
    woff_bomb(BOMB_BYTES), woff2_bomb(BOMB_BYTES)
    return Outcome("font bombs: WOFF, WOFF2").try_all(bombs, vf.load_font)


def black_png(width: int, height: int) -> bytes:
    """A PNG file of one bit per pixel, made without a picture in memory."""
    compressor = zlib.compressobj()
    row = bytes(1 + (width + 7) // 8)
    pixels = b"".join(compressor.compress(row) for _ in range(height)) + compressor.flush()
    header = struct.pack(">LLBBBBB", width, height, 1, 0, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", pixels), (b"IEND", b""))
    parts = [struct.pack(">L", len(data)) + tag + data for tag, data in chunks]
    sums = [struct.pack(">L", zlib.crc32(part[4:])) for part in parts]
    return b"\x89PNG\r\n\x1a\n" + b"".join(map(bytes.__add__, parts, sums))


def image_bombs(count: int) -> Outcome:
    """Small files and arrays of very many pixels."""
    rng = random.Random(2)
    with tempfile.TemporaryDirectory() as folder:

        def inputs() -> Iterator[Any]:
            for i in range(count):
                side = rng.choice([1, 6, 100, 20_000])
                other = rng.choice([10**4, 10**5, 10**6]) // (10 if side == 20_000 else 1)
                if i % 2:
                    yield np.broadcast_to(np.uint8(7), (side, other, rng.choice([1, 3, 4, 10**9])))
                else:
                    path = Path(folder, f"{side}.png")
                    path.write_bytes(black_png(other, side))
                    yield path

        def act(image: Any) -> None:
            vf.match(image, "a", "dynapuff", progress=False)

        return Outcome("image bombs: PNG, arrays").try_all(inputs(), act)


SVG = """<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">
<defs><g id="a"><rect x="1" y="2" width="30" height="40" rx="5"/><circle cx="50" r="20"/></g></defs>
<g transform="translate(3 4) rotate(30) scale(2 1.5)"><use xlink:href="#a" x="5"/>
<path d="M10 10 C 20 20 40 20 50 10 A 5 6 30 0 1 70 20 Q 4 5 6 7 T 8 9 Z" style="fill:none"/></g>
<polygon points="1,2 30,4 5,60"/><line x2="9" y2="3" stroke="red" stroke-width="2"/></svg>"""


def artwork(count: int) -> Outcome:
    """Damaged SVG, entities that multiply or read files, groups without end."""
    rng = random.Random(4)
    names = "abcdefghi"
    entities = [f'<!ENTITY {b} "{10 * f"&{a};"}">' for a, b in pairwise(names)]
    hostile = [
        f'<!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa">{"".join(entities)}]><svg><text>&i;</text></svg>',
        '<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///dev/zero">]><svg><path d="&a;"/></svg>',
        SVG.replace("<defs>", 30_000 * "<g>").replace("</defs>", 30_000 * "</g>"),
        SVG.replace('"20"', '"1e308"'),
        SVG.replace("<circle", '<use href="#a"/><circle'),
    ]

    def inputs() -> Iterator[str]:
        for i in range(count):
            mutant = mutated(SVG.encode(), rng).decode("utf-8", "replace")
            yield hostile[i // 50 % len(hostile)] if i % 50 == 0 else mutant

    return Outcome("damaged SVG artwork, entity bombs").try_all(inputs(), vf.Artwork)


def odd_arrays(count: int) -> Outcome:
    """Arrays and tensors of every type, layout and shape."""
    rng = np.random.default_rng(3)
    types = [getattr(torch, name) for name in dir(torch)]
    types = [kind for kind in types if isinstance(kind, torch.dtype)]

    def inputs() -> Iterator[Any]:
        for i in range(count):
            shape = tuple(rng.integers(0, 9, rng.integers(0, 5)).tolist())
            kind = types[rng.integers(len(types))]
            try:
                tensor = torch.empty(shape, dtype=kind, device="meta" if i % 7 == 0 else "cpu")
                yield tensor.to_sparse() if i % 5 == 0 and tensor.ndim else tensor
            except (RuntimeError, NotImplementedError):
                # torch makes no such tensor.
                yield np.full(shape, rng.choice([np.nan, np.inf, 2.0, -1.0, 0.5]), dtype=object)

    return Outcome("arrays and tensors").try_all(inputs(), read_image)


def messages(count: int, threads: int = 1) -> Outcome:
    """Malformed messages of every kind to an editor; each has to be answered exactly once."""
    with mock.patch("comm.create_comm", FrontEnd):
        editor = vf.Editor("dynapuff", "no")
    before = editor.text.theta
    values = [None, True, -1, 0.5, 10**400, float("nan"), "x", [], {}, [0, 0, 0, 0.5], "x" * 10**4]
    names = ["type", "view", "seq", "phase", "handle", "x", "y", "axes"]

    def send(seed: int, outcome: Outcome) -> None:
        rng = random.Random(seed)

        def act(content: Any) -> None:
            editor.comm.custom(content)

        def inputs() -> Iterator[Any]:
            for i in range(count // threads):
                content: Any = {name: rng.choice(values) for name in names if rng.random() < 0.8}
                kind = rng.choice(["drag", "drag", "drag", "undo", "redo", "restart", "tools"])
                yield rng.choice(values) if i % 10 == 0 else content | {"type": kind}

        outcome.try_all(inputs(), act)

    parts = [Outcome("") for _ in range(threads)]
    senders = [threading.Thread(target=send, args=pair) for pair in enumerate(parts)]
    for sender in senders:
        sender.start()
    for sender in senders:
        sender.join()
    whole = Outcome(f"malformed messages, {threads} thread{'s' * (threads > 1)}")
    for part in parts:
        whole.tried += part.tried
        whole.failures += part.failures
        whole.gibibytes = max(whole.gibibytes, part.gibibytes)
        # Threads share the processor time of the process.
        whole.seconds = max(whole.seconds, part.seconds / threads)
    whole.refused = len(editor.comm.replies)
    if whole.refused != whole.tried:
        whole.failures.append(f"{whole.refused} answers to {whole.tried} messages")
    if not torch.isfinite(editor.text.theta).all() or editor.text.theta.shape != before.shape:
        whole.failures.append("the text is not valid any more")
    return whole


def messages_from_four_threads(count: int) -> Outcome:
    """The same messages, four at a time."""
    return messages(count, threads=4)


ATTACKS: dict[Callable[[int], Outcome], int] = {
    font_mutants: 20_000,
    format_mutants: 20_000,
    image_mutants: 20_000,
    font_bombs: 14,
    image_bombs: 100,
    artwork: 5_000,
    dense_artwork: 60,
    junk_for_motion: 1_500,
    hostile_names: 100,
    odd_arrays: 2_000,
    messages: 5_000,
    messages_from_four_threads: 5_000,
}
"""Each attack and its number of inputs."""


def run(attack: Callable[[int], Outcome], count: int) -> Outcome:
    """Run an attack in this process, without the messages of the libraries."""
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
    torch.set_num_threads(1)
    return attack(count)


def run_apart(attack: Callable[[int], Outcome], count: int) -> Outcome:
    """Run an attack in a process of its own."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(run, attack, count).result()


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.attacks", description=__doc__)
    parser.add_argument("--share", type=float, default=1.0, help="share of the inputs to try")
    names = {attack.__name__: attack for attack in ATTACKS}
    parser.add_argument("--only", choices=names, help="run only this attack")
    options = parser.parse_args()
    print("| Attack | Inputs | Refused | Read | Other errors | Slowest | Memory |")
    print("| --- | --: | --: | --: | --: | --: | --: |")
    for attack in [names[options.only]] if options.only else ATTACKS:
        result = run_apart(attack, max(2, round(options.share * ATTACKS[attack])))
        name, tried, refused, read, failures, seconds, gibibytes = astuple(result)
        numbers = f"{tried:,} | {refused:,} | {read:,} | {len(failures)}"
        print(f"| {name} | {numbers} | {seconds:.2f} s | {gibibytes:.2f} GiB |", flush=True)
        for failure in sorted(set(failures))[:20]:
            print(f"    {failure}", flush=True)


if __name__ == "__main__":
    os.environ.setdefault("JUPYTER_PLATFORM_DIRS", "1")
    main()
