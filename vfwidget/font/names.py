"""Strings of the name table; a font may lack the table, or any string of it."""

from __future__ import annotations

from fontTools.ttLib import TTFont


def family_name(font: TTFont) -> str:
    """The best family name, or "Untitled"."""
    return (font["name"].getBestFamilyName() if "name" in font else None) or "Untitled"


def string(font: TTFont, name_id: int) -> str | None:
    """One string of the name table, preferably in English."""
    return font["name"].getDebugName(name_id) if "name" in font else None
